//! Construction of trees from joints: the joints of each mechanism, the description of its links, and their state.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use rapier3d::dynamics::RigidBody;
use tatu_geometry::wrap_angle;
use tatu_mechanisms::{
    ContactSide, Island, Joint, JointSpring, Kinematics, Link, Tree, TreeDrives, TreeSolver, TreeState,
};

use super::records::{Mechanism, MechanismSolver};
use crate::{
    BodyId, JointDesc, JointId, JointKind, MotionType, convert,
    rapier::{
        records::{JointBackend, JointRecord},
        state::Rapier,
    },
};

impl Rapier {
    /// Rebuilds the mechanisms if joints were added or removed, or bodies were adopted or released. Joints that existed
    /// before keep their positions and velocities; those of new joints are computed from the bodies.
    pub(in crate::rapier) fn arrange_trees(&mut self) {
        if std::mem::take(&mut self.state.mechanisms_changed) {
            let mut old = BTreeMap::new();
            for mechanism in std::mem::take(&mut self.state.mechanisms) {
                Self::store_joint_states(&mechanism, &mut old);
            }
            for (root, joints) in self.mechanism_joints() {
                let mechanism = self.new_mechanism(root, joints, &old);
                self.state.mechanisms.push(mechanism);
            }
        }
        self.freeze_disabled_mechanisms();
        let mut anew = false;
        for i in 0..self.state.mechanisms.len() {
            if self.state.mechanisms[i].built.is_none() && !self.state.mechanisms[i].frozen {
                anew = true;
                let built = self.build(&self.state.mechanisms[i]).map(Box::new);
                match built {
                    Some(built) => {
                        self.state.mechanisms[i].built = Some(built);
                        // The poses of bodies that were placed from outside must be read before they are overwritten.
                        let mechanism = &self.state.mechanisms[i];
                        if !mechanism.bodies.iter().any(|b| self.state.moved.contains(b)) {
                            self.place_bodies(i);
                        }
                    }
                    None => self.freeze_mechanism(i),
                }
            }
        }
        if anew {
            self.state.links = self.list_links();
        }
        self.update_moved_mechanisms();
    }

    /// Returns, for each body of a mechanism, its mechanism and link.
    fn list_links(&self) -> BTreeMap<BodyId, ContactSide> {
        let mechanisms = self.state.mechanisms.iter().enumerate().filter(|(_, m)| !m.frozen);
        mechanisms
            .flat_map(|(member, m)| {
                m.bodies.iter().enumerate().map(move |(link, b)| (*b, ContactSide { member, link }))
            })
            .collect()
    }

    /// Returns whether a joint can be part of a tree: its child body is dynamic and has no other parent, and the joint
    /// does not close a loop.
    pub(in crate::rapier) fn may_join_tree(&self, desc: &JointDesc) -> bool {
        let above = |body: BodyId| {
            let joints = self.state.joints.iter().flatten();
            joints.filter(|r| r.tree_joint().is_some()).find(|r| r.bodies.1 == body).map(|r| r.bodies.0)
        };
        let mut at = Some(desc.a);
        while let Some(body) = at.filter(|b| *b != desc.b) {
            at = above(body);
        }
        self.is_moved(desc.b) && above(desc.b).is_none() && at.is_none()
    }

    /// Freezes mechanisms that contain a frozen body.
    fn freeze_disabled_mechanisms(&mut self) {
        for i in 0..self.state.mechanisms.len() {
            let mechanism = &self.state.mechanisms[i];
            let mut bodies = mechanism.bodies.iter().filter_map(|b| self.body(*b));
            if !mechanism.frozen && bodies.any(|b| !b.is_enabled()) {
                self.freeze_mechanism(i);
            }
        }
    }

    /// Freezes all bodies of a mechanism; [`Engine::quarantined`](crate::Engine::quarantined) reports them.
    pub(super) fn freeze_mechanism(&mut self, index: usize) {
        (self.state.mechanisms[index].frozen, self.state.mechanisms[index].built) = (true, None);
        for body in self.state.mechanisms[index].bodies.clone() {
            self.freeze(body);
        }
        self.state.links = self.list_links();
    }

