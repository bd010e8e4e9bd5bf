//! The interior of a world: [`WorldCell`] and its parts. The modules `step`, `scripts` and `run` operate on them.
//!
//! - `world`: the cell, which contains the next four; `model`: the description from which the world was built; `state`:
//!   the part that a step changes; `devices`: plugin instances; `run`: scripts, calls, services, log lines and faults;
//! - `plugin_monitor`: state that is monitored while plugins run; `plugin_calls`: calls into plugins; `scope`: the host
//!   functions that are allowed during each plugin call; `live_worlds`: the worlds of each thread;
//! - `clock`, `phase`: time, steps, and the phases of a run; `pool`: the thread pool;
//! - `calls`: the call stack, with `arena`, `call_errors` and `result_buffers`; `wait_list`: commands that wait and
//!   resume; `thread_results`, `thread_result_intake`: results of plugins' threads;
//! - `scripts`: the scripts, with `script_kinds` and `script_order`; `script_counts`: numbers of calls of each script;
//! - `worker_view`, `script_worker`: a thread's view of the world while it runs scripts in parallel;
//! - `folders`: the folders in which scripts open files;
//! - `events`: published events; `lines`, `report`: log lines and faults;
//! - `connections`, `session`, `wake_flag`: the session and its services; `service`, `service_calls`: a single service;
//!   `input_log`, `inputs`: external inputs;
//! - `history`: edits, and the states of the scene between them; `changes`: changes of properties;
//! - `stores`, `quotas`: limits on what scripts may store in a world; `instance_image`: a plugin instance in a
//!   snapshot;
//! - `swap_cell`: values that a reload replaces; `stand_ins`, `stand_in_use`: objects created because scripts request
//!   them.

mod arena;
pub(crate) mod call_errors;
mod calls;
mod changes;
mod clock;
mod connections;
pub(crate) mod cost;
mod devices;
mod events;
mod folders;
pub(crate) mod history;
mod input_log;
mod inputs;
mod instance_image;
mod lines;
mod live_worlds;
mod model;
mod phase;
mod plugin_calls;
mod plugin_monitor;
mod pool;
mod quotas;
mod report;
mod result_buffers;
mod run;
mod scope;
mod script_counts;
mod script_kinds;
mod script_order;
mod script_worker;
mod scripts;
mod service;
mod service_calls;
mod session;
pub(crate) mod stand_in_use;
mod stand_ins;
mod state;
mod stores;
mod swap_cell;
pub(crate) mod thread_result_intake;
mod thread_results;
mod wait_list;
mod wake_flag;
mod worker_view;
mod world;

pub(crate) use arena::Arena;
pub(crate) use calls::{CallStack, Caller, MAX_DEPTH};
pub(crate) use clock::Clock;
pub(crate) use connections::Connections;
pub use connections::NextScene;
pub(crate) use devices::CommandInstance;
pub(crate) use events::payload;
pub(crate) use folders::ScriptFolders;
pub use input_log::{ExternalInput, InputLog, InputRecord};
pub(crate) use input_log::{REPLAY_SERVICE, REQUEST_NAMES, Replay};
pub(crate) use inputs::{
    observe, observed, put_in, record_input, record_remote_call, record_remote_request, restore_inputs,
};
pub(crate) use instance_image::InstanceImage;
pub use lines::{LogBuffer, LogLine};
pub(crate) use model::WorldModel;
pub use phase::Phase;
pub(crate) use pool::of as pool_of;
pub(crate) use report::instance_fault;
pub(crate) use result_buffers::{CallerResultBuffer, GuardedResultBuffer};
pub use scope::record_breach;
pub(crate) use scope::{HostFunction, register_world};
pub use script_counts::ScriptSummary;
pub use script_kinds::OUTSIDE_KINDS;
pub(crate) use script_kinds::{CALLBACKS, Callback, ScriptKind, ScriptOrder};
pub(crate) use script_order::sort;
pub(crate) use scripts::{ExitRequest, Script, Scripts};
pub(crate) use service::RunningService;
pub(crate) use session::SessionCell;
pub(crate) use stand_in_use::begin as begin_stand_ins;
pub use stand_ins::{OptionalObject, StandIn};
pub(crate) use stores::{Signal, Signals, bytes_of};
pub(crate) use thread_results::ThreadResults;
pub(crate) use wait_list::{WaitCondition, WaitList, WaitOwner, WaitingCommand, parse as parse_wait};
pub(crate) use wake_flag::WakeFlag;
pub(crate) use worker_view::{DeferredEffect, WorkerView};
pub(crate) use world::{ScriptWorker, WorldCell};
