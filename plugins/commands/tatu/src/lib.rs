//! Tatu's own commands, which supplement the V-REP script API: `tatu.on`, `tatu.off`, `tatu.emit`, `tatu.options`,
//! `tatu.list`, `tatu.get`, `tatu.set`, `tatu.properties`, `tatu.read`, `tatu.save`, `tatu.getScript`,
//! `tatu.setScript`, `tatu.addScript`, `tatu.press`, `tatu.open`, `tatu.drive`, `tatu.models`, `tatu.kinds`,
//! `tatu.addModel`, `tatu.add`, `tatu.copy`, `tatu.remove`; and for scene editors: `tatu.edit`, `tatu.undo`,
//! `tatu.redo`, `tatu.edits`, `tatu.saveScene`, `tatu.newScene` and `tatu.recover`.
//!
//! Each file contains the commands of one subject; `tests/program/scripts` tests them through scripts.

mod drive;
mod edits;
mod events;
mod objects;
mod options;
mod plugin;
mod properties;
mod read;
mod save;
mod scenes;

use plugin::Tatu;
use tatu_plugin_api::safe::{Host, Offer, Plugin, Result};

impl Plugin for Tatu {
    fn start(_: &Host) -> Result<Self> {
        Ok(Tatu)
    }
    fn offer(offer: &mut Offer<Self>) {
        drive::offer(offer);
        edits::offer(offer);
        events::offer(offer);
        objects::offer(offer);
        options::offer(offer);
        properties::offer(offer);
        read::offer(offer);
        save::offer(offer);
        scenes::offer(offer);
        // The prelude only declares the prefix of this API's names.
        offer.prelude("lua", "", "return { api = { 'tatu.' } }");
        offer.prelude("lua", "tatu.goals", include_str!("goals.lua"));
    }
}

tatu_plugin_api::tatu_plugin! {
    plugin: Tatu,
    id: "tatu.commands.tatu",
    name: "Tatu's own commands",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
