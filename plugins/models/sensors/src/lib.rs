//! Sensors as V-REP's library has them: their objects, under the names that scripts ask for, and scripts that do what
//! theirs do.
//!
//! One file per device; `parts` has what they share. The scripts stand in `lua/`.

mod fast_hokuyo;
mod gps;
mod hokuyo;
mod kinect;
mod parts;
mod sick;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use parts::Devices;

impl Plugin for Devices {
    fn start(_: &Host) -> Result<Self> {
        Ok(Devices)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.model::<sick::LaserScanner2d>();
        offer.model::<sick::Sick>();
        offer.model::<hokuyo::Hokuyo>();
        offer.model::<fast_hokuyo::FastHokuyo>();
        offer.model::<gps::Gps>();
        offer.model::<kinect::Kinect>();
    }
}

tatu_plugin! {
    plugin: Devices,
    id: "tatu.model.sensors",
    name: "Sensors as in V-REP",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
