//! Lists of sensors of a kind that measure together.

use super::{device::Device, targets::Sees};

/// Sensors of a kind that are measured together, and what must be known of them before.
#[derive(Debug, Default)]
pub struct Turn {
    /// Their indices, ascending.
    pub devices: Vec<usize>,
    /// Places in `devices` at which another batch begins.
    pub cuts: Vec<usize>,
    /// What they look at; each once.
    pub sees: Vec<Sees>,
}

/// The sensors of a kind.
#[derive(Debug, Default)]
pub struct Roll {
    /// Those that measure in each step.
    pub steady: Turn,
    /// The others, ascending.
    pub(super) others: Vec<usize>,
}

/// So many sensors measure together: what is noted of them stays in the processor's caches from the first look at them
/// to the last one at what they measured.
pub(super) const TOGETHER: usize = 256;

impl Turn {
    pub(super) fn clear(&mut self) {
        let Turn { devices, cuts, sees } = self;
        devices.clear();
        cuts.clear();
        sees.clear();
    }

    pub(super) fn add(&mut self, index: usize, device: &Device) {
        let sees = device.layout.plan.sees(device.choice);
        if !self.sees.contains(&sees) {
            self.sees.push(sees);
        }
        self.devices.push(index);
    }

    pub(super) fn cut(&mut self) {
        self.cuts.push(self.devices.len());
    }
}

impl Roll {
    pub(super) fn add(&mut self, index: usize, device: &Device) {
        if !device.is_steady() {
            return self.others.push(index);
        }
        if !self.steady.devices.is_empty() && self.steady.devices.len().is_multiple_of(TOGETHER) {
            self.steady.cut();
        }
        self.steady.add(index, device);
    }
}
