//! Slow separation of bodies that overlap when they are created.
//!
//! The engine pushes bodies apart faster the deeper they overlap. If a joint holds them together, the push has no
//! effect and grows in each sub-step; the slightest tilt then turns it into a kick of hundreds of m/s along the free
//! axes of the joint. The contacts of such pairs are therefore reported to the solver with a smaller depth, until the
//! two bodies have separated.

use std::collections::BTreeMap;

use rapier3d::{
    geometry::{ColliderHandle, PairContacts},
    parry::{bounding_volume::Aabb, query},
};

use super::{collision_filter, records::PairSeparation, state::Rapier};
use crate::{BodyId, MotionType};

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

impl Rapier {
    /// Returns the depth at which the solver separates bodies at `SEPARATION_SPEED`, m: between two moving bodies, and
    /// with a fixed body.
    pub(super) fn separation_depths(&self) -> [f64; 2] {
        let numbers = &self.world.integration_parameters;
        [&numbers.contact_softness, &numbers.static_contact_softness]
            .map(|spring| SEPARATION_SPEED / spring.erp_inv_dt(self.substep()))
    }

    /// Finds overlapping pairs of bodies, at least one of which is new, before a step.
    pub(super) fn find_overlaps(&mut self) {
        if self.state.fresh.is_empty() {
            return;
        }
        let fresh = std::mem::take(&mut self.state.fresh);
        let mut placed = self.overlap_candidates(&fresh);
        placed.sort_by(|a, b| a.bounds.mins.x.total_cmp(&b.bounds.mins.x));
        let depths = self.separation_depths();
        let mechanisms = self.mechanism_roots();
        let mut found = BTreeMap::new();
        for (i, a) in placed.iter().enumerate() {
            for b in placed[i + 1..].iter().take_while(|b| b.bounds.mins.x <= a.bounds.maxs.x) {
                let pair = (a.body.min(b.body), a.body.max(b.body));
                let may = a.body != b.body && (a.moved || b.moved) && (a.fresh || b.fresh);
                if !may || found.contains_key(&pair) || !self.may_collide(a.body, b.body) {
                    continue;
                }
                let held = mechanisms.get(&a.body).is_some_and(|m| mechanisms.get(&b.body) == Some(m));
                let least = if held { MIN_FITTED_DEPTH } else { depths[usize::from(!(a.moved && b.moved))] };
                if self.overlap_depth(a, b) > least {
                    let fit = if held { f64::MAX } else { 0.0 };
                    found.insert(pair, PairSeparation { fit, held, asked: (f64::MAX, 0.0) });
                }
            }
        }
        for (pair, parting) in found {
            self.state.partings.insert(pair, parting);
            self.enable_contact_hook(pair.0);
            self.enable_contact_hook(pair.1);
        }
    }

    fn overlap_candidates(&self, fresh: &[BodyId]) -> Vec<OverlapCandidate> {
        let mut placed = Vec::new();
        for (id, record) in (0..).map(BodyId).zip(&self.state.bodies) {
            let Some(record) = record else { continue };
            let body = &self.world.bodies[record.handle];
            for &collider in body.colliders() {
                let Some(c) = self.world.colliders.get(collider) else { continue };
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

    fn may_collide(&self, a: BodyId, b: BodyId) -> bool {
        let (Some(first), Some(second)) = (self.record(a), self.record(b)) else { return false };
        let rule = self.state.pairs.get(&(a.min(b), a.max(b)));
        collision_filter::masks_collide(first.respond, second.respond) && rule.is_none_or(|r| r.responds)
    }

    /// Returns the depth of the overlap of two colliders, m; negative if they do not overlap.
    fn overlap_depth(&self, a: &OverlapCandidate, b: &OverlapCandidate) -> f64 {
        let colliders = &self.world.colliders;
        let (Some(first), Some(second)) = (colliders.get(a.collider), colliders.get(b.collider)) else { return -1.0 };
        if !a.bounds.mins.cmple(b.bounds.maxs).all() || !b.bounds.mins.cmple(a.bounds.maxs).all() {
            return -1.0;
        }
        let met = query::contact(first.position(), first.shape(), second.position(), second.shape(), 0.0);
        met.ok().flatten().map_or(-1.0, |c| -c.dist)
    }

    /// Returns the lowest body id in the mechanism of each body with joints.
    fn mechanism_roots(&self) -> BTreeMap<BodyId, BodyId> {
        let mut above: BTreeMap<BodyId, BodyId> = BTreeMap::new();
        fn root(above: &BTreeMap<BodyId, BodyId>, mut id: BodyId) -> BodyId {
            while let Some(next) = above.get(&id).filter(|n| **n != id) {
                id = *next;
            }
            id
        }
        for record in self.state.joints.iter().flatten() {
            let (a, b) = (root(&above, record.bodies.0), root(&above, record.bodies.1));
            above.insert(a.max(b), a.min(b));
            above.entry(a.min(b)).or_insert(a.min(b));
        }
        above.keys().map(|id| (*id, root(&above, *id))).collect()
    }

    /// Updates overlapping pairs after a step. Pairs that have separated become ordinary pairs.
    pub(super) fn update_separations(&mut self) {
        if self.state.partings.is_empty() {
            return;
        }
        let (step, depths) = (self.world.integration_parameters.dt, self.separation_depths());
        let mut parted = Vec::new();
        let mut partings = std::mem::take(&mut self.state.partings);
        partings.retain(|pair, parting| {
            let depth = self.contact_depth(*pair);
            let still =
                [pair.0, pair.1].iter().any(|id| self.record(*id).is_none_or(|r| r.motion != MotionType::Dynamic));
            let least = if parting.held { MIN_FITTED_DEPTH } else { depths[usize::from(still)] };
            if depth <= least {
                parted.push(*pair);
                return false;
            }
            parting.fit = parting.fit.min(depth);
            parting.asked.1 += step;
            if parting.asked.1 >= CHECK_INTERVAL_S {
                // A pair that cannot separate keeps its overlap.
                if parting.asked.0 - depth < 0.1 * SEPARATION_SPEED * parting.asked.1 {
                    parting.fit = depth;
                }
                parting.asked = (depth, 0.0);
            }
            true
        });
        self.state.partings = partings;
        for id in parted.into_iter().flat_map(|(a, b)| [a, b]) {
            self.disable_contact_hook(id);
        }
    }

    /// Returns the depth of the overlap of two bodies at the last collision detection, m.
    fn contact_depth(&self, (a, b): (BodyId, BodyId)) -> f64 {
        let (Some(first), Some(second)) = (self.record(a), self.record(b)) else { return 0.0 };
        let of_second = self.world.bodies[second.handle].colliders();
        let mut depth = 0.0f64;
        for collider in self.world.bodies[first.handle].colliders() {
            for pair in self.world.narrow_phase.contact_pairs_with(*collider) {
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
}
