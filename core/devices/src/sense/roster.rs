//! The sensors of a kind that measure together.

use super::{device::SensorDevice, targets::TargetFilter};

/// Sensors of a kind that measure together, with the data that this requires.
#[derive(Debug, Default)]
pub struct DueSensors {
    /// Indices of the sensors, ascending.
    pub devices: Vec<usize>,
    /// Positions in `devices` at which a new batch begins.
    pub batch_starts: Vec<usize>,
    /// The distinct sets of targets of the sensors.
    pub filters: Vec<TargetFilter>,
}

/// The sensors of a kind, by whether they measure in every step.
#[derive(Debug, Default)]
pub struct SensorRoster {
    /// Sensors that measure in every step.
    pub steady: DueSensors,
    /// Indices of all other sensors, ascending.
    pub(super) others: Vec<usize>,
}

/// Maximum number of sensors in a batch, so that their data remains in the processor's caches during the measurement.
pub(super) const MAX_BATCH_SENSORS: usize = 256;

impl DueSensors {
    pub(super) fn clear(&mut self) {
        let DueSensors { devices, batch_starts: cuts, filters: sees } = self;
        devices.clear();
        cuts.clear();
        sees.clear();
    }

    pub(super) fn add(&mut self, index: usize, device: &SensorDevice) {
        let sees = device.layout.plan.target_filter(device.chosen.choice);
        if !self.filters.contains(&sees) {
            self.filters.push(sees);
        }
        self.devices.push(index);
    }

    pub(super) fn start_batch(&mut self) {
        self.batch_starts.push(self.devices.len());
    }
}

impl SensorRoster {
    pub(super) fn add(&mut self, index: usize, device: &SensorDevice) {
        if !device.is_steady() {
            return self.others.push(index);
        }
        if !self.steady.devices.is_empty() && self.steady.devices.len().is_multiple_of(MAX_BATCH_SENSORS) {
            self.steady.start_batch();
        }
        self.steady.add(index, device);
    }
}
