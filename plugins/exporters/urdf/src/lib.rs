//! Exporter for robots in URDF files: the command `export.urdf`.
//!
//! - `robot`: chooses the bodies that form the robot, and their links; `joints`: writes joints;
//! - `geometry`: writes forms; `losses`: what URDF does not hold; `write`: the file as a whole.

mod geometry;
mod joints;
mod losses;
mod robot;
mod write;

use tatu_exporters_common::export_command;
use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

struct UrdfExporter;

impl Plugin for UrdfExporter {
    fn start(_: &Host) -> Result<Self> {
        Ok(UrdfExporter)
    }

    fn offer(offer: &mut Offer<Self>) {
        let command = export_command("export.urdf", write::urdf)
            .subject("export")
            .text("Describes a robot of the scene as a URDF file, without writing it.")
            .notes("The scene as a whole must contain a single robot.")
            .example(include_str!("../examples/export.lua").trim_end());
        offer.command(command);
        offer.prelude("lua", "", "return { api = { 'export.' } }");
    }
}

tatu_plugin! {
    plugin: UrdfExporter,
    id: "tatu.exporter.urdf",
    name: "URDF exporter",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
