//! Force and torque sensors, as in the wrists of arms.
//!
//! `force_torque` is the sensor; `presets` contains the settings of real devices.

mod force_torque;
mod presets;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use force_torque::{ForceTorque, ForceTorquePlugin};

impl Plugin for ForceTorquePlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(ForceTorquePlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<ForceTorque>();
    }
}

tatu_plugin! {
    plugin: ForceTorquePlugin,
    id: "tatu.sensor.force_torque",
    name: "Force and torque sensors",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
