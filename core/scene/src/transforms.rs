//! Poses of objects, in dense tables indexed by slot. The data that a step iterates over is thus contiguous, and
//! separate from the other data of objects.
//!
//! An object *hangs* if its world pose is not stored but computed on demand from that of its parent. A hundred sensors
//! on a moving robot then cost no time, except for those that measure.

use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

/// The data of a slot's object that is needed to iterate over poses.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(super) struct PoseLink {
    /// Number of objects that have occupied the slot so far.
    pub generation: u64,
    /// Slot of the parent, or 0 for the world.
    pub parent: u32,
    /// Number of the barrier for which the pose in `pose_at_barrier` was last recorded.
    noted: u32,
    /// Whether the object was created after the barrier in `noted`, and therefore has no earlier pose.
    new: bool,
    /// Whether the world pose is computed on demand.
    pub hangs: bool,
    /// Whether the object is a joint, which moves the frame of its children.
    pub joint: bool,
    /// Whether the object is a shape; a shape that has moved is listed in [`MoveLog`](crate::MoveLog).
    pub shape: bool,
    /// Whether the object is the base of a model.
    pub model_base: bool,
    /// Whether the slot contains an object.
    pub there: bool,
}

/// The poses of all objects.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct PoseTables {
    pub links: Vec<PoseLink>,
    /// Poses in the parent's frame.
    pub local: Vec<Isometry3<f64>>,
    /// World poses; outdated for objects that hang.
    pub world: Vec<Isometry3<f64>>,
    /// World poses at the last barrier, for objects that have moved since.
    before: Vec<Isometry3<f64>>,
    /// Number of the last barrier.
    now: u32,
    /// Whether there was a barrier whose poses have not been discarded.
    known: bool,
}

impl Default for PoseTables {
    fn default() -> Self {
        let mut places = PoseTables {
            links: Vec::new(),
            local: Vec::new(),
            world: Vec::new(),
            before: Vec::new(),
            now: 1,
            known: false,
        };
        places.push();
        places
    }
}

impl PoseTables {
    /// Adds a slot.
    pub fn push(&mut self) {
        self.links.push(PoseLink::default());
        for table in [&mut self.local, &mut self.world, &mut self.before] {
            table.push(Isometry3::identity());
        }
    }

    /// Initialises a slot for a new object.
    pub fn init_slot(&mut self, slot: u32, parent: u32, local: Isometry3<f64>, world: Isometry3<f64>) {
        let at = slot as usize;
        let generation = self.links[at].generation + 1;
        self.links[at] =
            PoseLink { generation, parent, noted: self.now, new: true, there: true, ..PoseLink::default() };
        (self.local[at], self.world[at]) = (local, world);
    }

    /// Clears a slot whose object was removed.
    pub fn clear_slot(&mut self, slot: u32) {
        let at = slot as usize;
        self.links[at] = PoseLink { generation: self.links[at].generation, ..PoseLink::default() };
        (self.local[at], self.world[at]) = (Isometry3::identity(), Isometry3::identity());
    }

    /// Marks a barrier: from now on, `pose_at_barrier` returns the current poses.
    pub fn mark_barrier(&mut self) {
        self.known = true;
        self.now = self.now.wrapping_add(1);
        if self.now == 0 {
            self.now = 1;
            self.links.iter_mut().for_each(|l| l.noted = 0);
        }
    }

    /// Discards the poses at the last barrier.
    pub fn discard_barrier_poses(&mut self) {
        self.known = false;
    }

    /// Records the pose of an object before it is moved, gets a different parent, or starts or stops hanging.
    #[inline]
    pub fn record_pose(&mut self, slot: u32) {
        let at = slot as usize;
        if self.links[at].noted != self.now {
            self.before[at] = self.at_barrier(slot);
            (self.links[at].noted, self.links[at].new) = (self.now, false);
        }
    }

    /// Returns the world pose of an object at the last barrier, or `None` if it did not exist yet or there was no
    /// barrier.
    pub fn pose_at_barrier(&self, slot: u32) -> Option<Isometry3<f64>> {
        let link = self.links.get(slot as usize)?;
        let unknown = !self.known || link.new && link.noted == self.now;
        (!unknown).then(|| self.at_barrier(slot))
    }

    fn at_barrier(&self, slot: u32) -> Isometry3<f64> {
        let at = slot as usize;
        match self.links[at] {
            link if link.noted == self.now => self.before[at],
            // The parent of an object that hangs is never a joint.
            link if link.hangs => self.at_barrier(link.parent) * self.local[at],
            _ => self.world[at],
        }
    }

    /// Stores the world pose of an object; returns whether it has changed. Does nothing for an object that hangs.
    #[inline]
    pub fn store_world_pose(&mut self, slot: u32, world: Isometry3<f64>) -> bool {
        let (at, link) = (slot as usize, &mut self.links[slot as usize]);
        if link.hangs {
            return false;
        }
        if link.noted != self.now {
            self.before[at] = self.world[at];
            (link.noted, link.new) = (self.now, false);
        }
        std::mem::replace(&mut self.world[at], world) != world
    }
}
