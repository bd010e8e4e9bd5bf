//! The mechanisms that joints form: found when joints or adopted bodies change, and brought in line with bodies that
//! were moved from outside.

use std::collections::{BTreeMap, BTreeSet};

use tatu_mechanisms::ContactSide;

use super::{
    build::{build, place_bodies, read_state},
    gears::{independent_link, read_gaps},
    records::{LinkPlace, Mechanism},
    table::TreeJoints,
};
use crate::{
    BodyId, JointId,
    rapier::{bodies::Bodies, joints::table::Joints},
};

impl TreeJoints {
    /// Rebuilds the mechanisms if joints were added or removed, or bodies were adopted or released. Joints that existed
    /// before keep their positions and velocities; those of new joints are computed from the bodies.
    pub(super) fn arrange(&mut self, bodies: &mut Bodies, joints: &Joints) {
        if std::mem::take(&mut self.changed) {
            let (mut old, mut calm) = (BTreeMap::new(), BTreeMap::new());
            for mechanism in std::mem::take(&mut self.mechanisms) {
                store_joint_states(&mechanism, &mut old);
                calm.insert(mechanism.bodies, mechanism.calm_s);
            }
            for (root, links) in self.mechanism_joints(bodies, joints) {
                let mut mechanism = Mechanism::new(root);
                if bodies.is_dynamic(root) {
                    (mechanism.joints, mechanism.bodies) = (vec![None], vec![root]);
                }
                for joint in links {
                    mechanism.joints.push(Some(joint));
                    mechanism.bodies.extend(joints.get(joint).map(|r| r.bodies.1));
                }
                mechanism.gears = self.gears_of(joints, &mechanism.joints);
                read_coordinates(&mut mechanism, bodies, joints, &old);
                mechanism.calm_s = calm.get(&mechanism.bodies).copied().unwrap_or(0.0);
                self.mechanisms.push(mechanism);
            }
        }
        self.freeze_disabled_mechanisms(bodies);
        let mut anew = false;
        for i in 0..self.mechanisms.len() {
            if self.mechanisms[i].built.is_none() && !self.mechanisms[i].frozen {
                anew = true;
                let built = build(&self.mechanisms[i], bodies, joints).map(Box::new);
                match built {
                    Some(built) => {
                        self.mechanisms[i].built = Some(built);
                        // The poses of bodies that were placed from outside must be read before they are overwritten.
                        let mechanism = &self.mechanisms[i];
                        if !mechanism.bodies.iter().any(|b| bodies.moved.contains(b)) {
                            place_bodies(&mut self.mechanisms[i], bodies);
                        }
                    }
                    None => self.freeze_mechanism(bodies, i),
                }
            }
        }
        if anew {
            self.links = self.list_links();
        }
        self.update_moved_mechanisms(bodies, joints);
    }

    /// Returns the root of each mechanism and its joints, parents before children. Each joint on a body that is not
    /// dynamic starts a separate mechanism, unless gears connect them.
    fn mechanism_joints(&self, bodies: &Bodies, joints: &Joints) -> Vec<(BodyId, Vec<JointId>)> {
        let mut below: BTreeMap<BodyId, Vec<JointId>> = BTreeMap::new();
        let mut children = BTreeSet::new();
        for (id, record) in (0..).map(JointId).zip(&joints.records) {
            if let Some(record) = record.as_ref().filter(|r| r.is_in_tree()) {
                below.entry(record.bodies.0).or_default().push(id);
                children.insert(record.bodies.1);
            }
        }
        let mut found = Vec::new();
        for (root, first) in below.iter().filter(|(body, _)| !children.contains(body)) {
            if bodies.is_dynamic(*root) {
                found.push((*root, joints_below(joints, &below, first)));
            } else {
                let separate = first.iter().map(|joint| joints_below(joints, &below, &[*joint]));
                found.extend(self.join_geared(separate.collect()).into_iter().map(|list| (*root, list)));
            }
        }
        found.extend(self.adopted.keys().map(|body| (*body, Vec::new())));
        found
    }

    /// Returns, for each body of a mechanism, its mechanism and link.
    fn list_links(&self) -> BTreeMap<BodyId, ContactSide> {
        let mechanisms = self.mechanisms.iter().enumerate().filter(|(_, m)| !m.frozen);
        mechanisms
            .flat_map(|(member, m)| {
                m.bodies.iter().enumerate().map(move |(link, b)| (*b, ContactSide { member, link }))
            })
            .collect()
    }

    /// Freezes mechanisms that contain a frozen body.
    fn freeze_disabled_mechanisms(&mut self, bodies: &mut Bodies) {
        for i in 0..self.mechanisms.len() {
            let mechanism = &self.mechanisms[i];
            let mut links = mechanism.bodies.iter().filter_map(|b| bodies.body(*b));
            if !mechanism.frozen && links.any(|b| !b.is_enabled()) {
                self.freeze_mechanism(bodies, i);
            }
        }
    }

    /// Freezes all bodies of a mechanism; [`Engine::quarantined`](crate::Engine::quarantined) reports them.
    pub(super) fn freeze_mechanism(&mut self, bodies: &mut Bodies, index: usize) {
        (self.mechanisms[index].frozen, self.mechanisms[index].built) = (true, None);
        for body in self.mechanisms[index].bodies.clone() {
            bodies.freeze(body);
        }
        self.links = self.list_links();
    }

