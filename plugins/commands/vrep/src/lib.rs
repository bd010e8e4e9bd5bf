//! The V-REP script API, implemented as commands (`sim.getObjectHandle`, `simGetObjectHandle` and so on) and constants.
//!
//! Each subject has a folder or file, and a page in `docs/reference/commands`; `offer` below registers all of them. For
//! an introduction, read `joints/`, which is short, then the shared code in `kit/`. Only `language/` depends on a
//! script language.
//!
//! The layers, from the lowest to the highest, are `kit` (arguments, dialects, error messages), `state` (data per
//! world), `lookup` (finding objects), the subjects, and this file.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "expected values of tests need not be reproducible"))]

mod copies;
mod data;
mod examples;
mod flags;
mod graphs;
mod joints;
mod kit;
mod language;
mod lookup;
mod math;
mod meshes;
mod messages;
mod model_paths;
mod motion;
mod names;
mod objects;
mod packing;
mod parameters;
mod paths;
mod physics;
mod poses;
mod proximity;
mod remote;
mod scripts;
mod sensor_creation;
mod sets;
mod shapes;
mod signals;
mod simulation;
mod state;
mod steps;
mod stubs;
mod vision;
mod windows;

use tatu_plugin_api::safe::{Fail, Host, Offer, PerWorld, Plugin, Result, World};

use kit::{Props, Vrep};

impl Plugin for Vrep {
    fn start(host: &Host) -> Result<Self> {
        Ok(Vrep { p: Props::new(host) })
    }

    fn offer(offer: &mut Offer<Self>) {
        offer.per_world();
        // One call per subject, with the name of its documentation page.
        offer.subject("objects", objects::offer);
        offer.subject("names", names::offer);
        offer.subject("flags", flags::offer);
        offer.subject("sets", sets::offer);
        offer.subject("copies", copies::offer);
        offer.subject("poses", poses::offer);
        offer.subject("math", math::offer);
        offer.subject("joints", joints::offer);
        offer.subject("shapes", shapes::offer);
        offer.subject("meshes", meshes::offer);
        offer.subject("physics", physics::offer);
        offer.subject("parameters", parameters::offer);
        offer.subject("sensors", proximity::offer);
        offer.subject("sensors", vision::offer);
        offer.subject("sensors", sensor_creation::offer);
        offer.subject("signals", signals::offer);
        offer.subject("packing", packing::offer);
        offer.subject("data", data::offer);
        offer.subject("paths", paths::offer);
        offer.subject("motion", motion::offer);
        offer.subject("messages", messages::offer);
        offer.subject("windows", windows::offer);
        offer.subject("graphs", graphs::offer);
        offer.subject("simulation", simulation::offer);
        offer.subject("scripts", scripts::offer);
        offer.subject("steps", steps::offer);
        offer.subject("remote", remote::offer);
        language::offer(offer);
        // Stubs must come after all other commands, because a stub is added only if its command does not exist yet.
        offer.subject("stubs", stubs::offer);
        examples::complete(offer);
    }
}

impl PerWorld for Vrep {
    type World = state::WorldState;

    fn world(&self, world: &World<'_>) -> Result<state::WorldState> {
        Ok(state::WorldState::new(*world.host()))
    }

    const STATE_VERSION: u32 = 4;
    fn save(world: &state::WorldState) -> Result<Vec<u8>> {
        world.save()
    }
    fn load(world: &state::WorldState, bytes: &[u8], version: u32) -> Result<()> {
        if version != Self::STATE_VERSION {
            return Err(Fail::unsupported(format!(
                "the state was saved in format version {version}; this program reads version {}",
                Self::STATE_VERSION
            )));
        }
        world.load(bytes)
    }
}

tatu_plugin_api::tatu_plugin! {
    plugin: Vrep,
    id: "tatu.commands.vrep",
    name: "V-REP script API",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
