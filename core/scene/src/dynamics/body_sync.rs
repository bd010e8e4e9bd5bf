//! Creation of the engine's bodies and joints from objects.
//!
//! The rule is V-REP's: a dynamic shape below a joint or force sensor that is itself below a shape is connected to that
//! shape, by the joint or rigidly. Any other dynamic shape is free, whatever its parent. A respondable static shape
//! collides; it is kinematic if an ancestor can move it.

use std::collections::{BTreeMap, BTreeSet};

use tatu_physics::{BodyDesc, BodyId, CollisionMask, JointDesc, JointForm, JointId, JointKind, PassiveForces, Twist};

use super::{
    follow,
    mass::{mass_props, materials, surface},
    state::{BodyRecord, Dynamics, JointRecord, WritebackList},
};
use crate::{
    body_rules::{motion_of, tie_of, top_shape},
    forms::{collision_parts, is_infinite},
    mechanisms,
    object::{JointType, ObjectVariant},
    tree::Scene,
};

impl Dynamics {
    /// Updates bodies and joints from the scene. Only those that have changed are recreated; the others are unaffected.
    pub fn update_bodies(&mut self, scene: &mut Scene) {
        scene.update_order();
        if self.built_version == scene.versions.shape {
            return;
        }
        self.built_version = scene.versions.shape;
        self.pose_writeback = WritebackList::default();
        self.couplings.followers = follow::followers(scene);
        self.couplings.geared = follow::geared(scene);
        let geared: BTreeSet<u32> = self.couplings.geared.iter().flat_map(|(a, b)| [*a, *b]).collect();
        self.engine.set_materials(&materials(scene));
        let twists: BTreeMap<u32, Twist> = self.bodies.iter().map(|b| (b.slot, self.engine.twist(b.id))).collect();
        let kept = |b: &BodyRecord| {
            scene.get(b.slot).is_some_and(|o| o.uid == b.uid && o.version == b.version)
                && motion_of(scene, b.slot) == Some(b.motion)
        };
        let mechanisms::MechanismSolvers { forms, unused } = mechanisms::choose_solvers(scene);
        let gone: Vec<_> = self.bodies.iter().filter(|b| !kept(b)).map(|b| (b.id, b.slot, b.uid)).collect();
        let dead: BTreeSet<BodyId> = gone.iter().map(|g| g.0).collect();
        let alive = |id: BodyId| !dead.contains(&id);
        let tied = |j: &JointRecord| {
            alive(j.bodies.0)
                && alive(j.bodies.1)
                && scene.get(j.tie).is_some_and(|o| o.version == j.version)
                && tie_of(scene, j.child).is_some_and(|(_, tie)| tie == j.tie)
                && forms.get(&j.child) == Some(&j.form)
                && geared.contains(&j.tie) == j.geared
        };
        let loose: Vec<_> = self.joints.iter().filter(|j| !tied(j)).map(|j| (j.id, j.tie)).collect();
        let cut: BTreeSet<JointId> = loose.iter().map(|j| j.0).collect();
        self.joints.retain(|j| !cut.contains(&j.id));
        for (id, tie) in &loose {
            self.engine.remove_joint(*id);
            clear_engine_ids(scene, *tie);
        }
        self.remove_stale_loops(scene, &alive);
        self.bodies.retain(|b| !dead.contains(&b.id));
        for (id, slot, uid) in gone {
            self.engine.remove_body(id);
            if scene.get(slot).is_some_and(|o| o.uid == uid) {
                clear_engine_ids(scene, slot);
            }
        }
        // Infinite forms are added last, because forms added after them unbalance the engine's tree of bounding boxes.
        let mut endless = Vec::new();
        scene.visit(|scene, slot| match scene.get(slot).and_then(|o| o.shape()).is_some_and(is_infinite) {
            true => endless.push(slot),
            false => self.add_body(scene, slot, &twists),
        });
        for slot in endless {
            self.add_body(scene, slot, &twists);
        }
        let tied: BTreeSet<u32> = self.joints.iter().map(|j| j.child).collect();
        scene.visit(|scene, slot| {
            if !tied.contains(&slot) {
                self.add_tie(scene, slot, forms.get(&slot).copied().unwrap_or_default(), &geared);
            }
        });
        loose.iter().for_each(|(_, tie)| clear_load(scene, *tie));
        self.close_loops(scene);
        self.list_kinematic();
        self.warn(scene, &unused);
    }

