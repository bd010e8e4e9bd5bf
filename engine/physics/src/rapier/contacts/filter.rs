//! The filter that decides which pairs collide, and sets the properties of their contacts.

use std::collections::BTreeMap;

use rapier3d::{
    dynamics::{RigidBody, RigidBodyHandle},
    geometry::SolverFlags,
    math::Vector,
    pipeline::{ContactModificationContext, PairFilterContext, PhysicsHooks},
};

use super::{
    masks::{self, ColliderTag},
    separation::separation_depths,
    table::{Contacts, MAX_FRICTION, PairSeparations, material_pair},
};
use crate::{
    BodyId, ContactSurface, MaterialPair, PairRule, convert,
    rapier::bodies::{Bodies, IN_TREE_FLAG},
};

/// Speed of an impact below which the lag of rapier's velocities is not corrected, as a multiple of the lag.
const SLOW_BOUNCE_LAGS: f64 = 10.0;

/// Filters contacts by masks, then applies materials and surfaces, then pair rules. All of these are part of the
/// engine's state, so the filter returns the same result on every thread and after a restore.
pub(crate) struct PairFilter<'a> {
    pairs: &'a BTreeMap<(BodyId, BodyId), PairRule>,
    surfaces: &'a BTreeMap<BodyId, ContactSurface>,
    materials: &'a [MaterialPair],
    separations: &'a PairSeparations,
    /// Maximum penetration depth of overlapping pairs that is passed to the solver, m: between two moving bodies, and
    /// with a fixed body.
    max_depths: [f64; 2],
    /// Gravity, m/s².
    gravity: Vector,
    /// Durations of the step and of its sub-steps, s.
    step: f64,
    substep: f64,
}

impl<'a> PairFilter<'a> {
    /// Returns the filter for the next step.
    pub fn new(contacts: &'a Contacts, bodies: &Bodies) -> Self {
        PairFilter {
            pairs: &contacts.pairs,
            surfaces: &contacts.surfaces,
            materials: &contacts.materials,
            separations: &contacts.separations,
            max_depths: separation_depths(bodies),
            gravity: bodies.world.gravity,
            step: bodies.world.integration_parameters.dt,
            substep: bodies.substep(),
        }
    }

    /// Returns the coefficient with which rapier gives two bodies the right speed after a bounce. Rapier multiplies it
    /// by the speed at the beginning of the step, although the bodies are accelerated until they touch, and its
    /// velocities are those of half a sub-step ago. Without this, a ball that falls from 1 m and keeps half of its
    /// speed would lose 1, 4 and 8 % of its height in three bounces. `points` are the closest points of the bodies,
    /// which are `gap` apart along the normal, m.
    fn restitution(
        &self,
        coefficient: f64,
        bodies: [Option<&RigidBody>; 2],
        points: [Vector; 2],
        normal: Vector,
        gap: f64,
    ) -> f64 {
        let speed = |body: Option<&RigidBody>, point| body.map_or(Vector::ZERO, |b| b.velocity_at_point(point));
        let falls = |body: Option<&RigidBody>| match body {
            Some(body) if body.is_dynamic() => self.gravity * body.gravity_scale(),
            _ => Vector::ZERO,
        };
        let approach = (speed(bodies[0], points[0]) - speed(bodies[1], points[1])).dot(normal);
        let acceleration = (falls(bodies[0]) - falls(bodies[1])).dot(normal);
        let lag = 0.5 * acceleration * self.substep;
        // Slow bodies come to rest instead.
        if approach <= SLOW_BOUNCE_LAGS * lag.abs() {
            return coefficient;
        }
        let start = (approach + lag).max(0.0);
        // If they do not touch within the step and a sub-step, it does not matter.
        let time = self.step + self.substep;
        let most = start * time + 0.5 * acceleration.max(0.0) * time * time;
        let hit = start * start + 2.0 * acceleration * gap.clamp(0.0, most);
        // Rapier stops bodies that will touch in the sub-step after this step, so they bounce above the surface.
        let parts = (self.step / self.substep).round();
        let above = gap - self.step * (approach + 0.5 * acceleration * self.substep * (parts + 1.0));
        let left = coefficient * coefficient * hit - 2.0 * acceleration * above.max(0.0);
        (left.max(0.0).sqrt() + lag).max(0.0) / approach
    }

