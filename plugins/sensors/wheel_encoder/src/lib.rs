//! Incremental encoders: ticks of a joint.
//!
//! `encoder` is the sensor; `presets` contains the settings of real devices.

mod encoder;
mod presets;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use encoder::{WheelEncoder, WheelEncoderPlugin};

impl Plugin for WheelEncoderPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(WheelEncoderPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.sensor::<WheelEncoder>();
    }
}

tatu_plugin! {
    plugin: WheelEncoderPlugin,
    id: "tatu.sensor.wheel_encoder",
    name: "Wheel encoders",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
