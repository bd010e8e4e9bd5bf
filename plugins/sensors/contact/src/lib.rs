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

pub use contact::{ContactPlugin, ContactSensor};

impl Plugin for ContactPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(ContactPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<ContactSensor>();
    }
}

tatu_plugin! {
    plugin: ContactPlugin,
    id: "tatu.sensor.contact",
    name: "Contact sensors",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
