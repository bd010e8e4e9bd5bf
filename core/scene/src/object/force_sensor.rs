//! Force sensors: rigid connections between a parent and its children that measure the transmitted load and break if
//! the load is too high.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};
use tatu_physics::JointId;
use tatu_plugin_api::safe::Value;

use super::ObjectKind;
use crate::property::{properties, text_of};

/// Maximum number of values that a filter combines.
pub const MAX_FILTER_SAMPLES: usize = 1000;

/// A force sensor. Forces are in N and torques in N m, in the sensor's frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the table of rows describes each property")]
pub struct ForceSensor {
    pub force: [f64; 3],
    pub torque: [f64; 3],
    pub median: bool,
    pub samples: usize,
    pub break_force: f64,
    pub break_torque: f64,
    pub break_count: u32,
    pub broken: bool,
    /// Whether the sensor has measured since the start of the run.
    pub measured: bool,
    /// Number of consecutive filtered values above a threshold.
    over: u32,
    /// The latest unfiltered values, each a force and a torque, newest last.
    last: VecDeque<[f64; 6]>,
    /// Id of its joint in the engine, if it connects two bodies.
    pub id: Option<JointId>,
}

impl Default for ForceSensor {
    fn default() -> Self {
        ForceSensor {
            force: [0.0; 3],
            torque: [0.0; 3],
            median: false,
            samples: 1,
            break_force: 0.0,
            break_torque: 0.0,
            break_count: 1,
            broken: false,
            measured: false,
            over: 0,
            last: VecDeque::new(),
            id: None,
        }
    }
}

impl ForceSensor {
    /// Clears the measurement of a sensor that no longer connects two bodies.
    pub(crate) fn clear_measurement(&mut self) {
        (self.force, self.torque, self.over) = ([0.0; 3], [0.0; 3], 0);
        self.last.clear();
    }

    /// Processes the force (N) and torque (N m) of an engine step; returns whether the sensor breaks.
    pub(crate) fn add_sample(&mut self, value: [f64; 6]) -> bool {
        self.last.push_back(value);
        while self.last.len() > self.samples {
            self.last.pop_front();
        }
        let filtered: [f64; 6] = std::array::from_fn(|i| {
            let mut all: Vec<f64> = self.last.iter().map(|v| v[i]).collect();
            if self.median {
                all.sort_unstable_by(f64::total_cmp);
                return (all[(all.len() - 1) / 2] + all[all.len() / 2]) / 2.0;
            }
            all.iter().sum::<f64>() / all.len() as f64
        });
        let [fx, fy, fz, tx, ty, tz] = filtered;
        (self.force, self.torque, self.measured) = ([fx, fy, fz], [tx, ty, tz], true);
        let above = |v: [f64; 3], limit: f64| limit > 0.0 && v.iter().map(|x| x * x).sum::<f64>() > limit * limit;
        self.over = match above(self.force, self.break_force) || above(self.torque, self.break_torque) {
            true => self.over + 1,
            false => 0,
        };
        self.over >= self.break_count.max(1)
    }
}

properties! { PROPERTIES: ForceSensor, PropertyOwner::Kind(ObjectKind::ForceSensor) =>
    "force_sensor.force" numbers 3 in "N", ReadOnly force: "Force that the objects below the sensor exert on it, in the sensor's frame, filtered.";
    "force_sensor.torque" numbers 3 in "N m", ReadOnly torque: "Torque that the objects below the sensor exert on it, about its origin, in the sensor's frame, filtered.";
    "force_sensor.measured" bool, ReadOnly measured: "Whether the sensor has measured, that is, whether it connects two shapes and a step has passed.";
    "force_sensor.filter" text of (&["mean", "median"]) = "mean", None { get |f: &ForceSensor| Value::text(if f.median { "median" } else { "mean" }), set |f: &mut ForceSensor, v| { f.median = text_of(v)? == "median"; Ok(true) } }: "How the newest values are combined.";
    "force_sensor.samples" int from 1.0 to (MAX_FILTER_SAMPLES as f64) = 1, None samples: "Number of values that are combined, one for each physics step.";
    "force_sensor.break_force" number in "N" from 0.0 = 0.0, None break_force: "Force above which the sensor breaks; 0: never.";
    "force_sensor.break_torque" number in "N m" from 0.0 = 0.0, None break_torque: "Torque above which the sensor breaks; 0: never.";
    "force_sensor.break_count" int from 1.0 to (u32::MAX as f64) = 1, None break_count: "Number of consecutive values that must exceed the threshold.";
    "force_sensor.broken" bool = false, Rebuild broken: "Whether the sensor is broken and no longer connects its shapes.";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn force_sensor_filters_and_breaks() {
        let mut median = ForceSensor { median: true, samples: 3, ..Default::default() };
        for z in [1.0, 100.0, 2.0] {
            median.add_sample([0.0, 0.0, z, 0.0, 0.0, 0.0]);
        }
        assert_eq!(median.force, [0.0, 0.0, 2.0]);
        let mut mean = ForceSensor { samples: 2, break_force: 5.0, break_count: 2, ..Default::default() };
        let breaks = [2.0, 12.0, 2.0, 1.0].map(|z| mean.add_sample([0.0, 0.0, z, 0.0, 0.0, 0.0]));
        assert_eq!((breaks, mean.force), ([false, false, true, false], [0.0, 0.0, 1.5]));
    }
}
