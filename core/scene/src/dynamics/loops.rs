//! Loops closed by linked dummies: the shapes above two linked dummies are held together so that the dummies coincide
//! in position and orientation. A dummy without a body above it belongs to the world, which an anchor represents: a
//! body without colliders at the pose of the dummy.

use nalgebra::{Isometry3, Matrix3, Point3};
use tatu_physics::{
    BodyDesc, BodyId, CollisionMask, ContactSurface, JointDesc, JointForm, JointKind, MassProps, MotionType,
    PassiveForces,
};

use super::state::{Dynamics, LoopRecord};
use crate::{
    body_rules::{is_carried, motion_of, top_shape},
    object::ObjectVariant,
    tree::Scene,
};

/// Returns each pair of linked dummies once, in ascending order of slots.
pub(crate) fn links(scene: &Scene) -> Vec<(u32, u32)> {
    let mut pairs: Vec<(u32, u32)> = scene
        .slots()
        .filter_map(|(slot, o)| {
            let ObjectVariant::Dummy(Some(link)) = &o.data else { return None };
            let other = scene.find(slot, link)?;
            let is_dummy = matches!(scene.get(other)?.data, ObjectVariant::Dummy(_));
            (is_dummy && other != slot).then_some((slot.min(other), slot.max(other)))
        })
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// Returns the nearest shape above an object that has a body, or 0 for the world.
fn carrier(scene: &Scene, slot: u32) -> u32 {
    let mut at = scene.get(slot).map_or(0, |o| o.parent);
    while let Some(o) = scene.get(at) {
        if motion_of(scene, at).is_some() {
            return at;
        }
        at = o.parent;
    }
    0
}

impl Scene {
    /// Returns the path of each dummy that is linked to an object that does not exist or is not another dummy, with the
    /// path that it specifies.
    pub fn dangling_links(&self) -> Vec<(String, String)> {
        let lost = self.slots().filter_map(|(slot, o)| {
            let ObjectVariant::Dummy(Some(link)) = &o.data else { return None };
            let found = self.find(slot, link).filter(|s| *s != slot).and_then(|s| self.get(s));
            let there = found.is_some_and(|o| matches!(o.data, ObjectVariant::Dummy(_)));
            (!there).then(|| (self.path(slot), link.to_string()))
        });
        lost.collect()
    }
}

impl Dynamics {
    /// Removes the engine's joints for loops whose dummies have changed or whose bodies no longer exist.
    pub(super) fn remove_stale_loops(&mut self, scene: &Scene, alive: &dyn Fn(BodyId) -> bool) {
        let pairs = links(scene);
        let version = |slot| scene.get(slot).map_or(0, |o| o.version);
        let engine = &mut self.engine;
        self.couplings.loops.retain(|l| {
            let kept = alive(l.bodies.0)
                && alive(l.bodies.1)
                && pairs.contains(&l.dummies)
                && l.versions == (version(l.dummies.0), version(l.dummies.1))
                && l.carriers == (carrier(scene, l.dummies.0), carrier(scene, l.dummies.1));
            if !kept {
                engine.remove_joint(l.id);
                for (body, _) in l.anchors() {
                    engine.remove_body(body);
                }
            }
            kept
        });
    }

    /// Adds joints to the engine for all loops that have none yet.
    pub(super) fn close_loops(&mut self, scene: &Scene) {
        for (one, other) in links(scene) {
            let carriers = (carrier(scene, one), carrier(scene, other));
            if self.couplings.loops.iter().any(|l| l.dummies == (one, other)) || carriers == (0, 0) {
                continue;
            }
            let (Some((a, frame_in_a)), Some((b, frame_in_b))) =
                (self.body_or_anchor(scene, one, carriers.0), self.body_or_anchor(scene, other, carriers.1))
            else {
                continue;
            };
            let desc = JointDesc {
                a,
                b,
                frame_in_a,
                frame_in_b,
                kind: JointKind::Fixed,
                limits: None,
                position: 0.0,
                form: JointForm::Loop,
                passive: PassiveForces::default(),
                geared: false,
            };
            let versions = [one, other].map(|slot| scene.get(slot).map_or(0, |o| o.version));
            if let Some(id) = self.engine.add_joint(&desc) {
                let (versions, dummies) = ((versions[0], versions[1]), (one, other));
                self.couplings.loops.push(LoopRecord { id, dummies, versions, bodies: (a, b), carriers });
            }
        }
    }

    /// Returns the body of the shape `carrier` above a dummy, or an anchor if it is 0, with the pose of the dummy in
    /// the frame of this body.
    fn body_or_anchor(&mut self, scene: &Scene, dummy: u32, carrier: u32) -> Option<(BodyId, Isometry3<f64>)> {
        if carrier != 0 {
            let body = scene.get(carrier)?.shape()?.body.0?;
            return Some((body, scene.world(carrier).inverse() * scene.world(dummy)));
        }
        let anchor = BodyDesc {
            pose: scene.world(dummy),
            motion: if is_carried(scene, dummy) { MotionType::Kinematic } else { MotionType::Static },
            mass: MassProps { mass: 0.0, com: Point3::origin(), inertia: Matrix3::zeros() },
            linear_velocity: Default::default(),
            angular_velocity: Default::default(),
            parts: Vec::new(),
            friction: 0.0,
            restitution: 0.0,
            bullet: false,
            asleep: false,
            damping: [0.0; 2],
            surface: ContactSurface::default(),
            collision_mask: CollisionMask { mask: 0, tree: top_shape(scene, dummy) },
        };
        Some((self.engine.add_body(&anchor), Isometry3::identity()))
    }

    /// Moves the anchors of dummies that were moved by scripts, or that a joint carries.
    pub(super) fn move_anchors(&mut self, scene: &Scene) {
        for l in &self.couplings.loops {
            for (body, dummy) in l.anchors() {
                let pose = scene.world(dummy);
                if is_carried(scene, dummy) || self.engine.pose(body) != pose {
                    self.engine.set_pose(body, &pose);
                }
            }
        }
    }
}

impl LoopRecord {
    /// Returns the anchors of the loop, with the dummies that they represent.
    fn anchors(&self) -> impl Iterator<Item = (BodyId, u32)> {
        let ends = [(self.carriers.0, self.bodies.0, self.dummies.0), (self.carriers.1, self.bodies.1, self.dummies.1)];
        ends.into_iter().filter(|(carrier, _, _)| *carrier == 0).map(|(_, body, dummy)| (body, dummy))
    }
}
