//! Buoyancy and drag of bodies in water.

mod buoyancy;
mod hull;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use buoyancy::{Buoyancy, BuoyancyPlugin};

impl Plugin for BuoyancyPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(BuoyancyPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.actuator::<Buoyancy>();
    }
}

tatu_plugin! {
    plugin: BuoyancyPlugin,
    id: "tatu.actuator.buoyancy",
    name: "Buoyancy",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
