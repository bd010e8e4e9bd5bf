//! The legacy remote API of V-REP (`simx...`), by which clients in any language call commands of a world.
//!
//! - `packet`: splits messages into packets; `message`: parses messages; `values`: encodes numbers and strings;
//! - `connections`: connections and their threads; `clients`: the state of clients, such as streamed commands and
//!   synchronous operation;
//! - `ask`: calls commands of the world; `calls`: maps commands of the protocol to them; `groups`: data of all objects
//!   of a type; `files`: transferred files;
//! - `service`: executes commands at the barrier.

mod ask;
mod calls;
mod clients;
mod connections;
mod files;
mod groups;
mod message;
mod packet;
mod service;
mod values;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use service::{LegacyRemote, LegacyRemoteService};

impl Plugin for LegacyRemote {
    fn start(_: &Host) -> Result<Self> {
        Ok(LegacyRemote)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.service::<LegacyRemoteService>();
    }
}

tatu_plugin! {
    plugin: LegacyRemote,
    id: "tatu.service.legacy_remote",
    name: "Legacy remote API",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
