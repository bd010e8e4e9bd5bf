//! Selects the sensors that measure in a step.
//!
//! Most sensors measure in every step; they are listed once and not checked again. All other sensors are checked in
//! each step.

use std::rc::Rc;

use super::{Roll, Sensing, Turn, turn::TOGETHER};

impl Sensing {
    /// Rebuilds the list of devices of each kind, if the lists are out of date.
    pub fn list(&mut self) {
        if std::mem::replace(&mut self.listed, true) {
            return;
        }
        let mut rolls: Vec<Roll> = Vec::new();
        for (index, device) in self.devices.iter().enumerate() {
            if rolls.len() <= device.kind {
                rolls.resize_with(device.kind + 1, Roll::default);
            }
            rolls[device.kind].add(index, device);
        }
        self.rolls = rolls.into_iter().map(Rc::new).collect();
    }

    /// Returns a turn for a single device. Pass it to [`Sensing::was_alone`] afterwards, so that its memory is reused.
    pub fn alone(&mut self, index: usize) -> Turn {
        let mut turn = std::mem::take(&mut self.alone);
        turn.clear();
        turn.add(index, &self.devices[index]);
        turn
    }
    /// Takes back the turn from [`Sensing::alone`], to reuse its memory.
    pub fn was_alone(&mut self, turn: Turn) {
        self.alone = turn;
    }

    /// Returns the devices of a kind, as of the last call to [`Sensing::list`].
    pub fn roll(&self, kind: usize) -> Rc<Roll> {
        self.rolls.get(kind).cloned().unwrap_or_default()
    }

    /// Checks the next devices in `roll.others` from index `from` on, and fills `turn` with those that are due at this
    /// time. Returns the number of devices checked. Also releases delayed readings that are old enough.
    pub fn due(&mut self, roll: &Roll, from: usize, time: f64, turn: &mut Turn) -> usize {
        turn.clear();
        let some = roll.others.get(from..).unwrap_or_default();
        let some = &some[..some.len().min(TOGETHER)];
        for i in some {
            let d = &mut self.devices[*i];
            if !d.off {
                d.release(time);
                // If the device has released its last delayed reading, it may now measure in every step, so the lists
                // must be rebuilt.
                self.listed &= !d.is_steady();
            }
            if d.is_due(time) {
                turn.add(*i, d);
            }
        }
        some.len()
    }
}
