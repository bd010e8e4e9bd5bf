//! The targets of sensors and actuators, as arrays of a batch.

use std::ptr::null;

use tatu_plugin_api::{abi::*, safe::Target};

/// The targets of several instances.
pub struct TargetLists {
    pub first: Vec<u64>,
    pub object: Vec<tatu_object>,
    pub pose: Vec<[f64; 7]>,
    pub twist: Vec<[f64; 6]>,
}

impl TargetLists {
    /// Joins the targets of instances; `None` stands for an object that does not exist.
    pub fn of<'a>(all: impl IntoIterator<Item = &'a [Option<Target>]>) -> Self {
        let mut out = TargetLists { first: vec![0], object: Vec::new(), pose: Vec::new(), twist: Vec::new() };
        let missing = Target { object: 0, pose: [f64::NAN; 7], twist: [f64::NAN; 6] };
        for targets in all {
            for target in targets.iter().map(|t| t.unwrap_or(missing)) {
                out.object.push(target.object);
                out.pose.push(target.pose);
                out.twist.push(target.twist);
            }
            out.first.push(out.object.len() as u64);
        }
        out
    }

    /// Adds the arrays to a batch of sensors, if their kind requires targets.
    pub fn add_to(&self, inputs: u32, batch: tatu_sensor_batch) -> tatu_sensor_batch {
        let declared = inputs & TATU_IN_TARGETS != 0;
        tatu_sensor_batch {
            first_target: if declared { self.first.as_ptr() } else { null() },
            target: if declared { self.object.as_ptr() } else { null() },
            target_pose: if declared { self.pose.as_ptr().cast() } else { null() },
            target_twist: if declared { self.twist.as_ptr().cast() } else { null() },
            ..batch
        }
    }
}
