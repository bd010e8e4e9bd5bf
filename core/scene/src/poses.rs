//! Poses of objects: reading and setting them, and updating the poses of descendants.

use nalgebra::Isometry3;

use super::{ObjectVariant, Scene};

impl Scene {
    /// Returns the pose of an object in the frame of its parent (the moving frame, if the parent is a joint).
    pub fn local(&self, slot: u32) -> Isometry3<f64> {
        self.places.local.get(slot as usize).copied().unwrap_or_default()
    }
    /// Returns the world pose of an object.
    #[inline]
    pub fn world(&self, slot: u32) -> Isometry3<f64> {
        match self.places.links.get(slot as usize) {
            Some(link) if link.hangs => self.frame(link.parent) * self.places.local[slot as usize],
            Some(_) => self.places.world[slot as usize],
            None => Isometry3::identity(),
        }
    }
    /// Returns the frame of an object's children, which is the object's own frame, displaced by the joint position if
    /// the object is a joint. Returns the world frame if `slot` is 0.
    pub fn frame(&self, slot: u32) -> Isometry3<f64> {
        let world = self.world(slot);
        let is_joint = self.places.links.get(slot as usize).is_some_and(|l| l.joint);
        let joint = if is_joint { self.get(slot).and_then(|o| o.joint()) } else { None };
        joint.map_or(world, |j| world * j.motion())
    }
    /// Returns the frame of an object's parent, in which the object's local pose is expressed.
    pub fn parent_frame(&self, slot: u32) -> Isometry3<f64> {
        self.frame(self.places.links.get(slot as usize).map_or(0, |l| l.parent))
    }
    /// Returns the world pose of an object at the last barrier, or `None` if it did not exist yet or there was no
    /// barrier.
    pub fn pose_at_barrier(&self, slot: u32) -> Option<Isometry3<f64>> {
        self.places.pose_at_barrier(slot)
    }
    /// Marks a barrier: from now on, `pose_at_barrier` returns the current poses.
    pub fn mark_barrier(&mut self) {
        self.places.mark_barrier();
    }
    /// Discards the poses at the last barrier.
    pub fn discard_barrier_poses(&mut self) {
        self.places.discard_barrier_poses();
    }

    /// Sets the pose of an object in its parent's frame, and moves all descendants.
    pub fn set_local(&mut self, slot: u32, local: Isometry3<f64>) {
        if self.get(slot).is_some() {
            self.places.record_pose(slot);
            self.places.local[slot as usize] = local;
        }
        self.refresh(slot);
    }
    /// Sets the world pose of an object, and moves all descendants.
    pub fn set_world(&mut self, slot: u32, world: Isometry3<f64>) {
        let frame = self.parent_frame(slot);
        self.set_local(slot, frame.inverse() * world);
    }
    /// Recomputes the world poses of an object and all its descendants, or of all objects if `slot` is 0, from local
    /// poses.
    pub fn refresh(&mut self, slot: u32) {
        let mut walk = std::mem::take(&mut self.walk);
        match slot {
            0 => walk.extend(self.roots().iter().map(|s| (*s, Isometry3::identity()))),
            _ => walk.push((slot, self.parent_frame(slot))),
        }
        while let Some((slot, frame)) = walk.pop() {
            if self.get(slot).is_none() {
                continue;
            }
            self.store_world_pose(slot, frame * self.places.local[slot as usize]);
            if !self.children(slot).is_empty() {
                let frame = self.frame(slot);
                walk.extend(self.children(slot).iter().map(|s| (*s, frame)));
            }
        }
        self.walk = walk;
    }
    /// Stores the world pose of an object without updating its local pose or its descendants.
    #[inline]
    pub(super) fn store_world_pose(&mut self, slot: u32, world: Isometry3<f64>) {
        if self.places.store_world_pose(slot, world) && self.places.links[slot as usize].shape {
            self.moves.record(slot);
        }
    }

