//! The ZeroMQ remote API, by which clients written for CoppeliaSim call commands of a world.
//!
//! - `zmtp`: ZeroMQ connections; `cbor`: encoding of messages; `catalogue`: lists the members of a namespace;
//! - `clients`: clients, and whether they hold the simulation; `functions`: functions of clients that the world may
//!   call;
//! - `state`: queued and unanswered requests; `service`: executes requests at the barrier.

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

pub use service::{ZmqRemote, ZmqRemoteService};

impl Plugin for ZmqRemote {
    fn start(_: &Host) -> Result<Self> {
        Ok(ZmqRemote)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.service::<ZmqRemoteService>();
    }
}

tatu_plugin! {
    plugin: ZmqRemote,
    id: "tatu.service.zmq_remote",
    name: "ZeroMQ remote API",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
