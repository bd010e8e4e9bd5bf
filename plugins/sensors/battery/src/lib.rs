//! Batteries, drained by the motor of a joint and by a constant load.
//!
//! `battery` is the sensor; `cells` computes voltage and current; `presets` contains the settings of real devices.

mod battery;
mod cells;
mod presets;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use battery::{Battery, BatteryPlugin};

impl Plugin for BatteryPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(BatteryPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<Battery>();
    }
}

tatu_plugin! {
    plugin: BatteryPlugin,
    id: "tatu.sensor.battery",
    name: "Batteries",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
