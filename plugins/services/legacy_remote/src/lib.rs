//! The legacy remote API of V-REP (`simx...`): clients in any language call the commands of a world.
//!
//! - `packet`: messages cut into packets; `message`: headers and commands; `values`: numbers and texts in them;
//! - `connections`: sockets and their threads; `clients`: what each asked for again and again, and how it stands to the steps;
//! - `ask`: commands of the world, called; `calls`: what each command of the protocol means; `groups`: data of many objects at once; `files`: files that they transfer;
//! - `service`: the barrier.

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

pub use service::{LegacyRemote, Remote};

impl Plugin for LegacyRemote {
    fn start(_: &Host) -> Result<Self> {
        Ok(LegacyRemote)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.service::<Remote>();
    }
}

tatu_plugin! {
    plugin: LegacyRemote,
    id: "tatu.service.legacy_remote",
    name: "Legacy remote API",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
