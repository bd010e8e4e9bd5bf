//! Loops closed by linked dummies: the shapes above two linked dummies are held together so that the dummies coincide
//! in position and orientation.

use nalgebra::Isometry3;
use tatu_physics::{BodyId, JointDesc, JointForm, JointKind, Passive};

use super::state::{Dynamics, LoopRecord};
use crate::{object::Data, tree::Scene};

/// Returns each pair of linked dummies once, in ascending order of slots.
pub(crate) fn links(scene: &Scene) -> Vec<(u32, u32)> {
    let mut pairs: Vec<(u32, u32)> = scene
        .slots()
        .filter_map(|(slot, o)| {
            let Data::Dummy(Some(link)) = &o.data else { return None };
            let other = scene.find(slot, link)?;
            let is_dummy = matches!(scene.get(other)?.data, Data::Dummy(_));
            (is_dummy && other != slot).then_some((slot.min(other), slot.max(other)))
        })
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// Returns the body of the nearest shape above an object, and the object's pose in the frame of that shape.
fn carrier(scene: &Scene, slot: u32) -> Option<(BodyId, Isometry3<f64>)> {
    let mut at = scene.get(slot)?.parent;
    while let Some(o) = scene.get(at) {
        if let Some(body) = o.shape().and_then(|s| s.body.0) {
            return Some((body, scene.world(at).inverse() * scene.world(slot)));
        }
        at = o.parent;
    }
    None
}

impl Scene {
    /// Returns the path of each dummy that is linked to an object that does not exist or is not another dummy, with the
    /// path that it specifies.
    pub fn lost_links(&self) -> Vec<(String, String)> {
        let lost = self.slots().filter_map(|(slot, o)| {
            let Data::Dummy(Some(link)) = &o.data else { return None };
            let found = self.find(slot, link).filter(|s| *s != slot).and_then(|s| self.get(s));
            let there = found.is_some_and(|o| matches!(o.data, Data::Dummy(_)));
            (!there).then(|| (self.path(slot), link.to_string()))
        });
        lost.collect()
    }
}

impl Dynamics {
    /// Removes the engine's joints for loops whose dummies have changed or whose bodies no longer exist.
    pub(super) fn loosen_loops(&mut self, scene: &Scene, alive: &dyn Fn(BodyId) -> bool) {
        let pairs = links(scene);
        let version = |slot| scene.get(slot).map_or(0, |o| o.version);
        let engine = &mut self.engine;
        self.loops.retain(|l| {
            let kept = alive(l.bodies.0)
                && alive(l.bodies.1)
                && pairs.contains(&l.dummies)
                && l.versions == (version(l.dummies.0), version(l.dummies.1));
            if !kept {
                engine.remove_joint(l.id);
            }
            kept
        });
    }

    /// Adds joints to the engine for all loops that have none yet.
    pub(super) fn close_loops(&mut self, scene: &Scene) {
        for (one, other) in links(scene) {
            if self.loops.iter().any(|l| l.dummies == (one, other)) {
                continue;
            }
            let (Some((a, frame_in_a)), Some((b, frame_in_b))) = (carrier(scene, one), carrier(scene, other)) else {
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
                passive: Passive::default(),
                geared: false,
            };
            let versions = [one, other].map(|slot| scene.get(slot).map_or(0, |o| o.version));
            if let Some(id) = self.engine.add_joint(&desc) {
                let (versions, dummies) = ((versions[0], versions[1]), (one, other));
                self.loops.push(LoopRecord { id, dummies, versions, bodies: (a, b) });
            }
        }
    }
}
