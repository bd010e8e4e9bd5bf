//! Proximity sensors: the nearest thing along a ray or in a cone.
//!
//! The core casts the beam; `proximity` says which beam to cast and what its answer means.

mod proximity;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result, World},
    tatu_plugin,
};

pub use proximity::Proximity;

/// The plugin; it keeps nothing.
pub struct Proximities;

impl Plugin for Proximities {
    type World = ();

    fn start(_: &Host) -> Result<Self> {
        Ok(Proximities)
    }
    fn world(&self, _: &World<'_>) -> Result<()> {
        Ok(())
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

#[cfg(test)]
mod border_tests;
