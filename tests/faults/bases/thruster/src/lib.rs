//! Thrusters: rockets, propellers and cold-gas jets, modelled as a force along +z on a body.

mod thruster;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use thruster::{Thruster, Thrusters};

impl Plugin for Thrusters {
    fn start(_: &Host) -> Result<Self> {
        Ok(Thrusters)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.actuator::<Thruster<false>>();
        offer.actuator::<Thruster<true>>();
    }
}

tatu_plugin! {
    plugin: Thrusters,
    id: "tatu.actuator.thruster",
    name: "Thrusters",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
