//! Contact sensors: bumpers and feet.
//!
//! `contact` is the sensor; `presets` contains the settings of real devices.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "expected values of tests need not be reproducible"))]

mod contact;
mod presets;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use contact::{Contact, Skins};

impl Plugin for Skins {
    fn start(_: &Host) -> Result<Self> {
        Ok(Skins)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<Contact>();
    }
}

tatu_plugin! {
    plugin: Skins,
    id: "tatu.sensor.contact",
    name: "Contact sensors",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
