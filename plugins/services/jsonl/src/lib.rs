//! A service that accepts commands as lines of JSON; the README describes the protocol.
//!
//! - `service`: executes the requests of clients at the barrier;
//! - `clients`: connections and their threads;
//! - `message`: parses the lines that clients send.

mod clients;
mod message;
mod service;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use service::{JsonLines, JsonlService};

impl Plugin for JsonLines {
    fn start(host: &Host) -> Result<Self> {
        Ok(JsonLines { time: host.prop("scene.time") })
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.service::<JsonlService>();
    }
}

tatu_plugin! {
    plugin: JsonLines,
    id: "tatu.service.jsonl",
    name: "Commands as lines of JSON",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
