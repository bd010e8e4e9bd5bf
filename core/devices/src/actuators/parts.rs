//! Parts among the actuators: the order in which they are called, and their state.

use std::rc::Rc;

use super::Actuators;

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
