//! The table of joints, in whichever form they are solved.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::record::{JointRecord, MeasuredJoint};
use crate::{BodyId, JointId, rapier::bodies::Bodies};

/// All joints, and lists of those that need attention in a step.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct Joints {
    /// Joints by id; `None` for removed joints.
    pub records: Vec<Option<JointRecord>>,
    /// Whether joints were added or removed since gears and loads were last updated.
    pub structure_changed: bool,
    /// Joints whose drive has not been passed to their solver yet.
    pub pending: Vec<JointId>,
    /// Joints with a position drive.
    pub positioned: Vec<JointId>,
    /// Joints that their drives stop, ascending.
    pub stopped: Vec<JointId>,
    /// Joints whose drive weakens with speed.
    pub weakening: Vec<JointId>,
    /// Revolute joints whose limits allow more than one turn.
    pub winding: Vec<JointId>,
    /// Joints whose load is measured.
    pub measured: Vec<MeasuredJoint>,
}

impl Joints {
    pub fn get(&self, joint: JointId) -> Option<&JointRecord> {
        self.records.get(joint.0 as usize)?.as_ref()
    }

    pub fn get_mut(&mut self, joint: JointId) -> Option<&mut JointRecord> {
        self.records.get_mut(joint.0 as usize)?.as_mut()
    }

    pub fn iter(&self) -> impl Iterator<Item = &JointRecord> {
        self.records.iter().flatten()
    }

    /// Returns the joints on a body.
    pub fn on(&self, body: BodyId) -> Vec<JointId> {
        let on_it = |r: &JointRecord| r.bodies.0 == body || r.bodies.1 == body;
        let joints = (0..).map(JointId).zip(&self.records);
        joints.filter(|(_, r)| r.as_ref().is_some_and(on_it)).map(|(id, _)| id).collect()
    }

    /// Adds a joint and returns its id.
    pub fn insert(&mut self, record: JointRecord) -> JointId {
        let id = JointId(self.records.len() as u32);
        self.structure_changed = true;
        if record.is_wide() {
            self.winding.push(id);
        }
        if record.passive.no_load_speed > 0.0 {
            self.weakening.push(id);
        }
        self.records.push(Some(record));
        id
    }

    /// Removes a joint from the table and returns its record.
    pub fn take(&mut self, joint: JointId) -> Option<JointRecord> {
        let record = self.records.get_mut(joint.0 as usize)?.take()?;
        self.structure_changed = true;
        self.weakening.retain(|j| *j != joint);
        self.winding.retain(|j| *j != joint);
        Some(record)
    }

    /// Marks a joint whose drive must be passed to its solver, once.
    pub fn mark_pending(&mut self, joint: JointId) {
        if let Some(Some(record)) = self.records.get_mut(joint.0 as usize)
            && !std::mem::replace(&mut record.drive.pending, true)
        {
            self.pending.push(joint);
        }
    }

    /// Returns the lowest body id in the mechanism of each body with joints.
    pub fn mechanism_roots(&self) -> BTreeMap<BodyId, BodyId> {
        let mut above: BTreeMap<BodyId, BodyId> = BTreeMap::new();
        fn root(above: &BTreeMap<BodyId, BodyId>, mut id: BodyId) -> BodyId {
            while let Some(next) = above.get(&id).filter(|n| **n != id) {
                id = *next;
            }
            id
        }
        for record in self.iter() {
            let (a, b) = (root(&above, record.bodies.0), root(&above, record.bodies.1));
            above.insert(a.max(b), a.min(b));
            above.entry(a.min(b)).or_insert(a.min(b));
        }
        above.keys().map(|id| (*id, root(&above, *id))).collect()
    }

    /// Returns the dynamic bodies that joints connect to a body, directly or through others.
    pub fn connected(&self, bodies: &Bodies, body: BodyId) -> BTreeSet<BodyId> {
        let dynamic = |id: BodyId| bodies.is_dynamic(id);
        let mut found: BTreeSet<BodyId> = [body].into_iter().filter(|b| dynamic(*b)).collect();
        loop {
            let before = found.len();
            for (a, b) in self.iter().map(|r| r.bodies) {
                if found.contains(&a) || found.contains(&b) {
                    found.extend([a, b].into_iter().filter(|id| dynamic(*id)));
                }
            }
            if found.len() == before {
                return found;
            }
        }
    }

    /// Returns the bodies below a joint, in ascending order of ids.
    pub fn bodies_below(&self, joint: JointId) -> Vec<BodyId> {
        let Some(first) = self.get(joint) else { return Vec::new() };
        let mut found = vec![first.bodies.1];
        // Joints are not sorted, so this repeats until nothing is added.
        loop {
            let known = found.len();
            for record in self.iter().filter(|r| !r.closes_loop) {
                if found.contains(&record.bodies.0) && !found.contains(&record.bodies.1) {
                    found.push(record.bodies.1);
                }
            }
            if found.len() == known {
                found.sort_unstable();
                return found;
            }
        }
    }
}
