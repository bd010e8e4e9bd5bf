//! The V-REP script API as commands: `sim.getObjectHandle`, `simGetObjectHandle` and their kin, with the constants.
//!
//! One file per subject; each ends up in [`Plugin::offer`] below. Begin with `joints.rs`, which is short, then `kit.rs`,
//! which holds what all share: arguments, dialects, messages. Nothing here knows a script language but `prelude.lua`.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "what tests compare with decides no bits"))]

mod algebra;
mod aliases;
mod appearance;
mod by_name;
mod collections;
mod console;
mod constants;
mod copying;
mod custom_data;
mod dialogs;
mod distances;
mod drawing;
mod engine;
mod examples;
mod flags;
mod force_sensors;
mod forces;
mod graphs;
mod handle_sets;
mod joints;
mod kept;
mod keys;
mod kinds;
mod kit;
mod lights;
mod main_script;
mod math;
mod meshes;
mod messages;
mod modules;
mod motion;
mod names;
mod objects;
mod old_windows;
mod packing;
mod pairs;
mod parameters;
mod path_objects;
mod paths;
mod poses;
mod prelude;
mod profile;
mod profiles;
mod properties;
mod proximity;
mod remote_api;
mod script_more;
mod scripts;
mod selection;
mod shapes;
mod signals;
mod simulation;
mod state;
mod stubs;
mod tables;
mod tags;
mod threads;
mod tree;
mod tubes;
mod views;
mod vision;
mod wireless;

pub use kit::Vrep;
use tatu_plugin_api::safe::{Fail, Host, Offer, Plugin, Result, World};

impl Plugin for Vrep {
    type World = state::State;

    fn start(host: &Host) -> Result<Self> {
        Ok(Vrep { p: kit::Props::new(host) })
    }

    fn world(&self, world: &World<'_>) -> Result<state::State> {
        Ok(state::State::new(*world.host()))
    }

    const STATE_VERSION: u32 = 3;
    fn save(world: &state::State) -> Result<Vec<u8>> {
        world.save()
    }
    fn load(world: &state::State, bytes: &[u8], version: u32) -> Result<()> {
        if version != Self::STATE_VERSION {
            return Err(Fail::unsupported(format!(
                "it kept its state in version {version}, and reads {}",
                Self::STATE_VERSION
            )));
        }
        world.load(bytes)
    }

    fn offer(offer: &mut Offer<Self>) {
        objects::offer(offer);
        tree::offer(offer);
        offer.subject("objects");
        aliases::offer(offer);
        offer.subject("names");
        flags::offer(offer);
        offer.subject("flags");
        selection::offer(offer);
        collections::offer(offer);
        offer.subject("sets");
        copying::offer(offer);
        offer.subject("copies");
        poses::offer(offer);
        offer.subject("poses");
        math::offer(offer);
        offer.subject("math");
        joints::offer(offer);
        force_sensors::offer(offer);
        offer.subject("joints");
        shapes::offer(offer);
        appearance::offer(offer);
        lights::offer(offer);
        offer.subject("shapes");
        meshes::offer(offer);
        offer.subject("meshes");
        forces::offer(offer);
        engine::offer(offer);
        distances::offer(offer);
        pairs::offer(offer);
        offer.subject("physics");
        properties::offer(offer);
        by_name::offer(offer);
        offer.subject("parameters");
        proximity::offer(offer);
        vision::offer(offer);
        offer.subject("sensors");
        vision::module::offer(offer);
        signals::offer(offer);
        tubes::offer(offer);
        wireless::offer(offer);
        offer.subject("signals");
        packing::offer(offer);
        tables::offer(offer);
        offer.subject("packing");
        custom_data::offer(offer);
        offer.subject("data");
        paths::offer(offer);
        path_objects::offer(offer);
        offer.subject("paths");
        profiles::offer(offer);
        motion::offer(offer);
        offer.subject("motion");
        console::offer(offer);
        messages::offer(offer);
        dialogs::offer(offer);
        offer.subject("messages");
        old_windows::offer(offer);
        offer.subject("windows");
        graphs::offer(offer);
        drawing::offer(offer);
        views::offer(offer);
        offer.subject("graphs");
        simulation::offer(offer);
        parameters::offer(offer);
        offer.subject("simulation");
        scripts::offer(offer);
        script_more::offer(offer);
        offer.subject("scripts");
        main_script::offer(offer);
        threads::offer(offer);
        offer.subject("steps");
        remote_api::offer(offer);
        offer.subject("remote");
        constants::offer(offer);
        prelude::offer(offer);
        modules::offer(offer);
        kinds::offer(offer);
        stubs::offer(offer);
        offer.subject("stubs");
        examples::complete(offer);
    }
}

tatu_plugin_api::tatu_plugin! {
    plugin: Vrep,
    id: "tatu.commands.vrep",
    name: "V-REP script API",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