    /// Stores the position, velocity and drive effort of each single-axis joint of a mechanism in `old`.
    fn store_joint_states(mechanism: &Mechanism, old: &mut BTreeMap<JointId, [f64; 3]>) {
        for (joint, (q, v, count)) in mechanism.joints.iter().zip(&mechanism.offsets) {
            if let (Some(id), 1) = (joint, *count) {
                old.insert(*id, [mechanism.q[*q], mechanism.v[*v], mechanism.carried[*v]]);
            }
        }
    }

    /// Returns the root of each mechanism and its joints, parents before children. Each joint on a body that is not
    /// dynamic starts a separate mechanism.
    fn mechanism_joints(&self) -> Vec<(BodyId, Vec<JointId>)> {
        let mut below: BTreeMap<BodyId, Vec<JointId>> = BTreeMap::new();
        let mut children = BTreeSet::new();
        for (id, record) in (0..).map(JointId).zip(&self.state.joints) {
            if let Some(record) = record.as_ref().filter(|r| matches!(r.held, JointBackend::Tree(_))) {
                below.entry(record.bodies.0).or_default().push(id);
                children.insert(record.bodies.1);
            }
        }
        let mut found = Vec::new();
        for (root, joints) in below.iter().filter(|(body, _)| !children.contains(body)) {
            if self.is_moved(*root) {
                found.push((*root, self.joints_below(&below, joints)));
            } else {
                found.extend(joints.iter().map(|joint| (*root, self.joints_below(&below, &[*joint]))));
            }
        }
        found.extend(self.state.adopted.keys().map(|body| (*body, Vec::new())));
        found
    }

    /// Returns the joints in `first` and all joints below them, parents before children.
    fn joints_below(&self, below: &BTreeMap<BodyId, Vec<JointId>>, first: &[JointId]) -> Vec<JointId> {
        let mut open: Vec<JointId> = first.iter().rev().copied().collect();
        let mut found = Vec::new();
        while let Some(joint) = open.pop() {
            found.push(joint);
            let child = self.joint(joint).map(|r| r.bodies.1);
            open.extend(child.and_then(|c| below.get(&c)).into_iter().flatten().rev());
        }
        found
    }

    pub(super) fn joint(&self, joint: JointId) -> Option<&JointRecord> {
        self.state.joints.get(joint.0 as usize)?.as_ref()
    }

    fn is_moved(&self, body: BodyId) -> bool {
        self.record(body).is_some_and(|r| r.motion == MotionType::Dynamic)
    }

    /// Returns a mechanism whose state is that of `old` for known joints, and that of the bodies for all others.
    fn new_mechanism(&self, root: BodyId, joints: Vec<JointId>, old: &BTreeMap<JointId, [f64; 3]>) -> Mechanism {
        let (mut links, mut bodies) = (Vec::new(), Vec::new());
        if self.is_moved(root) {
            (links, bodies) = (vec![None], vec![root]);
        }
        for joint in joints {
            links.push(Some(joint));
            bodies.extend(self.joint(joint).map(|r| r.bodies.1));
        }
        let frozen = bodies.iter().any(|b| self.record(*b).is_none_or(|r| !self.world.bodies[r.handle].is_enabled()));
        let mut mechanism = Mechanism { joints: links, bodies, frozen, ..Mechanism::new(root) };
        for link in 0..mechanism.joints.len() {
            let (q, v) = self.read_state(&mechanism, link, None);
            mechanism.offsets.push((mechanism.q.len(), mechanism.v.len(), v.len()));
            let known = mechanism.joints[link].and_then(|joint| old.get(&joint));
            match known {
                Some([q, v, carried]) => {
                    mechanism.q.push(*q);
                    mechanism.v.push(*v);
                    mechanism.carried.push(*carried);
                }
                None => {
                    mechanism.carried.extend(v.iter().map(|_| 0.0));
                    mechanism.q.extend(q);
                    mechanism.v.extend(v);
                }
            }
        }
        mechanism
    }

