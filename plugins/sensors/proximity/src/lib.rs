//! Proximity sensors: the nearest thing along a ray or in a volume.
//!
//! The core casts the beam; `proximity` says what its answer means, `settings` which beam to cast.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "what tests compare with decides no bits"))]

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
