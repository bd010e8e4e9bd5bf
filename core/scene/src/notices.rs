//! Warnings that are given once for each object, whether it comes from a file or was created during the run.

use std::collections::BTreeSet;

/// The kind of a warning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum NoticeKind {
    /// A mesh that encloses no volume, so its hull determines mass properties.
    OpenMesh,
    /// A sphere whose extents differ.
    Ellipsoid,
    /// A choice of solver that is not used.
    Solver,
    /// A dynamic shape below a kinematic joint.
    KinematicJoint,
    /// A target of a motor without torque.
    NoTorque,
}

/// The warnings that have been given, by kind and uid of the object, and those that are still to be given.
#[derive(Default)]
pub(crate) struct NoticeQueue {
    given: BTreeSet<(NoticeKind, u64)>,
    pending: Vec<String>,
}

impl NoticeQueue {
    /// Returns the warnings that have not been given yet.
    pub fn take_pending(&mut self) -> Vec<String> {
        std::mem::take(&mut self.pending)
    }

    /// Returns whether a warning is given for the first time for an object.
    pub fn is_new(&mut self, notice: NoticeKind, uid: u64) -> bool {
        self.given.insert((notice, uid))
    }

    /// Adds a warning.
    pub fn add(&mut self, text: String) {
        self.pending.push(text);
    }
}