    fn rule(&self, a: ColliderTag, b: ColliderTag) -> Option<&PairRule> {
        if self.pairs.is_empty() {
            return None;
        }
        self.pairs.get(&(BodyId(a.body.min(b.body)), BodyId(a.body.max(b.body))))
    }
}

impl PhysicsHooks for PairFilter<'_> {
    fn filter_contact_pair(&self, pair: &PairFilterContext) -> Option<SolverFlags> {
        // A filter also replaces rapier's own rule that at least one of the two bodies must be dynamic.
        let moved = |body: Option<RigidBodyHandle>| {
            body.is_some_and(|b| pair.bodies[b].is_dynamic() || pair.bodies[b].user_data & IN_TREE_FLAG != 0)
        };
        if !moved(pair.rigid_body1) && !moved(pair.rigid_body2) {
            return None;
        }
        let a = ColliderTag::unpack(pair.colliders[pair.collider1].user_data);
        let b = ColliderTag::unpack(pair.colliders[pair.collider2].user_data);
        let collide =
            masks::masks_collide(a.collision_mask, b.collision_mask) && self.rule(a, b).is_none_or(|r| r.responds);
        collide.then_some(SolverFlags::COMPUTE_RIGID_IMPULSES)
    }

    fn modify_solver_contacts(&self, context: &mut ContactModificationContext) {
        let a = ColliderTag::unpack(context.colliders[context.collider1].user_data);
        let b = ColliderTag::unpack(context.colliders[context.collider2].user_data);
        let (first, second) = (self.surfaces.get(&BodyId(a.body)), self.surfaces.get(&BodyId(b.body)));
        let rule = self.rule(a, b).copied();
        let (bodies, handles) = (context.bodies, [context.rigid_body1, context.rigid_body2]);
        let Some(face) = context.rigid_mut() else { return };
        if let Some(parting) = self.separations.get(&(BodyId(a.body.min(b.body)), BodyId(a.body.max(b.body)))) {
            let moves =
                |h: Option<RigidBodyHandle>| h.and_then(|h| bodies.get(h)).is_some_and(|b| b.is_dynamic_or_kinematic());
            let deepest = self.max_depths[usize::from(!handles.into_iter().all(moves))];
            face.solver_contacts.iter_mut().for_each(|c| c.dist = parting.reported_distance(c.dist, deepest));
        }
        *face.friction = face.friction.min(MAX_FRICTION);
        let material = |s: Option<&ContactSurface>| s.map_or(0, |s| s.material);
        if let Some(pair) = material_pair(self.materials, material(first), material(second)) {
            *face.friction = pair.friction;
            *face.restitution = pair.restitution.unwrap_or(*face.restitution);
        }
        // The second body must move over the first one at the speed of the belts.
        let belt = |s: Option<&ContactSurface>, h: Option<RigidBodyHandle>| match (s, h.and_then(|h| bodies.get(h))) {
            (Some(s), Some(body)) => body.position().rotation * convert::vector(&s.velocity),
            _ => Vector::ZERO,
        };
        let mut belts = belt(first, handles[0]) - belt(second, handles[1]);
        if let Some(rule) = &rule {
            let side = if a.body < b.body { 1.0 } else { -1.0 };
            belts += convert::vector(&(side * rule.slide));
        }
        if belts != Vector::ZERO {
            let along = belts - *face.normal * belts.dot(*face.normal);
            face.solver_contacts.iter_mut().for_each(|c| c.tangent_velocity += along);
        }
        // Anisotropic friction has separate constraints.
        if [first, second].iter().any(|s| s.is_some_and(|s| s.axis.is_some())) {
            *face.friction = 0.0;
        }
        if let Some(friction) = rule.and_then(|r| r.friction) {
            *face.friction = friction;
        }
        if let Some(restitution) = rule.and_then(|r| r.restitution) {
            *face.restitution = restitution;
        }
        if *face.restitution > 0.0 {
            let closest = face.solver_contacts.iter().map(|c| (c.dist, c.anchor1, c.anchor2));
            if let Some((gap, one, two)) = closest.reduce(|a, b| if b.0 < a.0 { b } else { a }) {
                let moved = handles.map(|h| h.and_then(|h| bodies.get(h)));
                *face.restitution = self.restitution(*face.restitution, moved, [one, two], *face.normal, gap);
            }
        }
    }
}
