//! Kinematics and dynamics of the mechanisms of a scene: `tatu.kin`, `tatu.getState`, `tatu.setState` and
//! `tatu.linearize`.
//!
//! - `mechanism`: the tree of links below an object of the scene; `state`: its positions and velocities;
//! - `plugin`: the mechanism of a call, and its arguments;
//! - `dynamics`: Jacobians and equations of motion; `states`: getting and setting states; `linear`: linear models;
//! - `inverse`: inverse kinematics.

mod dynamics;
mod inverse;
mod linear;
mod mechanism;
mod plugin;
mod state;
mod states;

use plugin::Kin;
use tatu_plugin_api::{
    safe::{Command, Host, Offer, Plugin, Result},
    tatu_plugin,
};

impl Plugin for Kin {
    fn start(host: &Host) -> Result<Self> {
        Ok(Kin::new(host))
    }

    fn offer(offer: &mut Offer<Self>) {
        offer.subject("kin", |offer| {
            dynamics::offer(offer);
            states::offer(offer);
            linear::offer(offer);
            inverse::offer(offer);
        });
        offer.each_command(add_example);
    }
}

/// The examples of all commands, each below a line `--- NAME`.
const EXAMPLES: &str = include_str!("../examples/kin.lua");

/// Adds its example to a command.
fn add_example(command: Command<Kin>) -> Command<Kin> {
    let mut examples = EXAMPLES.split("--- ").filter_map(|part| part.split_once('\n'));
    match examples.find(|(name, _)| *name == command.name()) {
        Some((_, text)) => command.example(text.trim_end()),
        None => command,
    }
}

tatu_plugin! {
    plugin: Kin,
    id: "tatu.commands.kin",
    name: "Kinematics and dynamics of mechanisms",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
