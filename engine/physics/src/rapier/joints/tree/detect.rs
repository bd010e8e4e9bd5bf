//! Collision detection for scenes in which only trees move.
//!
//! For links, rapier's pipeline does more than find contacts: it sorts links into islands, prepares its solver, and
//! integrates positions that are then replaced. For a standing robot, this takes longer than the robot's own dynamics.
//! If no other body moves, and contacts need none of rapier's constraints or hooks, rapier is therefore not called, and
//! contacts are found here: the boxes of all colliders are swept along one axis, and each pair is tested by `faces`.
//! When rapier is next called, it processes all changes since its previous call.
//!
//! A collider that has not changed keeps its box, and if none has changed, all contacts are those of the last step: see
//! [`Detection::repeats`].
//!
//! Whether this is possible depends only on the state, so a run restored from a snapshot continues like the original.

use rapier3d::{
    dynamics::{CoefficientCombineRule, RigidBody},
    geometry::{BoundingVolume, ContactData, ContactManifold},
    math::Vector,
    parry::query::TrackedContact,
};

use super::{
    placed::{Detection, PlacedCollider},
    records::{DetectedFace, FacePoint, PairNormal, collider_index},
    table::TreeJoints,
};
use crate::{
    BodyId, MotionType, convert,
    rapier::{
        bodies::Bodies,
        contacts::{
            Contacts, MAX_FRICTION, faces,
            masks::{self, ColliderTag},
        },
    },
};

/// Maximum number of colliders of bodies that do not move. They are swept again in each step, which takes longer than
/// rapier's tree of boxes if there are many.
const MAX_STILL_COLLIDERS: usize = 256;

impl TreeJoints {
    /// Finds the contacts of this step if only trees move; returns false if rapier must do so.
    pub fn detect_alone(&mut self, bodies: &Bodies, contacts: &Contacts) -> bool {
        let before = self.detection.take().unwrap_or_default();
        let Some(placed) = self.placed_colliders(bodies, contacts, &before.placed) else {
            self.last_normals.clear();
            return false;
        };
        let same = before.repeats(&placed);
        if same && before.is_stable {
            self.detection = Some(before);
            return true;
        }
        let last = std::mem::take(&mut self.last_normals);
        let faces = detect(&placed, &last, &mut self.last_normals);
        let is_stable = same && last == self.last_normals;
        self.detection = Some(Detection { placed, faces, is_stable });
        true
    }

    /// Returns all colliders, or `None` if rapier must find their contacts. `before` are those of the last step.
    fn placed_colliders(
        &self,
        bodies: &Bodies,
        contacts: &Contacts,
        before: &[PlacedCollider],
    ) -> Option<Vec<PlacedCollider>> {
        let special = !contacts.pairs.is_empty() || !contacts.surfaces.is_empty() || !contacts.separations.is_empty();
        // Adopted bodies are released when rapier's narrow phase finds that nothing touches them.
        let needs_rapier = !self.adopted.is_empty() || !self.crowded.is_empty() || bodies.backlog.removed;
        if self.mechanisms.is_empty() || needs_rapier || special || !bodies.moving.is_empty() {
            return None;
        }
        let prediction = bodies.world.integration_parameters.prediction_distance();
        let (mut placed, mut still) = (Vec::with_capacity(before.len()), 0);
        for (id, record) in (0..).map(BodyId).zip(&bodies.records) {
            let Some(record) = record else { continue };
            let body = bodies.world.bodies.get(record.handle)?;
            let is_link = self.links.contains_key(&id);
            // Only rapier removes the contacts of a body that was frozen.
            if !is_link && !is_still(record.motion, body) {
                return None;
            }
            if !body.is_enabled() {
                continue;
            }
            for handle in body.colliders() {
                let collider = bodies.world.colliders.get(*handle)?;
                // Rapier's hook corrects the restitution for the time at which the bodies touch.
                if !collider.is_enabled() || collider.restitution() > 0.0 {
                    return None;
                }
                still += usize::from(!is_link);
                let pose = collider.position_wrt_parent().map_or(*body.position(), |own| body.position() * own);
                let ahead = prediction + body.soft_ccd_prediction();
                let known = before.get(placed.len()).filter(|b| b.is_still(*handle, collider, &pose, ahead));
                placed.push(PlacedCollider {
                    handle: *handle,
                    index: collider_index(*handle),
                    tag: ColliderTag::unpack(collider.user_data),
                    shape: collider.shared_shape().clone(),
                    pose,
                    friction: collider.friction(),
                    friction_rule: collider.friction_combine_rule(),
                    ahead,
                    is_link,
                    bounds: known.map_or_else(|| collider.shape().compute_aabb(&pose).loosened(ahead), |b| b.bounds),
                });
            }
        }
        (still <= MAX_STILL_COLLIDERS).then_some(placed)
    }
}

