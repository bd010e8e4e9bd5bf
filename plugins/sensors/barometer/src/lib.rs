//! Barometers.
//!
//! `barometer` is the sensor; `atmosphere` relates pressure and altitude; `presets` contains the settings of real
//! devices.

pub mod atmosphere;
mod barometer;
mod presets;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use barometer::{Barometer, BarometerPlugin};

impl Plugin for BarometerPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(BarometerPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<Barometer>();
    }
}

tatu_plugin! {
    plugin: BarometerPlugin,
    id: "tatu.sensor.barometer",
    name: "Barometers",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
