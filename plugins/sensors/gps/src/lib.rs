//! Satellite receivers (GPS): position and velocity of an antenna, in the world frame and on Earth.
//!
//! `gps` is the sensor; `earth` converts the world's coordinates to latitude, longitude and height; `presets` contains
//! the settings of real devices.

pub mod earth;
mod gps;
mod presets;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use gps::{Gps, GpsPlugin};

impl Plugin for GpsPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(GpsPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<Gps>();
    }
}

tatu_plugin! {
    plugin: GpsPlugin,
    id: "tatu.sensor.gps",
    name: "Satellite receivers",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
