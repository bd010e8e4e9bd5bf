//! ZeroMQ sockets for scripts, with the interface of CoppeliaSim's module `simZMQ`.
//!
//! - `errors`, `options`, `kinds`: errors, options and socket types of ZeroMQ; `endpoint`: addresses and permissions;
//! - `queue`, `routing`: the state of a socket, and the routing of its messages; `stream`, `links`: connections and
//!   their threads;
//! - `operation`: calls that may wait; `world`: the contexts, sockets and messages of a world;
//! - `recording`: records the results of network access as inputs of the run;
//! - `transfer`, `sockets`, `messages`: the commands.

mod endpoint;
mod errors;
mod kinds;
mod links;
mod messages;
mod operation;
mod options;
mod queue;
mod recording;
mod routing;
mod sockets;
mod stream;
mod transfer;
mod world;

use tatu_plugin_api::{
    safe::{Fail, Host, Offer, PerWorld, Plugin, Result, World},
    tatu_plugin,
};
use world::{SavedState, Shared, WorldState, Zmq};

impl Plugin for Zmq {
    fn start(host: &Host) -> Result<Self> {
        Ok(Zmq { allow: host.prop("scene.allow") })
    }

    fn offer(offer: &mut Offer<Self>) {
        offer.per_world();
        offer.subject("zmq", |offer| {
            sockets::offer(offer);
            transfer::offer(offer);
            messages::offer(offer);
        });
        offer.prelude("lua", "", "return { api = { 'simZMQ.' } }");
    }
}

impl PerWorld for Zmq {
    type World = Shared;

    fn world(&self, _: &World<'_>) -> Result<Shared> {
        Ok(Shared::default())
    }

    const STATE_VERSION: u32 = 1;
    fn save(world: &Shared) -> Result<Vec<u8>> {
        serde_json::to_vec(&world.borrow()?.saved).map_err(|e| Fail::new(format!("the state could not be saved: {e}")))
    }
    fn load(world: &Shared, bytes: &[u8], version: u32) -> Result<()> {
        let saved = serde_json::from_slice::<SavedState>(bytes).ok().filter(|_| version == Self::STATE_VERSION);
        let saved = saved.ok_or_else(|| {
            Fail::unsupported("the saved state has an unknown format; another version of the plugin may have saved it")
        })?;
        let mut world = world.borrow()?;
        *world = WorldState::default();
        world.saved = saved;
        Ok(())
    }
}

tatu_plugin! {
    plugin: Zmq,
    id: "tatu.commands.zmq",
    name: "ZeroMQ sockets of scripts",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
