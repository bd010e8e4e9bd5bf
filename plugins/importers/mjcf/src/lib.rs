//! Importer for MuJoCo models in MJCF files.
//!
//! `xml` and `include` read files into elements, `defaults`, `attributes` and `compiler` interpret their attributes,
//! `read` makes a `model` of them, with `mesh`; `groups` finds the bodies of the scene, `drives` its motors and
//! gears, and `build` creates the objects. `coverage` and `report` say what was omitted.

mod attributes;
mod build;
mod compiler;
mod coverage;
mod defaults;
mod drives;
mod groups;
mod include;
mod mesh;
mod model;
mod read;
mod report;
mod xml;

use tatu_importers_xml::root_name;
use tatu_plugin_api::{
    safe::{Builder, Fail, Host, Importer, Offer, Param, Params, Plugin, Result},
    tatu_plugin,
};

/// The plugin; it has no state.
pub struct MjcfFiles;

impl Plugin for MjcfFiles {
    fn start(_: &Host) -> Result<Self> {
        Ok(MjcfFiles)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.importer::<Mjcf>();
    }
}

/// The importer "mjcf".
pub struct Mjcf;

impl Importer for Mjcf {
    type Plugin = MjcfFiles;
    const ID: &'static str = "mjcf";
    const TEXT: &'static str = "MJCF: MuJoCo models with their bodies, joints, masses, actuators and constraints.";
    const SUFFIXES: &'static [&'static str] = &[".xml", ".mjcf"];

    fn params() -> Vec<Param> {
        vec![
            Param::string("keyframe").default(build::DEFAULT_KEYFRAME).text(
                "Name of the keyframe in which the model starts; a file without it starts in the pose of its bodies.",
            ),
            Param::string("servos").choices(&["spring", "hold"]).default("spring").text(
                "What position actuators become: springs with the gains of the file, which yield under load, or servos \
                 that hold their target with at most the force of the file.",
            ),
            Param::bool("self_collision")
                .default(false)
                .text(
                "Whether bodies of one mechanism collide with each other, by the contact types of the file; not with their \
                 parents.",
            ),
        ]
    }

    fn sniff(head: &[u8]) -> u32 {
        let text = String::from_utf8_lossy(head);
        if root_name(&text).is_some_and(|name| &text[name] == "mujoco") { 90 } else { 0 }
    }

    fn load(bytes: &[u8], builder: &Builder<'_>, params: &Params<'_>) -> Result {
        if bytes.len() > include::MAX_BYTES {
            let text = format!("the file has {} bytes; expected at most {}", bytes.len(), include::MAX_BYTES);
            return Err(Fail::argument(text));
        }
        let (model, mut report) = read::model(builder, bytes)?;
        build::model(builder, &model, &build::ImportSettings::read(params)?, &mut report)?;
        report.print(builder);
        Ok(())
    }
}

tatu_plugin! {
    plugin: MjcfFiles,
    id: "tatu.importer.mjcf",
    name: "MJCF files",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