/// Returns whether a body that is not a link does not move.
fn is_still(motion: MotionType, body: &RigidBody) -> bool {
    motion != MotionType::Dynamic && body.linvel() == Vector::ZERO && body.angvel() == Vector::ZERO
}

/// Returns the axis along which the links are spread farthest.
fn sweep_axis(placed: &[PlacedCollider]) -> usize {
    let links = || placed.iter().filter(|p| p.is_link);
    let low = links().fold(Vector::INFINITY, |low, p| low.min(p.bounds.mins));
    let high = links().fold(Vector::NEG_INFINITY, |high, p| high.max(p.bounds.maxs));
    let spread = high - low;
    (1..3).fold(0, |widest, axis| if spread[axis] > spread[widest] { axis } else { widest })
}

/// Finds the faces of all pairs of which at least one is a link, sorted by colliders. Forms that touch exactly keep the
/// normal that they had in the previous step, `last`; `normals` receives those of this step.
fn detect(placed: &[PlacedCollider], last: &[PairNormal], normals: &mut Vec<PairNormal>) -> Vec<DetectedFace> {
    let axis = sweep_axis(placed);
    let low = |p: &PlacedCollider| p.bounds.mins[axis];
    let mut order: Vec<&PlacedCollider> = placed.iter().collect();
    order.sort_unstable_by(|a, b| low(a).total_cmp(&low(b)).then(a.index.cmp(&b.index)));
    let mut pairs = Vec::new();
    for (i, a) in order.iter().enumerate() {
        let near = order[i + 1..].iter().take_while(|b| low(b) <= a.bounds.maxs[axis]);
        let touching = near.filter(|b| may_touch(a, b));
        pairs.extend(touching.map(|b| if a.index < b.index { [*a, *b] } else { [*b, *a] }));
    }
    pairs.sort_unstable_by_key(|pair| pair.map(|p| p.index));
    let (mut found, mut manifolds) = (Vec::new(), Vec::new());
    for [a, b] in pairs {
        let pair = [a.index, b.index];
        let (pos12, guess) = (a.pose.inv_mul(&b.pose), last_normal(last, pair));
        faces::find(&pos12, [&*a.shape, &*b.shape], a.ahead.max(b.ahead), guess, &mut manifolds);
        normals.extend(manifolds.first().map(|m| PairNormal { pair, normal: m.local_n1 }));
        let touching = manifolds.iter().filter(|m| !m.points.is_empty());
        found.extend(touching.map(|m| detected_face(a, b, m)));
    }
    found
}

/// Returns the normal of a pair of colliders in the previous step.
fn last_normal(last: &[PairNormal], pair: [u32; 2]) -> Option<Vector> {
    let known = last.binary_search_by_key(&pair, |known| known.pair).ok()?;
    Some(last[known].normal)
}

fn may_touch(a: &PlacedCollider, b: &PlacedCollider) -> bool {
    (a.is_link || b.is_link)
        && a.tag.body != b.tag.body
        && masks::masks_collide(a.tag.collision_mask, b.tag.collision_mask)
        && a.bounds.intersects(&b.bounds)
}

fn detected_face(a: &PlacedCollider, b: &PlacedCollider, manifold: &ContactManifold) -> DetectedFace {
    let poses = [
        manifold.subshape_pos1().map_or(a.pose, |part| a.pose * part),
        manifold.subshape_pos2().map_or(b.pose, |part| b.pose * part),
    ];
    let normal = convert::vector_back(poses[0].rotation * manifold.local_n1);
    let friction = CoefficientCombineRule::combine(a.friction, b.friction, a.friction_rule, b.friction_rule);
    let friction = friction.min(MAX_FRICTION);
    let point = |p: &TrackedContact<ContactData>| FacePoint {
        places: [poses[0] * p.local_p1, poses[1] * p.local_p2].map(convert::vector_back),
        normal,
        slide: nalgebra::Vector3::zeros(),
        friction,
        restitution: 0.0,
        key: [a.index, b.index, manifold.subshape1, manifold.subshape2, p.fid1.0, p.fid2.0, 0],
    };
    DetectedFace { colliders: [a.handle, b.handle], points: manifold.points.iter().map(point).collect() }
}
