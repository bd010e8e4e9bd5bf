//! The interior of a world: [`WorldCell`] and its parts. The modules `step`, `scripts` and `run` operate on them.
//!
//! - `world`: the cell, which contains the next four; `model`: the description from which the world was built; `state`:
//!   the part that a step changes; `devices`: plugin instances; `run`: scripts, calls, services, log lines and faults;
//! - `clock`, `phase`: time, steps, and the phases of a run; `pool`: the thread pool; `live_worlds`: the worlds of each
//!   thread; `swap_cell`: values that a reload replaces; `part_summary`: the calls of a part;
//! - `calls`: calls into plugins, and the commands that they run;
//! - `scripts`: the scripts, their order, and threads that run them in parallel;
//! - `session`: services, and the log of external inputs;
//! - `records`: what a world records and stores: events, log lines, faults, edits, data of scripts.

pub(crate) mod calls;
mod clock;
mod devices;
mod live_worlds;
mod model;
mod part_summary;
mod phase;
mod pool;
pub(crate) mod records;
mod run;
pub(crate) mod scripts;
mod session;
mod state;
mod swap_cell;
mod world;

pub(crate) use calls::arena::Arena;
pub(crate) use calls::result_buffers::{CallerResultBuffer, GuardedResultBuffer};
pub use calls::scope::record_breach;
pub(crate) use calls::scope::{HostFunction, register_world};
pub(crate) use calls::stack::{CallStack, Caller, MAX_DEPTH};
pub(crate) use calls::thread_results::ThreadResults;
pub(crate) use calls::wait_list::{WaitCondition, WaitList, WaitOwner, WaitingCommand, parse as parse_wait};
pub(crate) use clock::Clock;
pub(crate) use devices::CommandInstance;
pub(crate) use model::WorldModel;
pub use part_summary::PartSummary;
pub use phase::Phase;
pub(crate) use pool::of as pool_of;
pub(crate) use records::events::payload;
pub(crate) use records::instance_image::InstanceImage;
pub use records::lines::{LogBuffer, LogLine};
pub(crate) use records::report::instance_fault;
pub(crate) use records::stores::{Signal, Signals, bytes_of};
pub use scripts::counts::ScriptSummary;
pub(crate) use scripts::folders::ScriptFolders;
pub use scripts::kinds::OUTSIDE_KINDS;
pub(crate) use scripts::kinds::{CALLBACKS, Callback, ScriptKind, ScriptOrder};
pub(crate) use scripts::list::{ExitRequest, Script, Scripts};
pub(crate) use scripts::order::sort;
pub(crate) use scripts::stand_in_use::begin as begin_stand_ins;
pub use scripts::stand_ins::{OptionalObject, StandIn};
pub(crate) use scripts::worker_view::{DeferredEffect, WorkerView};
pub(crate) use session::connections::Connections;
pub use session::connections::NextScene;
pub use session::input_log::{ExternalInput, InputLog, InputRecord};
pub(crate) use session::input_log::{REPLAY_SERVICE, REQUEST_NAMES, Replay};
pub(crate) use session::inputs::{
    observe, observed, put_in, record_input, record_remote_call, record_remote_request, restore_inputs,
};
pub(crate) use session::service::RunningService;
pub(crate) use session::session_cell::{SessionCell, SessionSignals};
pub(crate) use world::{ScriptWorker, WorldCell};
