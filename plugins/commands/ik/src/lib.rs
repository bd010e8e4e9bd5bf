//! Inverse kinematics for scripts, with the interface of CoppeliaSim's module `simIK`.
//!
//! Scripts create an *environment*: frames and joints, which are copied from the scene or created one by one, and
//! groups of tasks. The scene moves only when a script requests this.
//!
//! - `environment`: environments and their parts; `methods`: methods and results by number; `arguments`: reads
//!   arguments, and converts poses;
//! - `environments`, `objects`, `joints`: commands for environments, frames and joints;
//! - `groups`, `elements`: commands for groups and their elements;
//! - `handling`: commands that solve groups; `searches`: commands that find configurations and paths; `jacobians`:
//!   commands that return Jacobians;
//! - `scene_groups`: groups that are part of a scene, as before version 4.1; `scene_commands`: commands for them;
//! - `constants`: constants for scripts.

mod arguments;
mod constants;
mod elements;
mod environment;
mod environments;
mod groups;
mod handling;
mod jacobians;
mod joints;
mod methods;
mod objects;
mod scene_commands;
mod scene_groups;
mod searches;

use environment::{Environments, Ik, SavedState};
use tatu_kinematics_common::SceneProps;
use tatu_plugin_api::{
    safe::{Command, Fail, Host, Offer, PerWorld, Plugin, Result, World},
    tatu_plugin,
};

impl Plugin for Ik {
    fn start(host: &Host) -> Result<Self> {
        Ok(Ik { props: SceneProps::new(host) })
    }

    fn offer(offer: &mut Offer<Self>) {
        offer.per_world();
        offer.subject("ik_objects", |offer| {
            environments::offer(offer);
            objects::offer(offer);
        });
        offer.subject("ik_joints", joints::offer);
        offer.subject("ik_tasks", |offer| {
            groups::offer(offer);
            elements::offer(offer);
        });
        offer.subject("ik", |offer| {
            handling::offer(offer);
            searches::offer(offer);
            jacobians::offer(offer);
        });
        offer.subject("ik_groups", scene_commands::offer);
        offer.each_command(add_example);
        constants::offer(offer);
        offer.prelude("lua", "", "return { api = { 'simIK.' } }");
    }
}

/// The examples of all commands, each below a line `--- NAME`.
const EXAMPLES: [&str; 3] = [
    include_str!("../examples/objects.lua"),
    include_str!("../examples/groups.lua"),
    include_str!("../examples/scene_groups.lua"),
];

/// Adds the example in [`EXAMPLES`] to a command.
fn add_example(command: Command<Ik>) -> Command<Ik> {
    let parts = EXAMPLES.iter().flat_map(|file| file.split("--- "));
    let mut examples = parts.filter_map(|part| part.split_once('\n'));
    match examples.find(|(name, _)| *name == command.name()) {
        Some((_, text)) => command.example(text.trim_end()),
        None => command,
    }
}

impl PerWorld for Ik {
    type World = Environments;

    fn world(&self, _: &World<'_>) -> Result<Environments> {
        Ok(Environments::default())
    }

    const STATE_VERSION: u32 = 1;
    fn save(world: &Environments) -> Result<Vec<u8>> {
        postcard::to_stdvec(&*world.borrow()?).map_err(|e| Fail::new(format!("the state could not be saved: {e}")))
    }
    fn load(world: &Environments, bytes: &[u8], version: u32) -> Result<()> {
        let saved = postcard::from_bytes::<SavedState>(bytes).ok().filter(|_| version == Self::STATE_VERSION);
        *world.borrow()? = saved.ok_or_else(|| {
            Fail::unsupported("the saved state has an unknown format; another version of the plugin may have saved it")
        })?;
        Ok(())
    }
}

tatu_plugin! {
    plugin: Ik,
    id: "tatu.commands.ik",
    name: "Inverse kinematics of scripts",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
