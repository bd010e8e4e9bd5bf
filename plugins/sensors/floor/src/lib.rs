//! Floor sensors: reflectance of several spots below a robot, for line followers.
//!
//! `floor` is the sensor; `spots` computes its rays; `presets` contains the settings of real devices.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "expected values of tests need not be reproducible"))]

mod floor;
mod presets;
mod spots;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use floor::{FloorPlugin, FloorSensor};

impl Plugin for FloorPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(FloorPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<FloorSensor>();
    }
}

tatu_plugin! {
    plugin: FloorPlugin,
    id: "tatu.sensor.floor",
    name: "Floor sensors",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
