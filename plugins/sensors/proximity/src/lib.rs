//! Proximity sensors: the nearest surface along a ray or in a volume.
//!
//! The core casts the beams; `settings` defines which beams to cast, `proximity` interprets the results.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "expected values of tests need not be reproducible"))]

mod proximity;
mod settings;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use proximity::{Proximities, Proximity};

impl Plugin for Proximities {
    fn start(_: &Host) -> Result<Self> {
        Ok(Proximities)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<Proximity>();
    }
}

tatu_plugin! {
    plugin: Proximities,
    id: "tatu.sensor.proximity",
    name: "Proximity sensors",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
