//! Laser scanners: distances along fans of beams.
//!
//! `settings` are the parameters, checked; `laser` says which beams to cast and what their answers mean; `motion`
//! is that of the mount during a scan; `presets` are the devices that one can buy.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "what tests compare with decides no bits"))]

mod laser;
mod motion;
mod presets;
mod settings;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use laser::{Laser, Lasers};

impl Plugin for Lasers {
    fn start(_: &Host) -> Result<Self> {
        Ok(Lasers)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<Laser>();
    }
}

tatu_plugin! {
    plugin: Lasers,
    id: "tatu.sensor.laser",
    name: "Laser scanners",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
