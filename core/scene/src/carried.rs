//! Copying states of the engine back: to bodies and joints, and to what they carry.

use std::{collections::BTreeMap, ops::Range};

use rayon::prelude::*;

use super::{Data, Dynamics, Joint, Scene, part::Part};
use tatu_physics::{BodyId, Engine, JointId, JointState};

/// An object that moves with the engine.
struct Place {
    slot: u32,
    parent: u32,
    from: From,
}

/// What decides where it is.
enum From {
    /// Its body.
    Body(BodyId),
    /// Its frame; its joint has a state too.
    Joint(JointId),
    /// Its frame.
    Frame,
}

/// Objects that a thread can see to while another one sees to others.
#[derive(Default)]
struct Group {
    /// Places in the list.
    places: Range<usize>,
    /// Slots of theirs, and of their parents.
    slots: Range<u32>,
    /// Shapes that have moved, in order.
    moved: Vec<u32>,
}

/// The objects that move with the engine. All others are where they were put.
#[derive(Default)]
pub(super) struct Carried {
    /// Robot by robot, parents before children, without those that hang.
    list: Vec<Place>,
    /// Ascending and apart, all of the list.
    groups: Vec<Group>,
    /// The version of the tree that it was made of; 0: of none.
    listed: u64,
    /// The version at which all objects were gone through last: a change of the tree leaves places that do not follow
    /// from those above to the last bit.
    whole: u64,
}

impl Carried {
    /// What a snapshot keeps.
    pub fn whole(&self) -> u64 {
        self.whole
    }
    /// After a snapshot.
    pub fn after(whole: u64) -> Self {
        Carried { whole, ..Carried::default() }
    }
}

