//! Targets of sensors and actuators.

use crate::abi::*;

/// A target of a sensor or an actuator: one of the objects that the scene lists as its `targets`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// The object.
    pub object: tatu_object,
    /// Its pose in the world frame: x y z (m), quaternion x y z w.
    pub pose: [f64; 7],
    /// Its twist in the world frame: m/s, then rad/s.
    pub twist: [f64; 6],
}

/// The arrays of targets in a batch.
#[derive(Clone, Copy)]
pub(crate) struct TargetArrays {
    pub first: *const u64,
    pub object: *const tatu_object,
    pub pose: *const f64,
    pub twist: *const f64,
}

impl TargetArrays {
    /// Returns the range of the targets of instance `i`, which is empty if there are no arrays.
    ///
    /// # Safety
    /// `first` must be null or have elements `i` and `i + 1`.
    pub unsafe fn range(&self, i: usize) -> std::ops::Range<usize> {
        match self.first.is_null() {
            true => 0..0,
            // SAFETY: as required of the caller.
            false => unsafe { *self.first.add(i) as usize..*self.first.add(i + 1) as usize },
        }
    }

    /// Returns the targets of instance `i`; `None` stands for an object that does not exist.
    ///
    /// # Safety
    /// `first` must be null, or the arrays must be those of a batch with more than `i` instances, valid for `'a`.
    pub unsafe fn of<'a>(self, i: usize) -> impl ExactSizeIterator<Item = Option<Target>> + use<'a> {
        // SAFETY: as required of the caller.
        let range = unsafe { self.range(i) };
        range.map(move |k| {
            // SAFETY: the caller guarantees that the arrays contain all targets of the batch.
            let target = unsafe {
                Target {
                    object: *self.object.add(k),
                    pose: *self.pose.cast::<[f64; 7]>().add(k),
                    twist: *self.twist.cast::<[f64; 6]>().add(k),
                }
            };
            (target.object != 0).then_some(target)
        })
    }
}