    /// Makes an object store its world pose from now on, if it hangs (see `transforms`).
    pub(super) fn stop_hanging(&mut self, slot: u32) {
        let at = slot as usize;
        if self.places.links.get(at).is_some_and(|l| l.hangs) {
            self.places.record_pose(slot);
            self.places.world[at] = self.world(slot);
            self.places.links[at].hangs = false;
        }
    }
    /// Makes an object hang (see `transforms`), unless it is a shape, a script or a root, has children, or is the child
    /// of a joint; such an object stores its world pose instead. The stored pose must equal the pose computed from that
    /// of the parent, to the last bit.
    pub(super) fn start_hanging(&mut self, slot: u32) {
        let Some(o) = self.get(slot) else { return };
        let watched = matches!(o.data, ObjectVariant::Shape(_) | ObjectVariant::Script) || !o.children.is_empty();
        if watched || o.parent == 0 || self.places.links[o.parent as usize].joint {
            self.stop_hanging(slot);
        } else if !self.places.links[slot as usize].hangs {
            self.places.record_pose(slot);
            self.places.links[slot as usize].hangs = true;
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Translation3;

    use super::*;
    use crate::{Joint, JointType, Shape};

    fn at(x: f64) -> Isometry3<f64> {
        Isometry3::from_parts(Translation3::new(x, 0.0, 0.0), crate::from_euler([0.1, 0.2, x]))
    }

    /// A shape with two frames for sensors, one of them on a joint.
    fn scene() -> (Scene, [u32; 4]) {
        let mut s = Scene::default();
        let base = s.add(0, "base", at(1.0), ObjectVariant::Shape(Box::<Shape>::default())).unwrap();
        let frame = s.add(base, "frame", at(0.5), ObjectVariant::Dummy(None)).unwrap();
        let joint = Joint { kind: JointType::Prismatic, ..Joint::default() };
        let joint = s.add(base, "joint", at(0.25), ObjectVariant::Joint(Box::new(joint))).unwrap();
        let moved = s.add(joint, "moved", at(0.125), ObjectVariant::Dummy(None)).unwrap();
        let all = [base, frame, joint, moved];
        all.iter().for_each(|slot| s.start_hanging(*slot));
        (s, all)
    }

    #[test]
    fn hanging_object_has_the_pose_it_would_store() {
        let (mut s, [base, frame, joint, moved]) = scene();
        let hanging = |s: &Scene| [base, frame, joint, moved].map(|x| s.places.links[x as usize].hangs);
        assert_eq!(hanging(&s), [false, true, false, false]);
        s.mark_barrier();
        let old = s.world(frame);
        s.set_local(base, at(3.0));
        assert_eq!(s.world(frame), at(3.0) * at(0.5));
        assert_eq!(s.pose_at_barrier(frame), Some(old));
        assert_eq!(s.pose_at_barrier(base), Some(at(1.0)));
        // The pose at the last barrier does not change when the object gets a new parent.
        s.set_local(frame, at(0.75));
        assert_eq!((s.world(frame), s.pose_at_barrier(frame)), (at(3.0) * at(0.75), Some(old)));
        let here = s.world(frame);
        assert!(s.set_parent(frame, joint));
        assert_eq!((s.world(frame), s.pose_at_barrier(frame)), (here, Some(old)));
        s.start_hanging(frame);
        assert_eq!(hanging(&s), [false; 4]);
        s.mark_barrier();
        assert_eq!(s.pose_at_barrier(frame), Some(here));
    }

    #[test]
    fn moved_object_has_its_old_pose_at_the_barrier() {
        let (mut s, [base, frame, _, moved]) = scene();
        assert_eq!(s.pose_at_barrier(base), None, "there was no barrier yet");
        s.mark_barrier();
        let (still, old) = (s.world(moved), s.world(frame));
        assert_eq!((s.pose_at_barrier(moved), s.pose_at_barrier(frame)), (Some(still), Some(old)));
        let made = s.add(base, "made", at(0.0), ObjectVariant::Dummy(None)).unwrap();
        assert_eq!(s.pose_at_barrier(made), None, "the object did not exist at the barrier");
        s.set_local(made, at(0.5));
        s.start_hanging(made);
        assert_eq!(s.pose_at_barrier(made), None, "a move does not change that");
        s.mark_barrier();
        assert_eq!(s.pose_at_barrier(made), Some(s.world(made)));
        // Nothing has moved since this barrier, so the poses at the barrier are the current ones.
        s.set_local(base, at(2.0));
        s.mark_barrier();
        assert_eq!(s.pose_at_barrier(frame), Some(at(2.0) * at(0.5)));
        s.discard_barrier_poses();
        assert_eq!(s.pose_at_barrier(frame), None);
        s.remove(moved);
        s.mark_barrier();
        assert_eq!(s.world(moved), Isometry3::identity());
    }
}
