//! Safe traits over the ABI, for plugins written in Rust without `unsafe`.
//!
//! Start with [`Plugin`]; a plugin provides [`Command`]s, [`Sensor`]s, [`Actuator`]s, [`Part`]s, [`Model`]s,
//! [`Importer`]s, [`Language`]s, [`Service`]s and [`Event`]s through an [`Offer`]. A panic in a callback is caught, and becomes an
//! error that names the plugin.
//!
//! Apart from `configure`, the methods of the traits take `&self`, because a command may call a script that calls the
//! command again.

mod call;
mod declare;
mod entry;
mod value;

pub use call::catalogue::About;
pub use call::figures::keys;
pub use call::host::{Host, Prop};
pub use call::outgoing::Called;
pub use call::running::{IntoResult, Return, Ticket};
pub use call::shared_world::{Object, SharedWorld};
pub use call::world::{Closest, Contact, World};
pub use declare::actuator::{Actuator, Drive, Output};
pub use declare::command::Constant;
pub use declare::event::Event;
pub use declare::importer::Importer;
pub use declare::language::{Budget, Flow, Frame, Language};
pub use declare::model::{Builder, Model, Node};
pub use declare::model_reader::{ModelInfo, ModelNumber, ModelReader, ModelSlot};
pub use declare::part::{Moment, Part, PartCall, Pause};
pub use declare::plugin::{
    Call, Change, Command, Heard, HeardFunction, Instance, Offer, Outcome, PerWorld, Plugin, SharedCall, Status,
};
pub use declare::sensor::{Beams, Form, Preset, Sensor};
pub use declare::service::{Answer, Service, Session, Turn};
pub use entry::panics::{guarded, quiet as guarded_quietly};
pub use value::fail::{Fail, Result};
pub use value::field::{Element, Field, TypedField};
pub use value::install_paths::{cache_folder, folders_beside, program_file, state_folder};
pub use value::owned::{MAX_DEPTH, Owned, Room, Value};
pub use value::param::{Param, Params};
#[allow(deprecated, reason = "the former name of `MAX_FILE_BYTES`, for existing plugins")]
pub use value::plain::MOST_BYTES;
pub use value::plain::{MAX_FILE_BYTES, open_plain, read_opened, read_plain, read_plain_text};
pub use value::reading::Reading;
pub use value::sample::{Readout, Sample};
pub use value::target::Target;

pub use crate::abi::ValueRef;

#[doc(hidden)]
pub mod macro_support {
    pub use super::entry::panics::set_panic_hook;
    pub use super::entry::start::{Entry, NEEDS, extension, init, shutdown};
}
