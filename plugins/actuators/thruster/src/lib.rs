//! Thrusters: rockets, propellers and cold-gas jets, modelled as a force on a body along +z.

mod thruster;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use thruster::{Thruster, ThrusterPlugin};

impl Plugin for ThrusterPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(ThrusterPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.actuator::<Thruster<false>>();
        offer.actuator::<Thruster<true>>();
    }
}

tatu_plugin! {
    plugin: ThrusterPlugin,
    id: "tatu.actuator.thruster",
    name: "Thrusters",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
