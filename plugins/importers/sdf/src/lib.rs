//! Importer for robots and worlds in SDF files, the format of Gazebo.
//!
//! `text` repairs what a strict reader refuses, `xml` parses it, and `files` replaces includes by the models that they
//! name. `model` collects models with their links and joints, and `frames` resolves poses; `shapes` reads links, `joints`
//! joints, `controllers` the plugins that move them, `propellers` those that fly, and `world` the rest. `build` creates the
//! objects, with the crate `tatu-importers-robots`, which also has the sensors; `coverage` says what is not read.

mod build;
mod controllers;
mod coverage;
mod files;
mod frames;
mod joints;
mod model;
mod propellers;
mod shapes;
mod text;
mod world;
mod xml;

use files::{MAX_BYTES, SourceFiles};
use tatu_importers_robots::Findings;
use tatu_importers_xml::root_name;
use tatu_plugin_api::{
    safe::{Builder, Fail, Host, Importer, Offer, Param, Params, Plugin, Result},
    tatu_plugin,
};

/// The plugin; it has no state.
pub struct SdfFiles;

impl Plugin for SdfFiles {
    fn start(_: &Host) -> Result<Self> {
        Ok(SdfFiles)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.importer::<Sdf>();
    }
}

/// The importer "sdf".
pub struct Sdf;

impl Importer for Sdf {
    type Plugin = SdfFiles;
    const ID: &'static str = "sdf";
    const TEXT: &'static str = "SDF: Gazebo's models and worlds with their links, joints, masses, sensors and lights.";
    const SUFFIXES: &'static [&'static str] = &[".sdf", ".world"];

    fn params() -> Vec<Param> {
        vec![
            Param::bool("fixed_base").default(false).text("Whether the root link of each model is fixed."),
            Param::bool("on_floor").default(false).text(
                "Whether each model is raised or lowered so that the lowest point of its collision shapes is at the \
                 height where the file is placed.",
            ),
            Param::string("motors").choices(&["auto", "velocity", "position", "free"]).default("auto").text(
                "Initial mode of motors: velocity 0; the position at the start; or off. auto: as the plugins of the \
                 file control them, and off without one.",
            ),
            Param::float("default_effort").range(0.0, 1e9).optional().text(
                "Effort of the motors of joints whose file states none, 0 or a negative one, N m or N; 0: such joints \
                 have no motor. Default: as for URDF files, enough to lift or push the robot.",
            ),
            Param::bool("wheels_as_balls").default(true).text(
                "Whether cylinders on continuous joints about their own horizontal axis collide as spheres, which roll \
                 more accurately.",
            ),
            Param::bool("concave").default(false).text(
                "Whether meshes of moving links collide with their hollows, instead of as convex hulls, which are \
                 faster and more robust. Meshes of static models always do.",
            ),
            Param::int("decompose").range(0.0, 64.0).default(0).text(
                "Greatest number of convex parts into which a colliding mesh is divided, so that hollows stay open; 0: \
                 one hull. Takes up to seconds for each mesh.",
            ),
            Param::bool("self_collision").optional().text(
                "Whether links of a model collide with each other, except those that a joint connects; default: as the \
                 file states.",
            ),
        ]
    }

    fn sniff(head: &[u8]) -> u32 {
        let text = String::from_utf8_lossy(head);
        let text = text.trim_start_matches('\u{feff}').trim_start();
        match root_name(text).map(|name| &text[name]) {
            Some("sdf") => 90,
            // The root of version 1.2 and before.
            Some("gazebo") => 70,
            // Comments that a strict reader refuses can precede the root.
            None if text.contains("<sdf") => 60,
            _ => 0,
        }
    }

    fn load(bytes: &[u8], builder: &Builder<'_>, params: &Params<'_>) -> Result {
        if bytes.len() > MAX_BYTES {
            return Err(Fail::argument(format!("the file has {} bytes; expected at most {MAX_BYTES}", bytes.len())));
        }
        let findings = Findings::default();
        let mut files = SourceFiles::new(builder);
        let root = files.read(bytes, &findings).map_err(|e| files.located(e))?;
        build::file(builder, &root, &files, params, &findings).map_err(|e| files.located(e))?;
        findings.report(builder, |line| files.origin(line));
        Ok(())
    }
}

tatu_plugin! {
    plugin: SdfFiles,
    id: "tatu.importer.sdf",
    name: "SDF files",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}

#[cfg(test)]
mod tests;
