//! Inertial measurement units: accelerometer, gyroscope and attitude.
//!
//! `imu` is the sensor; `presets` contains the settings of real devices.

mod imu;
mod presets;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use imu::{Imu, ImuPlugin};

impl Plugin for ImuPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(ImuPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<Imu>();
    }
}

tatu_plugin! {
    plugin: ImuPlugin,
    id: "tatu.sensor.imu",
    name: "Inertial measurement units",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