    /// Computes the positions and velocities of a link from the poses and velocities of its bodies. The position of a
    /// revolute joint is the one within half a turn of `near`.
    fn read_state(&self, mechanism: &Mechanism, link: usize, near: Option<f64>) -> (Vec<f64>, Vec<f64>) {
        let Some(record) = mechanism.joints[link].and_then(|j| self.joint(j)) else {
            let Some(body) = self.body(mechanism.bodies[link]) else { return (vec![0.0; 7], vec![0.0; 6]) };
            let pose = convert::pose_back(body.position());
            let (p, r) = (pose.translation.vector, pose.rotation);
            let spin = r.inverse() * convert::vector_back(body.angvel());
            let speed = convert::vector_back(body.linvel());
            return (vec![p.x, p.y, p.z, r.w, r.i, r.j, r.k], vec![speed.x, speed.y, speed.z, spin.x, spin.y, spin.z]);
        };
        let (frame_a, frame_b) = self.joint_frames(record);
        let (frame_a, frame_b) = (convert::pose_back(&frame_a), convert::pose_back(&frame_b));
        let at = convert::vector(&frame_b.translation.vector);
        let [a, b] = [record.bodies.0, record.bodies.1].map(|id| self.velocity(id));
        let turn = convert::vector_back(b.angular - a.angular);
        let axis = frame_a.rotation * Vector3::z();
        match record.kind {
            JointKind::Fixed => (Vec::new(), Vec::new()),
            JointKind::Spherical => {
                let r = frame_a.rotation.inverse() * frame_b.rotation;
                let spin = frame_b.rotation.inverse() * turn;
                (vec![r.w, r.i, r.j, r.k], vec![spin.x, spin.y, spin.z])
            }
            JointKind::Prismatic => {
                let slide = convert::vector_back(b.at(at) - a.at(at));
                (vec![(frame_b.translation.vector - frame_a.translation.vector).dot(&axis)], vec![slide.dot(&axis)])
            }
            JointKind::Revolute | JointKind::Screw(_) => {
                let (a, b) = self.joint_frames(record);
                let position = record.position(&a, &b);
                let position = near.map_or(position, |near| near + wrap_angle(position - near));
                (vec![position], vec![turn.dot(&axis)])
            }
        }
    }

    pub(super) fn body(&self, body: BodyId) -> Option<&RigidBody> {
        self.world.bodies.get(self.record(body)?.handle)
    }

    /// Updates mechanisms with bodies whose pose or velocity was set from outside: joint states are computed from the
    /// bodies, and the bodies are then moved onto the links.
    fn update_moved_mechanisms(&mut self) {
        if self.state.moved.is_empty() {
            return;
        }
        for i in 0..self.state.mechanisms.len() {
            let mechanism = &self.state.mechanisms[i];
            if !mechanism.bodies.iter().any(|b| self.state.moved.contains(b)) {
                continue;
            }
            let (mut q, mut v) = (Vec::new(), Vec::new());
            for link in 0..mechanism.joints.len() {
                let near = mechanism.q.get(mechanism.offsets[link].0).copied();
                let (positions, velocities) = self.read_state(mechanism, link, near);
                q.extend(positions);
                v.extend(velocities);
            }
            let mechanism = &mut self.state.mechanisms[i];
            (mechanism.q, mechanism.v) = (q, v);
            self.place_bodies(i);
        }
    }

    /// Schedules a rebuild of the trees on a fixed body, by which they follow the body's new pose.
    pub(in crate::rapier) fn schedule_rebuild(&mut self, body: BodyId) {
        for mechanism in self.state.mechanisms.iter_mut().filter(|m| m.root == body && m.bodies.first() != Some(&body))
        {
            mechanism.built = None;
        }
    }

