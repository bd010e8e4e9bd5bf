//! The trait of plugins, and the types with which a plugin declares what it offers.

use std::{collections::HashSet, ffi::c_void, sync::Mutex};

use crate::abi::*;
use crate::safe::{
    Fail, Host, Param, Result, Value, ValueRef, World, call::frame::CallFrame, value::table_arena::TableArena,
};

/// A plugin. There is one value per host. A plugin must not have mutable globals; state that belongs to a world is
/// stored in an instance of [`PerWorld`].
pub trait Plugin: Sized + Send + Sync + 'static {
    /// Starts the plugin. It may look up keys and services and write to the log, but functions that require a world can
    /// be called only once a world exists.
    fn start(host: &Host) -> Result<Self>;
    /// Declares everything that the plugin offers.
    fn offer(offer: &mut Offer<Self>);
}

/// A plugin whose commands store state for each world. It must call [`Offer::per_world`].
pub trait PerWorld: Plugin {
    /// The state of a world. [`Call::instance`] returns it as a shared reference. While a command calls a function of a
    /// script, it may itself be called again, so use cells, and do not hold a borrow across a call.
    type World: 'static;

    /// Creates the instance for a new world.
    fn world(&self, world: &World<'_>) -> Result<Self::World>;
    /// Whether the instance outlives a run, as customization scripts and add-ons do. If so, [`PerWorld::end_run`] is
    /// called at the end of a run; otherwise the instance is recreated.
    const OUTLIVES_RUNS: bool = false;
    /// Called at the end of a run, after its scripts have ended and before the scene is reset. Must drop the state of
    /// scripts that do not outlive runs ([`World::outlives_runs`]). If this fails, the instance is recreated.
    fn end_run(&self, kept: &Self::World, world: &World<'_>) -> Result<()> {
        let _ = (kept, world);
        Ok(())
    }
    /// Version of the data that [`PerWorld::save`] writes; increase it when the format of the data changes.
    const STATE_VERSION: u32 = 0;
    /// Saves the state of `world` for a snapshot. By default, a state that is not zero-sized is reported as missing
    /// from the snapshot, and the run is restored by replay.
    fn save(world: &Self::World) -> Result<Vec<u8>> {
        let _ = world;
        if size_of::<Self::World>() == 0 {
            return Ok(Vec::new());
        }
        Err(Fail::unsupported("the plugin cannot save its state of this world"))
    }
    /// Restores data that version `version` of `save` wrote, in a new instance.
    fn load(world: &Self::World, bytes: &[u8], version: u32) -> Result<()> {
        let _ = (world, version);
        if bytes.is_empty() { Ok(()) } else { Err(Fail::unsupported("this plugin cannot restore a saved state")) }
    }
}

/// Data with which an instance is created.
#[derive(Debug, Clone, Copy)]
pub struct Instance {
    /// The object of the sensor, actuator, part or script.
    pub owner: tatu_object,
    /// Id of the instance, unique in its world.
    pub id: u64,
    /// Seed derived from the scene's seed and the owner, so it is the same in every run.
    pub seed: u64,
}

/// The response of an instance to new values of its parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// The instance now uses the new values.
    Taken,
    /// The instance must be recreated with the new values.
    Rebuild,
}

/// A started plugin, to which the host's `self` pointer points.
pub(crate) struct StartedPlugin<P: Plugin> {
    pub(crate) plugin: P,
    pub(crate) host: Host,
    pub(crate) tables: ExtensionTables,
    /// The function that receives events.
    pub(crate) heard: Option<HeardFunction<P>>,
    /// Models that the plugin has read.
    pub(crate) model_cache: Mutex<ModelCache>,
}

/// The function of a plugin that reads models.
pub(crate) type ReadModelFn =
    unsafe extern "C" fn(*mut c_void, tatu_str, tatu_str, *mut *const tatu_model, *mut tatu_error) -> tatu_status;

/// Models that were read, indexed by name and text and stored until shutdown, so that each text is read only once.
#[derive(Default)]
pub(crate) struct ModelCache {
    pub(crate) models: Vec<(String, String, *const tatu_model)>,
    pub(crate) arena: TableArena,
}

/// The finished tables of a started plugin.
pub(crate) struct ExtensionTables {
    pub(crate) command: *const tatu_ext_command,
    pub(crate) sensor: *const tatu_ext_sensor,
    pub(crate) actuator: *const tatu_ext_actuator,
    pub(crate) part: *const tatu_ext_part,
    pub(crate) model: *const tatu_ext_model,
    pub(crate) importer: *const tatu_ext_importer,
    pub(crate) script: *const tatu_ext_script,
    pub(crate) service: *const tatu_ext_service,
    pub(crate) event: *const tatu_ext_event,
    pub(crate) _arena: TableArena,
}

