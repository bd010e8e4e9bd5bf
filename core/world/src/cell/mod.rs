//! The inside of a world: [`WorldCell`] and the plain structs that it holds. What they do in a step stands above.
//!
//! - `world`: all parts, each behind a `RefCell` of its own; `make`: a cell with nothing in it but a scene;
//! - `clock`, `phase`: time, steps, and what the world is doing; `pool`: its threads;
//! - `calls`: the stack of calls, their arena, errors and `results_room`; `waits`: commands that go on later;
//! - `scripts`: the scripts, by `script_kinds` and in `script_order`; `script_counts`: what each did;
//! - `script_worker`: what a thread sees of the world while it runs scripts in parallel;
//! - `folders`: where scripts open files;
//! - `scope`: what a plugin may ask of the host in which call;
//! - `events`: what has been published; `report`: lines and faults;
//! - `outside`, `session`, `service`, `input_log`, `wake`: services, and what came in;
//! - `stores`: how much scripts may leave in a world; `swap`: what a reload exchanges; `stand_ins`: objects made for scripts
//!   that ask for them.

mod arena;
pub(crate) mod call_errors;
mod calls;
mod clock;
mod events;
mod folders;
mod input_log;
mod instance_image;
mod make;
mod outside;
mod phase;
mod pool;
mod report;
mod results_room;
mod scope;
mod script_counts;
mod script_kinds;
mod script_order;
mod script_worker;
mod scripts;
mod service;
mod session;
pub(crate) mod stand_ins;
mod stores;
mod swap;
mod waits;
mod wake;
mod world;

pub(crate) use arena::Arena;
pub(crate) use calls::{Caller, Calls, MAX_DEPTH};
pub(crate) use clock::Clock;
pub(crate) use events::payload;
pub(crate) use folders::{Folders, Refused};
pub use input_log::{Input, InputLog, Record};
pub(crate) use input_log::{
    REPLAY, REQUESTS, Replay, observe, observed, put_in, record_of, remote_call, remote_request, restore_inputs,
};
pub(crate) use instance_image::InstanceImage;
pub use outside::NextScene;
pub(crate) use outside::Outside;
pub use phase::Phase;
pub(crate) use pool::of as pool_of;
pub(crate) use report::instance_fault;
pub use report::{Lines, LogLine};
pub(crate) use results_room::{CallersRoom, ResultsRoom};
pub use scope::breach;
pub(crate) use scope::{Function, enlist};
pub(crate) use script_counts::CallCounts;
pub use script_counts::ScriptSummary;
pub use script_kinds::OUTSIDE_KINDS;
pub(crate) use script_kinds::{CALLBACKS, Callback, CallbackIds, CallbackMask, Kind};
pub(crate) use script_order::{Order, sort};
pub(crate) use script_worker::{DeferredEffect, ScriptWorker, WorkerView};
pub(crate) use scripts::{ExitRequest, Script, Scripts};
pub(crate) use service::Running;
pub(crate) use session::SessionCell;
pub use stand_ins::{StandIn, Wish};
pub(crate) use stores::{Noted, Signals, bytes_of};
pub(crate) use waits::{Due, Owner, Wait, Waits, parse as parse_wait};
pub(crate) use wake::Wake;
pub(crate) use world::{Instance, Signal, WorldCell};
