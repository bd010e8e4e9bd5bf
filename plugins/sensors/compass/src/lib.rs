//! Magnetometers, and the heading of a compass.
//!
//! `compass` is the sensor; `presets` contains the settings of real devices.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "expected values of tests need not be reproducible"))]

mod compass;
mod presets;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use compass::{Compass, CompassPlugin};

impl Plugin for CompassPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(CompassPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<Compass>();
    }
}

tatu_plugin! {
    plugin: CompassPlugin,
    id: "tatu.sensor.compass",
    name: "Compasses",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