    /// Updates mechanisms with bodies whose pose or velocity was set from outside: joint states are computed from the
    /// bodies, and the bodies are then moved onto the links.
    fn update_moved_mechanisms(&mut self, bodies: &mut Bodies, joints: &Joints) {
        if bodies.moved.is_empty() {
            return;
        }
        for i in 0..self.mechanisms.len() {
            let mechanism = &self.mechanisms[i];
            if !mechanism.bodies.iter().any(|b| bodies.moved.contains(b)) {
                continue;
            }
            let (mut q, mut v) = (mechanism.q.clone(), mechanism.v.clone());
            for link in (0..mechanism.joints.len()).filter(|link| mechanism.gears[*link].is_none()) {
                let LinkPlace { position, velocity, .. } = mechanism.places[link];
                let near = mechanism.q.get(position).copied();
                let (positions, velocities) = read_state(mechanism, link, near, bodies, joints);
                q[position..][..positions.len()].copy_from_slice(&positions);
                v[velocity..][..velocities.len()].copy_from_slice(&velocities);
            }
            let mechanism = &mut self.mechanisms[i];
            (mechanism.q, mechanism.v) = (q, v);
            mechanism.calm_s = 0.0;
            read_gaps(mechanism, bodies, joints);
            place_bodies(mechanism, bodies);
        }
    }

    /// Schedules a rebuild of the trees on a fixed body, by which they follow the body's new pose.
    pub fn schedule_rebuild(&mut self, body: BodyId) {
        for mechanism in self.mechanisms.iter_mut().filter(|m| m.root == body && m.bodies.first() != Some(&body)) {
            mechanism.built = None;
        }
    }
}

/// Stores the position, velocity and drive effort of each single-axis joint of a mechanism in `old`.
fn store_joint_states(mechanism: &Mechanism, old: &mut BTreeMap<JointId, [f64; 3]>) {
    for (link, (joint, place)) in mechanism.joints.iter().zip(&mechanism.places).enumerate() {
        if let (Some(id), 1) = (joint, place.axes) {
            let gear = mechanism.built.as_ref().and_then(|built| built.tree.gear(link));
            let (q, v) = (mechanism.q[place.position], mechanism.v[place.velocity]);
            // A joint whose gear is removed continues from where the gear had moved it.
            let [q, v] = gear.map_or([q, v], |(ratio, offset)| [ratio * q + offset, ratio * v]);
            old.insert(*id, [q, v, mechanism.carried[place.axis]]);
        }
    }
}

/// Returns the joints in `first` and all joints below them, parents before children.
fn joints_below(joints: &Joints, below: &BTreeMap<BodyId, Vec<JointId>>, first: &[JointId]) -> Vec<JointId> {
    let mut open: Vec<JointId> = first.iter().rev().copied().collect();
    let mut found = Vec::new();
    while let Some(joint) = open.pop() {
        found.push(joint);
        let child = joints.get(joint).map(|r| r.bodies.1);
        open.extend(child.and_then(|c| below.get(&c)).into_iter().flatten().rev());
    }
    found
}

/// Sets the coordinates of a mechanism: for known joints, those in `old`, and for all others, those of the bodies. The
/// order is that of `tatu_mechanisms`: coordinates of a joint that others follow come where the first of them is.
fn read_coordinates(mechanism: &mut Mechanism, bodies: &Bodies, joints: &Joints, old: &BTreeMap<JointId, [f64; 3]>) {
    let is_frozen = |b: &BodyId| bodies.body(*b).is_none_or(|body| !body.is_enabled());
    mechanism.frozen = mechanism.bodies.iter().any(is_frozen);
    let known = |joint: Option<JointId>| joint.and_then(|joint| old.get(&joint));
    // For each independent joint, the indices of its position and velocity, and its number of velocities.
    let mut starts: Vec<Option<[usize; 3]>> = vec![None; mechanism.joints.len()];
    for link in 0..mechanism.joints.len() {
        let leader = independent_link(&mechanism.gears, link);
        let [position, velocity, count] = starts[leader].unwrap_or_else(|| {
            let start = [mechanism.q.len(), mechanism.v.len()];
            let (q, v) = read_state(mechanism, leader, None, bodies, joints);
            let count = v.len();
            match known(mechanism.joints[leader]) {
                Some([q, v, _]) => {
                    mechanism.q.push(*q);
                    mechanism.v.push(*v);
                }
                None => {
                    mechanism.q.extend(q);
                    mechanism.v.extend(v);
                }
            }
            [start[0], start[1], count]
        });
        starts[leader] = Some([position, velocity, count]);
        mechanism.places.push(LinkPlace { position, velocity, axis: mechanism.carried.len(), axes: count });
        match known(mechanism.joints[link]) {
            Some([_, _, carried]) => mechanism.carried.push(*carried),
            None => mechanism.carried.extend((0..count).map(|_| 0.0)),
        }
    }
    read_gaps(mechanism, bodies, joints);
}
