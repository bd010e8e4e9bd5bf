//! The ZeroMQ remote API: clients that were written for CoppeliaSim call the commands of a world.
//!
//! - `zmtp`: sockets and ZeroMQ's framing; `cbor`: messages; `catalogue`: what a name space offers;
//! - `clients`: who is there, and how each stands to the steps; `functions`: what clients give to be called back;
//! - `state`: what waits for its turn or an answer; `service`: what is done at the barrier.

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
