//! Who measures by itself in a step.
//!
//! Most sensors do in each step: they are listed once, and nobody views at each of them again whether it is due. The others
//! are asked.

use std::rc::Rc;

use super::{Device, Sensing};

/// Sensors of a kind that are handled together, and what must be known of them before.
#[derive(Debug, Default)]
pub(crate) struct Turn {
    /// Their indices, ascending.
    pub devices: Vec<usize>,
    /// Places in `devices` at which another batch begins.
    pub cuts: Vec<usize>,
    /// What they look at: visible things or not, and by which waves; each once.
    pub sees: Vec<(bool, u16)>,
}

/// The sensors of a kind.
#[derive(Debug, Default)]
pub(crate) struct Roll {
    /// Those that measure in each step.
    pub steady: Turn,
    /// The others, ascending.
    others: Vec<usize>,
}

/// So many sensors measure together: what is noted of them stays in the processor's caches from the first look at them to
/// the last one at what they measured.
const TOGETHER: usize = 256;

impl Turn {
    fn clear(&mut self) {
        let Turn { devices, cuts, sees } = self;
        devices.clear();
        cuts.clear();
        sees.clear();
    }

    fn add(&mut self, index: usize, device: &Device) {
        let plan = &device.layout.plan;
        let sees = (plan.visible, plan.waves);
        if !self.sees.contains(&sees) {
            self.sees.push(sees);
        }
        self.devices.push(index);
    }

    fn cut(&mut self) {
        self.cuts.push(self.devices.len());
    }
}

impl Roll {
    fn add(&mut self, index: usize, device: &Device) {
        if !device.is_steady() {
            return self.others.push(index);
        }
        if !self.steady.devices.is_empty() && self.steady.devices.len().is_multiple_of(TOGETHER) {
            self.steady.cut();
        }
        self.steady.add(index, device);
    }
}

impl Sensing {
    /// Lists the devices of each kind, if the lists are not right any more.
    pub(crate) fn list(&mut self) {
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
    pub(crate) fn alone(&mut self, index: usize) -> Turn {
        let mut turn = std::mem::take(&mut self.alone);
        turn.clear();
        turn.add(index, &self.devices[index]);
        turn
    }
    /// See [`Sensing::alone`].
    pub(crate) fn was_alone(&mut self, turn: Turn) {
        self.alone = turn;
    }

    /// The devices of a kind, as they were listed last.
    pub(crate) fn roll(&self, kind: usize) -> Rc<Roll> {
        self.rolls.get(kind).cloned().unwrap_or_default()
    }

    /// Of the next devices of a roll that are asked, from the `from`-th on, those that measure at this time; how many were
    /// looked at. What they measured before may be seen now, whether they measure now or not.
    pub(crate) fn due(&mut self, roll: &Roll, from: usize, time: f64, turn: &mut Turn) -> usize {
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
