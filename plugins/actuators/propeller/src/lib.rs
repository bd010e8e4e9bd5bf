//! Propellers of aircraft, modelled as a rotor whose speed is commanded.

mod propeller;
mod rotor;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use propeller::{Propeller, PropellerPlugin};

impl Plugin for PropellerPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(PropellerPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.actuator::<Propeller>();
    }
}

tatu_plugin! {
    plugin: PropellerPlugin,
    id: "tatu.actuator.propeller",
    name: "Propellers",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
