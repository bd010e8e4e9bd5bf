//! Motion planning for scripts: `tatu.plan`, and the interface of CoppeliaSim's module `simOMPL`.
//!
//! A search reads the scene once, into frames and forms of its own; it changes nothing in the scene.
//!
//! - `state`: tasks and state spaces; `constants`: constants of scripts; `arguments`: reads arguments;
//! - `forms`: reads the forms of shapes; `mechanism`: the frames and bodies that states move; `spaces`: state spaces of
//!   objects; `test`: tests of states;
//! - `tasks`: commands that describe a task; `solving`: commands that solve it; `states`: commands on states;
//! - `own`: `tatu.plan`.

mod arguments;
mod constants;
mod forms;
mod mechanism;
mod own;
mod solving;
mod spaces;
mod state;
mod states;
mod tasks;
mod test;

use state::{Planning, PlanningState, SavedState};
use tatu_plugin_api::{
    safe::{Command, Fail, Host, Offer, PerWorld, Plugin, Result, World},
    tatu_plugin,
};

impl Plugin for Planning {
    fn start(host: &Host) -> Result<Self> {
        Ok(Planning::new(host))
    }

    fn offer(offer: &mut Offer<Self>) {
        offer.per_world();
        offer.subject("planning_tasks", tasks::offer);
        offer.subject("planning", |offer| {
            own::offer(offer);
            solving::offer(offer);
        });
        offer.subject("planning_states", states::offer);
        offer.each_command(add_example);
        constants::offer(offer);
        offer.prelude("lua", "", "return { api = { 'simOMPL.' } }");
    }
}

/// The examples of all commands, each below a line `--- NAME`.
const EXAMPLES: [&str; 3] = [
    include_str!("../examples/tasks.lua"),
    include_str!("../examples/solving.lua"),
    include_str!("../examples/states.lua"),
];

/// Adds its example to a command.
fn add_example(command: Command<Planning>) -> Command<Planning> {
    let parts = EXAMPLES.iter().flat_map(|file| file.split("--- "));
    let mut examples = parts.filter_map(|part| part.split_once('\n'));
    match examples.find(|(name, _)| *name == command.name()) {
        Some((_, text)) => command.example(text.trim_end()),
        None => command,
    }
}

impl PerWorld for Planning {
    type World = PlanningState;

    fn world(&self, _: &World<'_>) -> Result<PlanningState> {
        Ok(PlanningState::default())
    }

    const STATE_VERSION: u32 = 1;
    fn save(world: &PlanningState) -> Result<Vec<u8>> {
        postcard::to_stdvec(&*world.borrow()?).map_err(|e| Fail::new(format!("the state could not be saved: {e}")))
    }
    fn load(world: &PlanningState, bytes: &[u8], version: u32) -> Result<()> {
        let saved = postcard::from_bytes::<SavedState>(bytes).ok().filter(|_| version == Self::STATE_VERSION);
        *world.borrow()? = saved.ok_or_else(|| {
            Fail::unsupported("the saved state has an unknown format; another version of the plugin may have saved it")
        })?;
        Ok(())
    }
}

tatu_plugin! {
    plugin: Planning,
    id: "tatu.commands.planning",
    name: "Motion planning of scripts",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
