//! Code shared by the commands of all subjects. It depends neither on the state of a world nor on a subject.
//!
//! - `plugin`: the plugin, and the types of its commands; `props`: interned property keys;
//! - `declare`: commands under both names, common parameters; `arguments`: reads arguments, builds errors;
//! - `dialect`: the version that a script was written for;
//! - `algebra`: rotations and poses; `tables`: packs values into bytes, and unpacks them; `foreign_tables`:
//!   unpacks V-REP's own formats; `tags`: custom data of objects.

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
