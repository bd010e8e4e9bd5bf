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

pub use proximity::{ProximityPlugin, ProximitySensor};

impl Plugin for ProximityPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(ProximityPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<ProximitySensor>();
    }
}

tatu_plugin! {
    plugin: ProximityPlugin,
    id: "tatu.sensor.proximity",
    name: "Proximity sensors",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
