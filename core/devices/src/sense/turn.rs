//! The sensors of a kind that measure together.

use super::{device::Device, targets::Sees};

/// Sensors of a kind that measure together, with the data that this requires.
#[derive(Debug, Default)]
pub struct Turn {
    /// Indices of the sensors, ascending.
    pub devices: Vec<usize>,
    /// Positions in `devices` at which a new batch begins.
    pub cuts: Vec<usize>,
    /// The distinct sets of targets of the sensors.
    pub sees: Vec<Sees>,
}

/// The sensors of a kind, by whether they measure in every step.
#[derive(Debug, Default)]
pub struct Roll {
    /// Sensors that measure in every step.
    pub steady: Turn,
    /// Indices of all other sensors, ascending.
    pub(super) others: Vec<usize>,
}

/// Maximum number of sensors in a batch, so that their data remains in the processor's caches during the measurement.
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
