//! Importer for scene and model files of V-REP and CoppeliaSim: `.ttt` and `.ttm`.
//!
//! `read` decodes a file and is independent of Tatu; `describe` lists its content; `build` creates the scene.

#![allow(clippy::unit_arg, reason = "a row of a table of tags is one assignment that may fail")]

mod build;
mod describe;
mod dynamics;
mod forms;
mod graphs;
pub mod read;
mod registrations;
mod report;
mod revolution;
mod scripts;
mod sensors;
mod targets;
mod textures;
mod views;

use tatu_plugin_api::{
    safe::{Builder, Fail, Host, Importer, Offer, Param, Params, Plugin, Result, Value},
    tatu_plugin,
};

use read::{file::VrepFile, header::MAGIC};

/// The plugin; it has no state.
pub struct VrepFiles;

impl Plugin for VrepFiles {
    fn start(_: &Host) -> Result<Self> {
        Ok(VrepFiles)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.importer::<VrepScene>();
    }
}

/// The importer "vrep_scene".
pub struct VrepScene;

impl Importer for VrepScene {
    type Plugin = VrepFiles;
    const ID: &'static str = "vrep_scene";
    const TEXT: &'static str =
        "Scenes and models of V-REP 2.6.6 to CoppeliaSim 4.10: objects, dynamics, sensors and scripts.";
    const SUFFIXES: &'static [&'static str] = &[".ttt", ".ttm"];

    fn params() -> Vec<Param> {
        Vec::new()
    }

    fn sniff(head: &[u8]) -> u32 {
        if head.starts_with(MAGIC) { 100 } else { 0 }
    }

    fn load(bytes: &[u8], builder: &Builder<'_>, _: &Params<'_>) -> Result {
        let file = VrepFile::read(bytes).map_err(|e| Fail::argument(e.to_string()))?;
        let report = build::scene(builder, &file)?;
        if builder.is_asked() {
            let mut map = describe::file(&file);
            map.push((Value::text("report"), Value::List(report)));
            builder.describe(&Value::Map(map))?;
        }
        Ok(())
    }
}

tatu_plugin! {
    plugin: VrepFiles,
    id: "tatu.importer.vrep_scene",
    name: "V-REP scenes",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
