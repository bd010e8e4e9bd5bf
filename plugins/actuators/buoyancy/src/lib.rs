//! Buoyancy and drag of bodies in water.

mod buoyancy;
mod hull;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use buoyancy::{Buoyancy, Water};

impl Plugin for Water {
    fn start(_: &Host) -> Result<Self> {
        Ok(Water)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.actuator::<Buoyancy>();
    }
}

tatu_plugin! {
    plugin: Water,
    id: "tatu.actuator.buoyancy",
    name: "Buoyancy",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
