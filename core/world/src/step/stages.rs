//! Runs a single stage, for the step itself or for a driver.

use std::borrow::Cow;

use tatu_plugin_api::abi::*;

use super::{physics::physics, sensors::sense};
use crate::{
    cell::{Caller, Phase, Scripts, WorldCell},
    events,
    parts::{self, Moment},
};

/// A stage of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stage {
    Actuate = TATU_STAGE_ACTUATE as isize,
    Physics = TATU_STAGE_PHYSICS as isize,
    Sense = TATU_STAGE_SENSE as isize,
    React = TATU_STAGE_REACT as isize,
    Clean = TATU_STAGE_CLEAN as isize,
}

impl Stage {
    /// Returns the stage that a value of `TATU_STAGE_*` denotes.
    pub fn of(number: u32) -> Option<Self> {
        [Stage::Actuate, Stage::Physics, Stage::Sense, Stage::React, Stage::Clean]
            .into_iter()
            .find(|s| *s as u32 == number)
    }
    fn name(self) -> &'static str {
        match self {
            Stage::Actuate => "actuate",
            Stage::Physics => "physics",
            Stage::Sense => "sense",
            Stage::React => "react",
            Stage::Clean => "clean",
        }
    }
}

/// Pops the stage and restores the caller on drop, including when unwinding.
struct StageGuard<'a>(&'a WorldCell, Caller);

impl Drop for StageGuard<'_> {
    fn drop(&mut self) {
        self.0.run.calls.caller.set(self.1);
        if let Ok(mut stages) = self.0.run.stages.try_borrow_mut() {
            stages.pop();
        }
    }
}

/// Runs a stage immediately; `who` is the name of the caller that requests it. Fails if the stage is running already,
/// with the chain of requests in the message, or if a caller further up the stack has borrowed a part of the world.
pub(crate) fn run(world: &WorldCell, stage: Stage, dt: f64, who: impl Into<Cow<'static, str>>) -> Result<(), String> {
    let who = who.into();
    {
        let mut stages =
            world.run.stages.try_borrow_mut().map_err(|_| "a stage cannot run until the running call has returned")?;
        if stages.iter().any(|(s, _)| *s == stage as u32) {
            let mut chain = String::new();
            for (s, asked) in stages.iter() {
                chain += &format!("{asked} -> {} -> ", Stage::of(*s).map_or("?", Stage::name));
            }
            let name = stage.name();
            return Err(format!("the stage `{name}` was requested from within itself: {chain}{who} -> {name}"));
        }
        // A part of the world is borrowed during a `measure` or `apply` call, which must call no host function except
        // the log.
        if world.state.scene.try_borrow_mut().is_err() || world.devices.sensing.try_borrow_mut().is_err() {
            return Err(format!("the stage `{}` cannot run until the running call has returned", stage.name()));
        }
        stages.push((stage as u32, who));
    }
    let outermost = world.run.stages.try_borrow().is_ok_and(|s| s.len() == 1);
    let _running = StageGuard(world, world.run.calls.caller.replace(Caller::HOST));
    match stage {
        Stage::Actuate => actuate(world),
        Stage::Physics => physics(world, dt),
        Stage::Sense => {
            sense(world);
            parts::call_all(world, Moment::Sense);
        }
        Stage::React => react(world),
        // Scripts are cleaned up only in the last pass.
        Stage::Clean if world.state.phase.get() != Phase::Last => {}
        Stage::Clean => clean(world),
    }
    if stage == Stage::Physics {
        events::compare_contacts(world);
    }
    // If stages are nested, events are delivered at the end of the outermost stage.
    if outermost {
        events::deliver(world);
    }
    Ok(())
}

fn actuate(world: &WorldCell) {
    Scripts::actuate(world);
    parts::call_all(world, Moment::Actuate);
    world.restore_process_state("actuation");
}

fn clean(world: &WorldCell) {
    Scripts::clean_up(world);
    parts::end_all(world);
    world.restore_process_state("clean-up");
}

fn react(world: &WorldCell) {
    Scripts::react(world);
    world.restore_process_state("reaction");
}
