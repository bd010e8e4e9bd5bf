//! The ZeroMQ remote API: clients written for CoppeliaSim call commands of a world.
//!
//! - `zmtp`: sockets and the framing of ZeroMQ; `cbor`: messages; `catalogue`: members of a namespace;
//! - `clients`: clients, and whether they hold the simulation; `functions`: functions of clients that are called back;
//! - `state`: requests that wait for their turn or for an answer; `service`: the barrier.

mod catalogue;
mod cbor;
mod clients;
mod functions;
mod service;
mod state;
mod zmtp;

use tatu_plugin_api::{
    safe::{Host, Offer, Plugin, Result},
    tatu_plugin,
};

pub use service::{Remote, ZmqRemote};

impl Plugin for ZmqRemote {
    fn start(_: &Host) -> Result<Self> {
        Ok(ZmqRemote)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.service::<Remote>();
    }
}

tatu_plugin! {
    plugin: ZmqRemote,
    id: "tatu.service.zmq_remote",
    name: "ZeroMQ remote API",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
