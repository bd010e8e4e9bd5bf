//! Selects the sensors that measure in a step.
//!
//! Most sensors measure in every step; they are listed once and not checked again. All other sensors are checked in
//! each step.

use std::rc::Rc;

use super::{DueSensors, Sensing, SensorRoster, roster::MAX_BATCH_SENSORS};

impl Sensing {
    /// Rebuilds the list of devices of each kind, if the lists are out of date.
    pub fn update_rosters(&mut self) {
        if std::mem::replace(&mut self.rosters_current, true) {
            return;
        }
        let mut rolls: Vec<SensorRoster> = Vec::new();
        for (index, device) in self.devices.iter().enumerate() {
            if rolls.len() <= device.kind {
                rolls.resize_with(device.kind + 1, SensorRoster::default);
            }
            rolls[device.kind].add(index, device);
        }
        self.rosters = rolls.into_iter().map(Rc::new).collect();
    }

    /// Returns a selection of a single device. Pass it to [`Sensing::reuse_single_sensor`] afterwards, so that its
    /// memory is reused.
    pub fn single_sensor(&mut self, index: usize) -> DueSensors {
        let mut turn = std::mem::take(&mut self.single_sensor);
        turn.clear();
        turn.add(index, &self.devices[index]);
        turn
    }
    /// Takes back the selection from [`Sensing::single_sensor`], to reuse its memory.
    pub fn reuse_single_sensor(&mut self, turn: DueSensors) {
        self.single_sensor = turn;
    }

    /// Returns the devices of a kind, as of the last call to [`Sensing::update_rosters`].
    pub fn roster(&self, kind: usize) -> Rc<SensorRoster> {
        self.rosters.get(kind).cloned().unwrap_or_default()
    }

    /// Checks the next devices in `roll.others` from index `from` on, and fills `turn` with those that are due at this
    /// time. Returns the number of devices checked. Also releases delayed readings that are old enough.
    pub fn select_due(&mut self, roll: &SensorRoster, from: usize, time: f64, turn: &mut DueSensors) -> usize {
        turn.clear();
        let some = roll.others.get(from..).unwrap_or_default();
        let some = &some[..some.len().min(MAX_BATCH_SENSORS)];
        for i in some {
            let d = &mut self.devices[*i];
            if !d.off {
                d.release(time);
                // If the device has released its last delayed reading, it may now measure in every step, so the lists
                // must be rebuilt.
                self.rosters_current &= !d.is_steady();
            }
            if d.is_due(time) {
                turn.add(*i, d);
            }
        }
        some.len()
    }
}
