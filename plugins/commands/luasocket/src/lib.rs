//! Sockets for scripts: `require 'socket'` provides the interface of LuaSocket.
//!
//! - `sockets`: numbered sockets, built on the standard library;
//! - `recording`: checks permissions and records the results of network and clock access as inputs of the run;
//! - `streams`, `datagrams`, `clock`: commands for TCP, UDP, and host names and time; `socket.lua`: LuaSocket's
//!   objects, built on the commands.

mod clock;
mod datagrams;
mod plugin;
mod recording;
mod sockets;
mod streams;

use plugin::{LuaSocket, WorldSockets};
use sockets::Sockets;
use tatu_plugin_api::{
    abi::TATU_ERR_BUSY,
    safe::{Fail, Host, Offer, PerWorld, Plugin, Result, World},
    tatu_plugin,
};

impl Plugin for LuaSocket {
    fn start(host: &Host) -> Result<Self> {
        Ok(LuaSocket {
            allow: host.prop("scene.allow"),
            clock: host.prop("scene.clock"),
            epoch: host.prop("scene.epoch"),
        })
    }

    fn offer(offer: &mut Offer<Self>) {
        offer.per_world();
        offer.subject("luasocket", |offer| {
            streams::offer(offer);
            datagrams::offer(offer);
            clock::offer(offer);
        });
        offer.prelude("lua", "", "return { api = { 'luasocket.' }, lacking = { 'socket', 'ltn12', 'mime' } }");
        offer.prelude("lua", "socket", include_str!("socket.lua"));
        offer.prelude("lua", "socket.core", "return require 'socket'");
    }
}

impl PerWorld for LuaSocket {
    type World = WorldSockets;

    fn world(&self, _: &World<'_>) -> Result<WorldSockets> {
        Ok(WorldSockets::default())
    }

    const STATE_VERSION: u32 = 1;
    /// Saves only the last socket number. Open sockets cannot be saved: they are closed in a restored world, and their
    /// numbers are not reused.
    fn save(open: &WorldSockets) -> Result<Vec<u8>> {
        let sockets =
            open.sockets.try_borrow().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "a command is using the sockets"))?;
        Ok(sockets.last.to_le_bytes().to_vec())
    }
    fn load(open: &WorldSockets, bytes: &[u8], version: u32) -> Result<()> {
        let last = bytes.try_into().ok().map(i64::from_le_bytes).filter(|_| version == Self::STATE_VERSION);
        let last = last.ok_or_else(|| {
            Fail::unsupported("the saved state has an unknown format; another version of the plugin may have saved it")
        })?;
        let mut sockets = open
            .sockets
            .try_borrow_mut()
            .map_err(|_| Fail::with_code(TATU_ERR_BUSY, "a command is using the sockets"))?;
        *sockets = Sockets::default();
        sockets.last = last;
        Ok(())
    }
}

tatu_plugin! {
    plugin: LuaSocket,
    id: "tatu.commands.luasocket",
    name: "Sockets of scripts",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
