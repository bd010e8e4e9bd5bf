//! Traits over the ABI: a plugin in Rust without `unsafe`.
//!
//! Begin with [`Plugin`]; a plugin offers [`Command`]s, [`Sensor`]s, [`Actuator`]s, [`Model`]s, [`Importer`]s,
//! [`Language`]s, [`Service`]s and [`Event`]s through an [`Offer`]. Every callback is wrapped so that a panic becomes an error that
//! names the plugin.
//!
//! All traits take `&self`: a command may call a script that calls the command again.

mod actuator;
mod call;
mod catalogue;
mod command;
mod event;
mod fail;
mod figures;
mod files;
mod guard;
mod host;
mod importer;
mod language;
mod life;
mod model;
mod offer;
mod once;
mod outgoing;
mod param;
mod plain;
mod plugin;
mod reading;
mod sample;
mod sensor;
mod sensor_table;
mod service;
mod shared_world;
mod stand_ins;
mod talk;
mod value;
mod world;

pub use actuator::{Actuator, Drive, Output};
pub use call::{Call, IntoResult, Outcome, Return, SharedCall};
pub use catalogue::About;
pub use command::{Command, Constant, Status};
pub use event::Event;
pub use fail::{Fail, Result};
pub use figures::keys;
pub use guard::{guarded, quiet as guarded_quietly};
pub use host::{Host, Prop};
pub use importer::Importer;
pub use language::{Budget, Flow, Frame, Language};
pub use model::{Builder, Model, Node};
pub use offer::Offer;
pub use outgoing::Called;
pub use param::{Param, Params};
pub use plain::{MOST_BYTES, open_plain, read_plain, read_plain_text};
pub use plugin::{Instance, Plugin};
pub use reading::Reading;
pub use sample::{Readout, Sample};
pub use sensor::{Beams, Change, Field, Form, Preset, Sensor};
pub use service::{Answer, Service, Session, Turn};
pub use shared_world::{Object, SharedWorld};
pub use value::{MAX_DEPTH, Owned, Room, Value};
pub use world::{Closest, Contact, World};

pub use crate::abi::ValueRef;

#[doc(hidden)]
pub mod macro_support {
    pub use super::guard::set_panic_hook;
    pub use super::plugin::{Entry, NEEDS, extension, init, shutdown};
}
