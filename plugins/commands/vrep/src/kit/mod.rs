//! What all subjects share. It knows neither the state of a world nor a subject.
//!
//! - `plugin`: the plugin, and the types of its commands; `props`: interned property keys;
//! - `declare`: commands under both names, common parameters; `arguments`: what is read from calls, and messages;
//! - `dialect`: the version that a script was written for;
//! - `algebra`: rotations and poses; `tables`: values as bytes; `tags`: free data of objects.

pub(crate) mod algebra;
mod arguments;
mod declare;
mod dialect;
mod foreign_tables;
mod plugin;
mod props;
pub(crate) mod tables;
pub(crate) mod tags;

pub(crate) use tatu_plugin_api::{abi::*, safe::*};

pub use plugin::Vrep;
pub(crate) use {arguments::*, declare::*, dialect::*, plugin::*, props::Props};