    fn add_body(&mut self, scene: &mut Scene, slot: u32, twists: &BTreeMap<u32, Twist>) {
        let Some(motion) = motion_of(scene, slot) else { return };
        let Some(o) = scene.get(slot) else { return };
        let Some(shape) = o.shape().filter(|s| s.body.0.is_none()) else { return };
        let start = Twist { linear: shape.initial_velocity, angular: shape.initial_angular_velocity };
        let twist = twists.get(&slot).copied().unwrap_or(start);
        let desc = BodyDesc {
            pose: scene.world(slot),
            motion,
            mass: mass_props(shape),
            linear_velocity: twist.linear,
            angular_velocity: twist.angular,
            parts: if shape.respondable { collision_parts(shape) } else { Vec::new() },
            friction: shape.friction,
            restitution: shape.restitution,
            bullet: shape.bullet,
            // A moving body that is created again keeps moving.
            asleep: shape.asleep && twist == Twist::default(),
            damping: shape.damping,
            surface: surface(scene, shape),
            collision_mask: CollisionMask {
                mask: if shape.respondable { shape.mask } else { 0 },
                tree: top_shape(scene, slot),
            },
        };
        let id = self.engine.add_body(&desc);
        let start = desc.pose.translation.vector;
        self.bodies.push(BodyRecord { id, slot, uid: o.uid, version: o.version, motion, start, stray: false });
        if let Some(ObjectVariant::Shape(s)) = scene.get_mut(slot).map(|o| &mut o.data) {
            s.body.0 = Some(id);
        }
    }

    fn add_tie(&mut self, scene: &mut Scene, slot: u32, form: JointForm, geared: &BTreeSet<u32>) {
        let Some((above, tie)) = tie_of(scene, slot) else { return };
        let body = |s: u32| scene.get(s).and_then(|o| o.shape()).and_then(|s| s.body.0);
        let (Some(a), Some(b), Some(joint)) = (body(above), body(slot), scene.get(tie)) else { return };
        let (kind, limits, passive) = match &joint.data {
            ObjectVariant::Joint(j) => {
                let kind = match j.kind {
                    JointType::Revolute if j.lead != 0.0 => JointKind::Screw(j.lead_per_radian()),
                    JointType::Revolute => JointKind::Revolute,
                    JointType::Prismatic => JointKind::Prismatic,
                    JointType::Spherical => JointKind::Spherical,
                };
                (kind, j.limits, j.passive)
            }
            _ => (JointKind::Fixed, None, PassiveForces::default()),
        };
        let desc = JointDesc {
            a,
            b,
            frame_in_a: scene.world(above).inverse() * scene.world(tie),
            // The child is attached to the joint's moving frame, which equals the joint's own frame at position 0.
            frame_in_b: scene.world(slot).inverse() * scene.frame(tie),
            kind,
            limits,
            position: joint.joint().map_or(0.0, |j| j.position),
            form,
            passive,
            geared: geared.contains(&tie),
        };
        let sensor = matches!(joint.data, ObjectVariant::ForceSensor(_));
        let Some(id) = self.engine.add_joint(&desc) else { return };
        self.joints.push(JointRecord {
            id,
            tie,
            child: slot,
            version: joint.version,
            bodies: (a, b),
            frame_in_a: desc.frame_in_a,
            form,
            geared: desc.geared,
            sensor,
        });
        match scene.get_mut(tie).map(|o| &mut o.data) {
            Some(ObjectVariant::Joint(j)) => {
                j.id = Some(id);
                self.drives.push(tie);
            }
            Some(ObjectVariant::ForceSensor(f)) => {
                f.id = Some(id);
                self.engine.measure(id);
            }
            _ => {}
        }
    }
}

/// Clears the state of a joint or force sensor that no longer connects two bodies, and therefore carries no load.
fn clear_load(scene: &mut Scene, slot: u32) {
    match scene.get_mut(slot).map(|o| &mut o.data) {
        Some(ObjectVariant::Joint(j)) if j.id.is_none() => (j.velocity, j.effort) = (0.0, 0.0),
        Some(ObjectVariant::ForceSensor(f)) if f.id.is_none() => f.clear_measurement(),
        _ => {}
    }
}

fn clear_engine_ids(scene: &mut Scene, slot: u32) {
    match scene.get_mut(slot).map(|o| &mut o.data) {
        Some(ObjectVariant::Shape(s)) => s.body.0 = None,
        Some(ObjectVariant::Joint(j)) => (j.id, j.course, j.callback_called) = (None, None, false),
        Some(ObjectVariant::ForceSensor(f)) => f.id = None,
        _ => {}
    }
}