impl Dynamics {
    /// Copies poses and joint states back. Parents come before children, so each child finds its frame already moved.
    pub(super) fn copy_back(&mut self, scene: &mut Scene) {
        if self.carried.whole != scene.shape_version {
            return self.copy_all(scene);
        }
        if self.carried.listed != scene.shape_version {
            self.list_carried(scene);
        }
        let Dynamics { engine, carried: Carried { list, groups, .. }, .. } = self;
        let (engine, list) = (&**engine, &*list);
        let (parts, moves) = scene.parts(groups.iter().map(|group| group.slots.clone()));
        let alone = list.len() < FEWEST || rayon::current_num_threads() == 1;
        let work = |(group, mut part): (&mut Group, Part<'_>)| group.copy_back(list, &mut part, engine);
        match alone {
            true => groups.iter_mut().zip(parts).for_each(work),
            false => groups.par_iter_mut().zip(parts).for_each(work),
        }
        for slot in groups.iter_mut().flat_map(|group| group.moved.drain(..)) {
            moves.note(slot);
        }
    }

    /// The same for every object, whatever carries it; who may hang, hangs from now on.
    fn copy_all(&mut self, scene: &mut Scene) {
        for record in &self.joints {
            if let Some(Data::Joint(joint)) = scene.get_mut(record.tie).map(|o| &mut o.data) {
                joint.take(&self.engine.joint_state(record.id));
            }
        }
        scene.visit(|scene, slot| {
            let frame = scene.parent_frame(slot);
            let body = scene.get(slot).and_then(|o| o.shape()).filter(|s| s.dynamic).and_then(|s| s.body.0);
            let world = match body {
                Some(id) => {
                    let world = self.engine.pose(id);
                    scene.places.local[slot as usize] = frame.inverse() * world;
                    world
                }
                None => frame * scene.places.local[slot as usize],
            };
            scene.put(slot, world);
            scene.hang(slot);
        });
        self.carried = Carried::after(scene.shape_version);
    }

    fn list_carried(&mut self, scene: &Scene) {
        let list = &mut self.carried.list;
        list.clear();
        // Where several joints of the engine stand for one, the last counts.
        let joints: BTreeMap<u32, JointId> = self.joints.iter().map(|j| (j.tie, j.id)).collect();
        let mut walk: Vec<(u32, u32, bool)> = scene.roots().iter().rev().map(|s| (*s, 0, false)).collect();
        while let Some((slot, parent, moves)) = walk.pop() {
            let Some(o) = scene.get(slot) else { continue };
            let from = match (&o.data, joints.get(&slot)) {
                (Data::Shape(s), _) if s.dynamic => s.body.0.map_or(From::Frame, From::Body),
                (Data::Joint(_), Some(id)) => From::Joint(*id),
                _ => From::Frame,
            };
            let moves = moves || !matches!(from, From::Frame);
            walk.extend(o.children.iter().rev().map(|s| (*s, slot, moves)));
            if moves && !scene.places.links[slot as usize].hangs {
                list.push(Place { slot, parent, from });
            }
        }
        self.carried.groups = groups(&self.carried.list);
        self.carried.listed = scene.shape_version;
    }
}

/// Cuts a list between robots, where slots ascend.
fn groups(list: &[Place]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (i, place) in list.iter().enumerate() {
        let low = if place.parent == 0 { place.slot } else { place.slot.min(place.parent) };
        let mut slots = low..place.slot.max(place.parent) + 1;
        let mut places = i..i + 1;
        while let Some(last) = groups.pop_if(|last| slots.start < last.slots.end || last.places.len() < LEAST) {
            slots = slots.start.min(last.slots.start)..slots.end.max(last.slots.end);
            places.start = last.places.start;
        }
        groups.push(Group { places, slots, moved: Vec::new() });
    }
    groups
}

impl Group {
    /// Copies the states of the places of a list that are its own.
    fn copy_back(&mut self, list: &[Place], part: &mut Part<'_>, engine: &dyn Engine) {
        let list = &list[self.places.clone()];
        for Place { slot, parent, from } in list {
            let frame = part.frame(*parent);
            let world = match from {
                From::Body(id) => {
                    let world = engine.pose(*id);
                    *part.local(*slot) = frame.inverse() * world;
                    world
                }
                From::Joint(id) => {
                    if let Some(joint) = part.joint(*slot) {
                        joint.take(&engine.joint_state(*id));
                    }
                    frame * *part.local(*slot)
                }
                From::Frame => frame * *part.local(*slot),
            };
            if part.put(*slot, world) {
                self.moved.push(*slot);
            }
        }
    }
}

impl Joint {
    /// Takes over what the engine tells of it.
    fn take(&mut self, state: &JointState) {
        (self.position, self.velocity, self.effort) = (state.position, state.velocity, state.effort);
    }
}

/// Fewer places are seen to sooner than another thread has come,
const FEWEST: usize = 1024;
/// and so many at least are one thread's.
const LEAST: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;

    fn list(places: impl IntoIterator<Item = (u32, u32)>) -> Vec<Place> {
        places.into_iter().map(|(slot, parent)| Place { slot, parent, from: From::Frame }).collect()
    }

    #[track_caller]
    fn check(list: &[Place], expected: usize) {
        let groups = groups(list);
        assert_eq!(groups.len(), expected);
        let places: Vec<usize> = groups.iter().flat_map(|g| g.places.clone()).collect();
        assert!(places.into_iter().eq(0..list.len()), "all of the list, in order");
        assert!(groups.windows(2).all(|w| w[0].slots.end <= w[1].slots.start), "apart");
        for group in &groups {
            for place in &list[group.places.clone()] {
                assert!(group.slots.contains(&place.slot));
                assert!(place.parent == 0 || group.slots.contains(&place.parent));
            }
        }
    }

    #[test]
    fn robots_are_cut_apart_where_their_slots_are() {
        // Each a body on a base that stands still, with three objects on it.
        let robot = |r: u32| [(2, 1), (3, 2), (4, 2), (5, 3)].map(|(slot, parent)| (5 * r + slot, 5 * r + parent));
        check(&list((0..64).flat_map(robot)), 4);
        check(&list((0..64).rev().flat_map(robot)), 1);
        // The last object of each robot was made after all others.
        let late = |r: u32| robot(r).map(|(slot, parent)| (if slot % 5 == 0 { 1000 + slot } else { slot }, parent));
        check(&list((0..64).flat_map(late)), 1);
        check(&[], 0);
    }
}
