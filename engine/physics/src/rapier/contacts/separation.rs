//! Slow separation of bodies that overlap when they are created.
//!
//! The deeper bodies overlap, the faster the engine pushes them apart. If a joint holds them together, the push has no
//! effect and grows in each sub-step; the slightest tilt then turns it into a kick of hundreds of m/s along the free
//! axes of the joint. The contacts of such pairs are therefore reported to the solver with a smaller depth, until the
//! two bodies have separated.

use std::collections::BTreeMap;

use rapier3d::{
    geometry::{ColliderHandle, PairContacts},
    parry::{bounding_volume::Aabb, query},
};

use super::{
    colliders::enable_contact_hook,
    masks,
    table::{Contacts, PairSeparation},
};
use crate::{BodyId, MotionType, rapier::bodies::Bodies};

/// Speed at which overlapping bodies are separated, m/s.
const SEPARATION_SPEED: f64 = 0.2;

/// Minimum depth at which bodies of one mechanism are considered to overlap by design, m.
const MIN_FITTED_DEPTH: f64 = 1e-4;

/// Interval at which the separation of a pair is checked, s. If a pair has moved apart by less than a tenth of the
/// distance that `SEPARATION_SPEED` would cover in this time, the solver no longer pushes it apart.
const CHECK_INTERVAL_S: f64 = 0.1;

/// A collider, with the data needed to find overlaps.
struct OverlapCandidate {
    collider: ColliderHandle,
    body: BodyId,
    moved: bool,
    fresh: bool,
    bounds: Aabb,
}

impl Contacts {
    /// Finds overlapping pairs of bodies, at least one of which is new, before a step. `mechanism_roots` returns the
    /// lowest body id in the mechanism of each body with joints.
    pub fn find_overlaps(&mut self, bodies: &mut Bodies, mechanism_roots: impl FnOnce() -> BTreeMap<BodyId, BodyId>) {
        if self.fresh.is_empty() {
            return;
        }
        let fresh = std::mem::take(&mut self.fresh);
        let mut placed = overlap_candidates(bodies, &fresh);
        placed.sort_by(|a, b| a.bounds.mins.x.total_cmp(&b.bounds.mins.x));
        let depths = separation_depths(bodies);
        let mechanisms = mechanism_roots();
        let mut found = BTreeMap::new();
        for (i, a) in placed.iter().enumerate() {
            for b in placed[i + 1..].iter().take_while(|b| b.bounds.mins.x <= a.bounds.maxs.x) {
                let pair = (a.body.min(b.body), a.body.max(b.body));
                let may = a.body != b.body && (a.moved || b.moved) && (a.fresh || b.fresh);
                if !may || found.contains_key(&pair) || !self.may_collide(bodies, a.body, b.body) {
                    continue;
                }
                let held = mechanisms.get(&a.body).is_some_and(|m| mechanisms.get(&b.body) == Some(m));
                let least = if held { MIN_FITTED_DEPTH } else { depths[usize::from(!(a.moved && b.moved))] };
                if overlap_depth(bodies, a, b) > least {
                    let fit = if held { f64::MAX } else { 0.0 };
                    found.insert(pair, PairSeparation { fit, held, last_check: (f64::MAX, 0.0) });
                }
            }
        }
        for (pair, separation) in found {
            self.separations.insert(pair, separation);
            enable_contact_hook(bodies, pair.0);
            enable_contact_hook(bodies, pair.1);
        }
    }

    fn may_collide(&self, bodies: &Bodies, a: BodyId, b: BodyId) -> bool {
        let (Some(first), Some(second)) = (bodies.record(a), bodies.record(b)) else { return false };
        let rule = self.pairs.get(&(a.min(b), a.max(b)));
        masks::masks_collide(first.respond, second.respond) && rule.is_none_or(|r| r.responds)
    }

