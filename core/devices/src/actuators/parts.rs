//! Parts among the actuators: the order in which they are called, and the record of their calls.

use std::{
    collections::{BTreeMap, BTreeSet},
    rc::Rc,
    time::Duration,
};

use tatu_physics::PairRule;
use tatu_plugin_api::abi::tatu_object;

use super::Actuators;

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

impl Actuators {
    /// Returns the indices of the parts in [`devices`](Self::devices), in ascending order of their slots, in which they
    /// are called.
    pub fn parts(&mut self) -> Rc<[usize]> {
        if let Some(roster) = &self.roster {
            return roster.clone();
        }
        let mut all: Vec<usize> = (0..self.devices.len()).filter(|i| self.devices[*i].part.is_some()).collect();
        all.sort_by_key(|i| self.devices[*i].slot);
        let all: Rc<[usize]> = all.into();
        self.roster = Some(all.clone());
        all
    }

    /// Returns the state blocks of all parts, with their slots.
    pub fn part_states(&self) -> impl Iterator<Item = (u32, &[u64])> {
        self.devices.iter().filter(|d| d.part.is_some()).map(|d| (d.slot, &*d.state))
    }
}
