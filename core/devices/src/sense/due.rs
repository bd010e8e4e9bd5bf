//! Which sensors measure by themselves in a step.
//!
//! Most do in each step: they are listed once, and none of them is asked again whether it is due. The others are asked.

use std::rc::Rc;

use super::{Roll, Sensing, Turn, turn::TOGETHER};

impl Sensing {
    /// Lists the devices of each kind, if the lists are not right any more.
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

    /// A turn for one device alone; [`Sensing::was_alone`] takes it back, to be used again.
    pub fn alone(&mut self, index: usize) -> Turn {
        let mut turn = std::mem::take(&mut self.alone);
        turn.clear();
        turn.add(index, &self.devices[index]);
        turn
    }
    /// See [`Sensing::alone`].
    pub fn was_alone(&mut self, turn: Turn) {
        self.alone = turn;
    }

    /// The devices of a kind, as they were listed last.
    pub fn roll(&self, kind: usize) -> Rc<Roll> {
        self.rolls.get(kind).cloned().unwrap_or_default()
    }

    /// Of the next devices of a roll that are asked, from the `from`-th on, those that measure at this time; how many were
    /// looked at. What they measured before may be seen now, whether they measure now or not.
    pub fn due(&mut self, roll: &Roll, from: usize, time: f64, turn: &mut Turn) -> usize {
        turn.clear();
        let some = roll.others.get(from..).unwrap_or_default();
        let some = &some[..some.len().min(TOGETHER)];
        for i in some {
            let d = &mut self.devices[*i];
            if !d.off {
                d.release(time);
                // It had a last delayed reading.
                self.listed &= !d.is_steady();
            }
            if d.is_due(time) {
                turn.add(*i, d);
            }
        }
        some.len()
    }
}
