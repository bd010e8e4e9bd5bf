//! A socket that takes commands as lines of JSON: the protocol stands in the README.
//!
//! - `service`: what is done at the barrier;
//! - `clients`: connections and their threads;
//! - `message`: from a line to what it asks for.

mod clients;
mod message;
mod service;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use service::{JsonLines, Jsonl};

impl Plugin for JsonLines {
    fn start(host: &Host) -> Result<Self> {
        Ok(JsonLines { time: host.prop("scene.time") })
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.service::<Jsonl>();
    }
}

tatu_plugin! {
    plugin: JsonLines,
    id: "tatu.service.jsonl",
    name: "Commands as lines of JSON",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
