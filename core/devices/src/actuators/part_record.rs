//! The record of a part's calls and decisions.

use std::{
    collections::{BTreeMap, BTreeSet},
    time::Duration,
};

use tatu_physics::PairRule;
use tatu_plugin_api::abi::tatu_object;

/// The calls of a part.
#[derive(Debug, Default)]
pub struct PartRecord {
    /// Number of calls.
    pub calls: u64,
    /// Real time of all calls, with the host functions and commands that they called. It is only reported.
    pub time: Duration,
    /// Whether the part is being called. It is not called again meanwhile, for example by a stage that it runs.
    pub running: bool,
    /// Whether its `end` has been called.
    pub ended: bool,
    /// Pairs of shapes on whose contact it decides; the second one is 0 for all that the first one touches.
    pub hooks: BTreeSet<(tatu_object, tatu_object)>,
    /// Its decisions that differ from the defaults, or did, by the slots of the shapes, the lower one first. The velocity
    /// of the surface is that of the first shape.
    pub rules: BTreeMap<(u32, u32), PairRule>,
}