/// Collects everything that a plugin provides; see [`Plugin::offer`].
pub struct Offer<P: Plugin> {
    pub(crate) arena: TableArena,
    /// The life cycle of the per-world instance; null if the plugin has none.
    pub(crate) per_world: *const tatu_life,
    pub(crate) commands: Vec<Command<P>>,
    /// Names of the commands, in a set because a plugin may look up each of several hundred names.
    pub(crate) names: HashSet<String>,
    pub(crate) constants: Vec<*const tatu_constant>,
    pub(crate) preludes: Vec<*const tatu_prelude>,
    pub(crate) kind_marks: Vec<*const tatu_kind_mark>,
    pub(crate) sensors: Vec<*const tatu_sensor>,
    pub(crate) actuators: Vec<*const tatu_actuator>,
    pub(crate) parts: Vec<*const tatu_part>,
    pub(crate) models: Vec<*const tatu_model>,
    pub(crate) read_model: Option<ReadModelFn>,
    pub(crate) importers: Vec<*const tatu_importer>,
    pub(crate) languages: Vec<*const tatu_language>,
    pub(crate) services: Vec<*const tatu_service>,
    pub(crate) events: OfferedEvents<P>,
}

/// The events that a plugin publishes and receives.
pub(crate) struct OfferedEvents<P: Plugin> {
    pub(crate) published: Vec<*const tatu_event>,
    /// The function that receives events, and their names.
    pub(crate) listener: Option<(HeardFunction<P>, Vec<String>)>,
}

/// The declaration of a command.
pub struct Command<P: Plugin> {
    pub(crate) names: Vec<CommandNameSpec>,
    pub(crate) params: Vec<Param>,
    pub(crate) returns: Vec<Param>,
    pub(crate) text: String,
    pub(crate) example: String,
    pub(crate) no_wait: Option<String>,
    pub(crate) raw: bool,
    pub(crate) status: Status,
    pub(crate) notes: String,
    pub(crate) subject: String,
    pub(crate) run: CommandFunction<P>,
}

pub(crate) enum CommandFunction<P: Plugin> {
    Exclusive(ExclusiveFn<P>),
    Shared(SharedFn<P>),
}

/// The degree to which a command is implemented.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u32)]
pub enum Status {
    /// The command implements all of its documented behaviour.
    #[default]
    Full = TATU_COMMAND_FULL,
    /// The command implements part of its documented behaviour; its notes describe what is missing.
    Partial = TATU_COMMAND_PARTIAL,
    /// The command accepts its arguments and returns a neutral value; the host reports it once per run.
    Stub = TATU_COMMAND_STUB,
}

pub(crate) struct CommandNameSpec {
    pub(crate) name: String,
    pub(crate) on_error: Option<Vec<Value>>,
    pub(crate) until: Option<String>,
}

/// The outcome of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Outcome {
    /// The command has finished, with its results.
    #[default]
    Done,
    /// The command finishes later; see [`Call::wait_steps`] and the other `wait_*` functions.
    Waiting,
}

/// The function of a command with exclusive access to the world.
pub(crate) type ExclusiveFn<P> = Box<dyn Fn(&mut Call<'_, P>) -> Result<Outcome> + Send + Sync>;
/// The function of a command that may run in parallel with others.
pub(crate) type SharedFn<P> = Box<dyn Fn(&mut SharedCall<'_, P>) -> Result<Outcome> + Send + Sync>;

/// A call to a command that may run in parallel with others. It provides the call's own data, the immutable part of the
/// plugin and a read-only world; [`Call`] adds what requires exclusive access.
pub struct SharedCall<'a, P: Plugin> {
    pub(crate) raw: CallFrame<'a>,
    pub(crate) started: &'a StartedPlugin<P>,
    pub(crate) overflow: bool,
}

/// A call to a command with exclusive access to the world.
pub struct Call<'a, P: Plugin>(pub(crate) SharedCall<'a, P>);

/// The function of a plugin that receives events; see [`Offer::listen`](crate::safe::Offer::listen).
pub type HeardFunction<P> = fn(&Heard<'_, P>) -> Result;

/// An event that a plugin receives, and the world in which it was published.
pub struct Heard<'a, P: Plugin> {
    pub(crate) world: World<'a>,
    pub(crate) plugin: &'a P,
    pub(crate) instance: *mut c_void,
    pub(crate) name: &'a str,
    pub(crate) payload: ValueRef<'a>,
}
