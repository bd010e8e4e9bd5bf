//! Laser scanners: distances along fans of beams.
//!
//! `settings` checks the parameters; `laser` defines which beams are cast and how their results are interpreted;
//! `motion` models the motion of the mount during a scan; `presets` contains commercial devices.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "expected values of tests need not be reproducible"))]

mod laser;
mod motion;
mod presets;
mod settings;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use laser::{LaserPlugin, LaserScanner};

impl Plugin for LaserPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(LaserPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<LaserScanner>();
    }
}

tatu_plugin! {
    plugin: LaserPlugin,
    id: "tatu.sensor.laser",
    name: "Laser scanners",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