    /// Updates overlapping pairs after a step. Pairs that have separated become ordinary pairs.
    pub fn update_separations(&mut self, bodies: &mut Bodies) {
        if self.separations.is_empty() {
            return;
        }
        let (step, depths) = (bodies.world.integration_parameters.dt, separation_depths(bodies));
        let mut parted = Vec::new();
        let mut separations = std::mem::take(&mut self.separations);
        separations.retain(|pair, separation| {
            let depth = contact_depth(bodies, *pair);
            let still =
                [pair.0, pair.1].iter().any(|id| bodies.record(*id).is_none_or(|r| r.motion != MotionType::Dynamic));
            let least = if separation.held { MIN_FITTED_DEPTH } else { depths[usize::from(still)] };
            if depth <= least {
                parted.push(*pair);
                return false;
            }
            separation.fit = separation.fit.min(depth);
            separation.last_check.1 += step;
            if separation.last_check.1 >= CHECK_INTERVAL_S {
                // A pair that cannot separate keeps its overlap.
                if separation.last_check.0 - depth < 0.1 * SEPARATION_SPEED * separation.last_check.1 {
                    separation.fit = depth;
                }
                separation.last_check = (depth, 0.0);
            }
            true
        });
        self.separations = separations;
        for id in parted.into_iter().flat_map(|(a, b)| [a, b]) {
            self.disable_contact_hook(bodies, id);
        }
    }
}

/// Returns the depth at which the solver separates bodies at `SEPARATION_SPEED`, m: between two moving bodies, and with
/// a fixed body.
pub(crate) fn separation_depths(bodies: &Bodies) -> [f64; 2] {
    let numbers = &bodies.world.integration_parameters;
    [&numbers.contact_softness, &numbers.static_contact_softness]
        .map(|spring| SEPARATION_SPEED / spring.erp_inv_dt(bodies.substep()))
}

fn overlap_candidates(bodies: &Bodies, fresh: &[BodyId]) -> Vec<OverlapCandidate> {
    let mut placed = Vec::new();
    for (id, record) in (0..).map(BodyId).zip(&bodies.records) {
        let Some(record) = record else { continue };
        let body = &bodies.world.bodies[record.handle];
        for &collider in body.colliders() {
            let Some(c) = bodies.world.colliders.get(collider) else { continue };
            placed.push(OverlapCandidate {
                collider,
                body: id,
                moved: record.motion == MotionType::Dynamic && body.is_enabled(),
                fresh: fresh.binary_search(&id).is_ok(),
                bounds: c.compute_aabb(),
            });
        }
    }
    placed
}

/// Returns the depth of the overlap of two colliders, m; negative if they do not overlap.
fn overlap_depth(bodies: &Bodies, a: &OverlapCandidate, b: &OverlapCandidate) -> f64 {
    let colliders = &bodies.world.colliders;
    let (Some(first), Some(second)) = (colliders.get(a.collider), colliders.get(b.collider)) else { return -1.0 };
    if !a.bounds.mins.cmple(b.bounds.maxs).all() || !b.bounds.mins.cmple(a.bounds.maxs).all() {
        return -1.0;
    }
    let met = query::contact(first.position(), first.shape(), second.position(), second.shape(), 0.0);
    met.ok().flatten().map_or(-1.0, |c| -c.dist)
}

/// Returns the depth of the overlap of two bodies at the last collision detection, m.
fn contact_depth(bodies: &Bodies, (a, b): (BodyId, BodyId)) -> f64 {
    let (Some(first), Some(second)) = (bodies.record(a), bodies.record(b)) else { return 0.0 };
    let of_second = bodies.world.bodies[second.handle].colliders();
    let mut depth = 0.0f64;
    for collider in bodies.world.bodies[first.handle].colliders() {
        for pair in bodies.world.narrow_phase.contact_pairs_with(*collider) {
            let PairContacts::Rigid(rigid) = &pair.contacts else { continue };
            let other = if pair.collider1 == *collider { pair.collider2 } else { pair.collider1 };
            if of_second.contains(&other) {
                let points = rigid.solver_manifolds().iter().flat_map(|m| &m.points);
                depth = points.fold(depth, |d, p| d.max(-p.dist));
            }
        }
    }
    depth
}
