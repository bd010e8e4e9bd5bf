//! Depth and colour cameras: an ideal one, and models of real devices.
//!
//! The core renders the image. `camera` is the sensor, `settings` checks its parameters, `presets` contains devices,
//! and `optics` models the effects of structured light and time of flight at edges, in shadows and on slanted surfaces.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "expected values of tests need not be reproducible"))]

mod camera;
mod optics;
mod presets;
mod settings;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use camera::{DepthCamera, DepthCameraPlugin};

impl Plugin for DepthCameraPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(DepthCameraPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<DepthCamera>();
    }
}

tatu_plugin! {
    plugin: DepthCameraPlugin,
    id: "tatu.sensor.depth_camera",
    name: "Depth cameras",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
