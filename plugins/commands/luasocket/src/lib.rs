//! Sockets for scripts: `require 'socket'` gives what LuaSocket's users know.
//!
//! - `sockets`: sockets by number, on the standard library; `permission`: whom a run may reach;
//! - `look`: what a script finds outside is an input of the run;
//! - `streams`, `datagrams`, `clock`: commands that look; `socket.lua`: LuaSocket's objects upon the commands.

mod clock;
mod datagrams;
mod look;
mod permission;
mod plugin;
mod sockets;
mod streams;

use plugin::{LuaSocket, Open};
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
    type World = Open;

    fn world(&self, _: &World<'_>) -> Result<Open> {
        Ok(Open::default())
    }

    const STATE_VERSION: u32 = 1;
    /// A socket cannot be saved: one of a restored world is closed. Its number is not given again.
    fn save(open: &Open) -> Result<Vec<u8>> {
        let sockets =
            open.sockets.try_borrow().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "its sockets are in use"))?;
        Ok(sockets.last.to_le_bytes().to_vec())
    }
    fn load(open: &Open, bytes: &[u8], version: u32) -> Result<()> {
        let last = bytes.try_into().ok().map(i64::from_le_bytes).filter(|_| version == Self::STATE_VERSION);
        let last = last.ok_or_else(|| Fail::unsupported("its sockets were kept by another version"))?;
        let mut sockets =
            open.sockets.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "its sockets are in use"))?;
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
