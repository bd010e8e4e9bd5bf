//! Lets scripts start external programs if the user allows it, and provides a substitute for the server of a V-REP
//! tutorial.
//!
//! - `launch`: the command `sim.launchExecutable`;
//! - `bubblerob`: the server program of V-REP's BubbleRob tutorial.

mod bubblerob;
mod launch;
mod plugin;

use plugin::{Programs, ServerGuard};
use tatu_plugin_api::{
    safe::{Host, Offer, PerWorld, Plugin, Result, World},
    tatu_plugin,
};

impl Plugin for Programs {
    fn start(host: &Host) -> Result<Self> {
        Ok(Programs { allow: host.prop("scene.allow"), file: host.prop("scene.file") })
    }

    fn offer(offer: &mut Offer<Self>) {
        offer.per_world();
        offer.subject("programs", launch::offer);
    }
}

impl PerWorld for Programs {
    type World = ServerGuard;

    fn world(&self, _: &World<'_>) -> Result<ServerGuard> {
        Ok(ServerGuard::default())
    }

    const STATE_VERSION: u32 = 1;
    /// Saves nothing, because external programs are not part of the world.
    fn save(_: &ServerGuard) -> Result<Vec<u8>> {
        Ok(Vec::new())
    }
    fn load(_: &ServerGuard, _: &[u8], _: u32) -> Result<()> {
        Ok(())
    }
}

tatu_plugin! {
    plugin: Programs,
    id: "tatu.commands.programs",
    name: "Programs started by scripts",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
