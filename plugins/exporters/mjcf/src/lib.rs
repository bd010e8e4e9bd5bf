//! Exporter for MuJoCo models in MJCF files: the command `export.mjcf`, also `export.xml`.
//!
//! - `naming`: names of all elements; `masks`: which bodies collide; `geoms`: forms; `inertia`: masses as MuJoCo takes them;
//! - `drives`: actuators, and equations between joints; `attached`: sites, cameras, lights and sensors;
//! - `bodies`: the tree of bodies; `start`: the keyframe; `losses`: what MJCF does not hold; `write`: the file as a whole.

mod attached;
mod bodies;
mod drives;
mod geoms;
mod inertia;
mod losses;
mod masks;
mod naming;
mod start;
mod write;

use tatu_exporters_common::export_command;
use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

struct MjcfExporter;

impl Plugin for MjcfExporter {
    fn start(_: &Host) -> Result<Self> {
        Ok(MjcfExporter)
    }

    fn offer(offer: &mut Offer<Self>) {
        let command = export_command("export.mjcf", write::mjcf)
            .alias("export.xml")
            .subject("export")
            .text("Describes the scene, or an object with all that is below it, as a MuJoCo model, without writing it.")
            .example(include_str!("../examples/export.lua").trim_end());
        offer.command(command);
        offer.prelude("lua", "", "return { api = { 'export.' } }");
    }
}

tatu_plugin! {
    plugin: MjcfExporter,
    id: "tatu.exporter.mjcf",
    name: "MJCF exporter",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
