//! Force and torque sensors, as in the wrists of arms.
//!
//! `force_torque` is the sensor; `presets` contains the settings of real devices.

mod force_torque;
mod presets;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use force_torque::{ForceTorque, Transducers};

impl Plugin for Transducers {
    fn start(_: &Host) -> Result<Self> {
        Ok(Transducers)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<ForceTorque>();
    }
}

tatu_plugin! {
    plugin: Transducers,
    id: "tatu.sensor.force_torque",
    name: "Force and torque sensors",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