    /// Builds the tree of a mechanism, or returns `None` if its description is not a valid tree.
    fn build(&self, mechanism: &Mechanism) -> Option<MechanismSolver> {
        let (mut links, mut to_body) = (Vec::new(), Vec::<Isometry3<f64>>::new());
        for (joint, body) in mechanism.joints.iter().zip(&mechanism.bodies) {
            let (parent, frame, kind, own, passive, limits) = match joint.and_then(|j| self.joint(j)) {
                None => (None, Isometry3::identity(), Joint::Free, Isometry3::identity(), Default::default(), None),
                Some(record) => {
                    let parent = mechanism.bodies.iter().position(|b| *b == record.bodies.0);
                    // Positions in a tree are measured from the joint's own zero; rapier's frame is rotated by `zero`.
                    let back = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -record.zero);
                    let carrier = match parent {
                        Some(parent) => *to_body.get(parent)?,
                        None => convert::pose_back(self.body(record.bodies.0)?.position()),
                    };
                    let frame = carrier * convert::pose_back(&record.frames.0) * back;
                    let kind = match record.kind {
                        JointKind::Revolute => Joint::Revolute(Vector3::z()),
                        JointKind::Prismatic => Joint::Prismatic(Vector3::z()),
                        JointKind::Spherical => Joint::Spherical,
                        JointKind::Fixed | JointKind::Screw(_) => Joint::Fixed,
                    };
                    let own = convert::pose_back(&record.frames.1).inverse();
                    (parent, frame, kind, own, record.passive, record.limits)
                }
            };
            let (mass, inertia) = mass_of(self.body(*body)?);
            let turned = own.rotation.to_rotation_matrix();
            let inertia = turned.matrix() * inertia * turned.matrix().transpose();
            let mut link = Link::new(parent, frame, kind, mass, own.translation.vector, inertia);
            if kind.velocities() > 0 && joint.is_some() {
                (link.armature, link.damping) = (passive.armature.max(0.0), passive.damping.max(0.0));
                link.friction = passive.friction.max(0.0);
            }
            if kind.positions() == 1 {
                link.limits = limits.map(|(low, high)| [low, high]);
            }
            links.push(link);
            to_body.push(own);
        }
        let tree = Tree::with_any_inertia(links).ok()?;
        // As in reduced form, only a free body that is a tree on its own has linear and angular damping.
        let alone = mechanism.joints == [None];
        let body = mechanism.bodies.first().filter(|_| alone).and_then(|b| self.body(*b));
        let damping = body.map_or([0.0; 2], |b| [b.linear_damping(), b.angular_damping()]);
        let state = TreeState { q: mechanism.q.clone(), v: mechanism.v.clone() };
        Some(MechanismSolver {
            solver: TreeSolver::new(&tree),
            kinematics: Kinematics::new(&tree),
            drives: TreeDrives::new(&tree),
            efforts: vec![0.0; tree.velocities()],
            work: 0.0,
            damping,
            tree,
            state,
            poses: vec![Isometry3::identity(); to_body.len()],
            origins: vec![Vector3::zeros(); to_body.len()],
            to_body,
            island: Island::new(),
        })
    }

    /// Sets the drives and springs of a mechanism's joints, which can change between steps.
    pub(super) fn set_tree_drives(&mut self, index: usize) {
        let Some(mut built) = self.state.mechanisms[index].built.take() else { return };
        for (link, joint) in self.state.mechanisms[index].joints.iter().enumerate() {
            let (_, v, count) = self.state.mechanisms[index].offsets[link];
            if let (Some(record), 1) = (joint.and_then(|j| self.joint(j)), count) {
                built.drives.drive[v] = super::drives::tree_drive(record);
                let stiffness = record.passive.stiffness.max(0.0);
                built.drives.spring[v] = JointSpring { rest: record.passive.rest, stiffness, damping: 0.0 };
            }
        }
        self.state.mechanisms[index].built = Some(built);
    }
}

/// Returns the mass of a body, kg, and its inertia about the centre of mass in the body's axes, kg m^2.
fn mass_of(body: &RigidBody) -> (f64, Matrix3<f64>) {
    let mass = &body.mass_properties().local_mprops;
    let moments = convert::vector_back(mass.principal_inertia());
    let axes = convert::rotation_back(&mass.principal_inertia_local_frame).to_rotation_matrix();
    (mass.mass(), axes.matrix() * Matrix3::from_diagonal(&moments) * axes.matrix().transpose())
}
