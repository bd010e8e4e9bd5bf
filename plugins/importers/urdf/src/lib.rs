//! Importer for robots in URDF files.
//!
//! `source` expands xacro files, `xml` parses the text, `read` reads the robot in it, `sensors` builds those of `<gazebo>`, `settings` has the parameters. The
//! crate `tatu-importers-robots` builds the robot.

mod read;
mod sensors;
mod settings;
mod source;
mod xml;

use read::UrdfFile;
use source::SourceText;
use tatu_importers_robots::{BodyTree, Findings, build};
use tatu_importers_xml::root_name;
use tatu_plugin_api::{
    safe::{Builder, Fail, Host, Importer, Offer, Param, Params, Plugin, Result},
    tatu_plugin,
};

/// Maximum size of the XML in bytes, without mesh files.
const MAX_BYTES: usize = 1 << 24;

/// The plugin; it has no state.
pub struct UrdfFiles;

impl Plugin for UrdfFiles {
    fn start(_: &Host) -> Result<Self> {
        Ok(UrdfFiles)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.importer::<Urdf>();
    }
}

/// The importer "urdf".
pub struct Urdf;

impl Importer for Urdf {
    type Plugin = UrdfFiles;
    const ID: &'static str = "urdf";
    const TEXT: &'static str = "URDF and xacro: a robot's links, joints, masses and meshes, in the poses of the file.";
    const SUFFIXES: &'static [&'static str] = &[".urdf", ".xacro"];

    fn params() -> Vec<Param> {
        settings::params()
    }

    fn sniff(head: &[u8]) -> u32 {
        let text = String::from_utf8_lossy(head);
        // Other formats, such as SDF, also contain <robot>, but not as the root element.
        if root_name(&text).is_some_and(|name| &text[name] == "robot") { 80 } else { 0 }
    }

    fn load(bytes: &[u8], builder: &Builder<'_>, params: &Params<'_>) -> Result {
        if bytes.len() > MAX_BYTES {
            return Err(Fail::argument(format!("the file has {} bytes; expected at most {MAX_BYTES}", bytes.len())));
        }
        let text = std::str::from_utf8(bytes).map_err(|e| {
            let line = bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count() + 1;
            Fail::argument("the file is not valid UTF-8 text").at("", line as u64)
        })?;
        let findings = Findings::default();
        let source = SourceText::new(text, &params.string("arguments")?, builder)?;
        let built = || {
            let UrdfFile { robot, sensors } = read::file(&source.text, &findings)?;
            let tree = BodyTree::new(&robot)?;
            let settings = settings::read(params, &robot, &tree)?;
            let built = build(builder, None, &robot, &tree, &settings, &findings)?;
            sensors::build_sensors(builder, &robot, &built, &sensors, &findings);
            Ok(())
        };
        built().map_err(|e| source.located(e))?;
        findings.report(builder, |line| source.origin(line));
        Ok(())
    }
}

tatu_plugin! {
    plugin: UrdfFiles,
    id: "tatu.importer.urdf",
    name: "URDF files",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}

#[cfg(test)]
mod tests;
