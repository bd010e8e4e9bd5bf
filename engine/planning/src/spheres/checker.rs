//! Tests states of a mechanism: which bodies may not touch, and whether they do.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3};
use tatu_geometry::Form;

use super::{
    fit::{Sphere, SphereCache, around, moved},
    frames::{FrameTree, pose_of},
    lanes::{LANES, Lane, LanePoint, LanePose, vectorized},
    obstacles::{Mask, NO_LANE, Obstacle, any, touch_each_other},
};
use crate::problem::Validity;

/// A rigid body: forms that are attached to a frame, or to the world.
#[derive(Debug, Clone)]
pub struct Body {
    /// The frame that carries it; `None`: it stays where it is.
    pub frame: Option<usize>,
    /// Its forms with their poses in the frame, or in the world.
    pub forms: Vec<(Isometry3<f64>, Form)>,
}

/// Decides whether bodies really touch whose spheres do.
pub trait Confirm {
    /// Returns whether two bodies touch or overlap. `poses` are those of their frames in the world, the identity for a
    /// body without a frame.
    fn is_touching(&mut self, bodies: [usize; 2], poses: [&Isometry3<f64>; 2]) -> bool;
}

/// A body that moves.
#[derive(Debug, Clone)]
struct Moving {
    body: usize,
    frame: usize,
    bound: Sphere,
    spheres: Vec<Sphere>,
    /// Obstacles that it may not touch, with their bodies.
    obstacles: Vec<(usize, Arc<Obstacle>)>,
    /// Others that move and that it may not touch: those with a larger index.
    others: Vec<usize>,
    /// Bodies with planes cannot be covered: their pairs are always confirmed.
    unbounded: bool,
}

/// Tests states of a mechanism by spheres, eight at once.
///
/// ```
/// use nalgebra::{Isometry3, Vector3};
/// use tatu_geometry::Form;
/// use tatu_planning::{Validity, spheres::{Body, BodyChecker, FrameMotion, FrameTree, MovingFrame, SphereCache}};
///
/// // A ball that moves along z, and a block 1 m above.
/// let mut frames = FrameTree::default();
/// let motion = FrameMotion::Slide { number: 0, factor: 1.0, offset: 0.0 };
/// let slider = frames.add(MovingFrame { parent: None, pose: Isometry3::identity(), motion });
/// let bodies = [
///     Body { frame: slider, forms: vec![(Isometry3::identity(), Form::Sphere { radius: 0.1 })] },
///     Body { frame: None, forms: vec![(Isometry3::translation(0.0, 0.0, 1.0), Form::Box { half: Vector3::repeat(0.2) })] },
/// ];
/// let mut checker = BodyChecker::new(frames, &bodies, &[[0, 1]], &mut SphereCache::default());
/// assert!(checker.is_valid(&[0.69]) && !checker.is_valid(&[0.71]));
/// ```
#[derive(Debug, Clone)]
pub struct BodyChecker<C = NoConfirm> {
    frames: FrameTree,
    moving: Vec<Moving>,
    confirm: C,
    confirms: bool,
    /// Least distance from obstacles that stay, m.
    margin: f64,
    /// Pairs that do not move: if they touch, no state is possible.
    fixed: Vec<[usize; 2]>,
    fixed_touches: Option<bool>,
    /// The body that touched last, which is tested first.
    suspect: usize,
    columns: Vec<Lane>,
    poses: Vec<LanePose>,
    centers: Vec<Vec<LanePoint>>,
    bounds: Vec<LanePoint>,
}

/// Confirms nothing: spheres decide.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoConfirm;

impl Confirm for NoConfirm {
    fn is_touching(&mut self, _: [usize; 2], _: [&Isometry3<f64>; 2]) -> bool {
        true
    }
}

/// Number of spheres that cover a form.
const SPHERES: usize = 24;

impl BodyChecker<NoConfirm> {
    /// Returns a test in which spheres decide. `pairs` are the indices of bodies that may not touch; those of bodies
    /// that do not exist, of a body with itself, and of two bodies that both stay are ignored.
    pub fn new(frames: FrameTree, bodies: &[Body], pairs: &[[usize; 2]], cache: &mut SphereCache) -> Self {
        let mut checker = BodyChecker::confirmed(frames, bodies, pairs, cache, NoConfirm);
        checker.confirms = false;
        checker.fixed_touches = Some(false);
        checker
    }
}

impl<C: Confirm> BodyChecker<C> {
    /// Returns a test in which `confirm` decides about bodies whose spheres touch. Two bodies that both stay are
    /// confirmed, too: if they touch, no state is possible.
    pub fn confirmed(
        frames: FrameTree,
        bodies: &[Body],
        pairs: &[[usize; 2]],
        cache: &mut SphereCache,
        confirm: C,
    ) -> Self {
        let of_body = |body: &Body, cache: &mut SphereCache| -> Vec<Sphere> {
            body.forms.iter().flat_map(|(pose, form)| moved(&cache.cover(form, SPHERES), pose)).collect()
        };
        let mut moving: Vec<Moving> = Vec::new();
        let mut index = vec![None; bodies.len()];
        for (i, body) in bodies.iter().enumerate() {
            let Some(frame) = body.frame.filter(|f| *f < frames.len()) else { continue };
            let spheres = of_body(body, cache);
            let unbounded = body.forms.iter().any(|(_, form)| matches!(form, Form::Plane));
            let Some(bound) =
                around(&spheres).or(unbounded.then_some(Sphere { center: Point3::origin(), radius: 1e9 }))
            else {
                continue;
            };
            index[i] = Some(moving.len());
            moving.push(Moving { body: i, frame, bound, spheres, obstacles: vec![], others: vec![], unbounded });
        }
        let mut still: Vec<Option<Vec<Arc<Obstacle>>>> = vec![None; bodies.len()];
        let mut fixed = Vec::new();
        for [a, b] in pairs.iter().copied().filter(|[a, b]| a != b && *a.max(b) < bodies.len()) {
            match (index[a], index[b]) {
                (Some(x), Some(y)) => {
                    if moving[x].frame != moving[y].frame || bodies[a].frame != bodies[b].frame {
                        moving[x.min(y)].others.push(x.max(y));
                    }
                }
                (Some(mover), None) | (None, Some(mover)) => {
                    let stays = if index[a].is_some() { b } else { a };
                    if bodies[stays].frame.is_some() {
                        continue;
                    }
                    let obstacles = still[stays].get_or_insert_with(|| {
                        let forms = bodies[stays].forms.iter();
                        let obstacle =
                            |(pose, form): &(_, _)| Obstacle::new(form, pose, &cache.cover(form, 4 * SPHERES));
                        forms.filter_map(obstacle).map(Arc::new).collect()
                    });
                    let own = obstacles.iter().map(|o| (stays, o.clone()));
                    moving[mover].obstacles.extend(own);
                }
                (None, None) => fixed.push([a, b]),
            }
        }
        let centers = moving.iter().map(|_| Vec::new()).collect();
        BodyChecker {
            columns: vec![[0.0; LANES]; frames.dimension()],
            frames,
            moving,
            confirm,
            confirms: true,
            margin: 0.0,
            fixed,
            fixed_touches: None,
            suspect: 0,
            poses: Vec::new(),
            centers,
            bounds: Vec::new(),
        }
    }

    /// Sets the least distance of bodies that move from those that stay, m; `Confirm` must respect it, too. Default 0.
    #[must_use]
    pub fn with_margin(mut self, margin: f64) -> Self {
        self.margin = margin.max(0.0);
        self
    }

    /// Returns the number of spheres that move.
    pub fn spheres(&self) -> usize {
        self.moving.iter().map(|m| m.spheres.len()).sum()
    }

    /// Returns a pair of bodies that touch in a state.
    pub fn touching(&mut self, state: &[f64]) -> Option<[usize; 2]> {
        if self.fixed_touch() {
            return self.fixed.first().copied();
        }
        self.load(state, self.columns.len());
        self.first_hit()
    }

    fn fixed_touch(&mut self) -> bool {
        if let Some(known) = self.fixed_touches {
            return known;
        }
        let here = Isometry3::identity();
        let touches = self.fixed.iter().position(|pair| self.confirm.is_touching(*pair, [&here, &here]));
        if let Some(i) = touches {
            self.fixed.swap(0, i);
        }
        self.fixed_touches = Some(touches.is_some());
        touches.is_some()
    }

    /// Takes up to eight states, the last of which fills the lanes that are left.
    fn load(&mut self, states: &[f64], dimension: usize) {
        let count = (states.len() / dimension.max(1)).max(1);
        for (number, column) in self.columns.iter_mut().enumerate() {
            for (l, x) in column.iter_mut().enumerate() {
                *x = states[l.min(count - 1) * dimension + number];
            }
        }
    }

    /// Returns bodies that touch in any of the states that were loaded.
    fn first_hit(&mut self) -> Option<[usize; 2]> {
        vectorized(
            #[inline(always)]
            || {
                self.frames.lane_poses(&self.columns, &mut self.poses);
                self.bounds.clear();
                for (m, centers) in self.moving.iter().zip(&mut self.centers) {
                    self.bounds.push(self.poses[m.frame].point(&array(&m.bound.center)));
                    centers.clear();
                }
                let count = self.moving.len();
                for i in 0..count {
                    // The suspect first, then the others in order.
                    let i = if i == 0 {
                        self.suspect
                    } else if i <= self.suspect {
                        i - 1
                    } else {
                        i
                    };
                    let hit = self.hit_obstacle(i).or_else(|| self.hit_other(i));
                    if hit.is_some() {
                        self.suspect = i;
                        return hit;
                    }
                }
                None
            },
        )
    }

    #[inline(always)]
    fn hit_obstacle(&mut self, i: usize) -> Option<[usize; 2]> {
        for o in 0..self.moving[i].obstacles.len() {
            let m = &self.moving[i];
            let (stays, obstacle) = (&m.obstacles[o].0, &m.obstacles[o].1);
            let near = if m.unbounded {
                [true; LANES]
            } else {
                obstacle.touches(&self.bounds[i], m.bound.radius + self.margin)
            };
            if !any(&near) {
                continue;
            }
            let mut hit = if m.unbounded { near } else { NO_LANE };
            locate(&self.poses[m.frame], &m.spheres, &mut self.centers[i]);
            for (center, sphere) in self.centers[i].iter().zip(&m.spheres) {
                unite(&mut hit, &obstacle.touches(center, sphere.radius + self.margin));
                if !self.confirms && any(&hit) {
                    break;
                }
            }
            let pair = [m.body, *stays];
            if any(&hit) && self.confirmed_hit(&hit, pair, i, None) {
                return Some(pair);
            }
        }
        None
    }

    #[inline(always)]
    fn hit_other(&mut self, i: usize) -> Option<[usize; 2]> {
        for o in 0..self.moving[i].others.len() {
            let j = self.moving[i].others[o];
            let (a, b) = (&self.moving[i], &self.moving[j]);
            let unbounded = a.unbounded || b.unbounded;
            let near = touch_each_other(&self.bounds[i], &self.bounds[j], a.bound.radius + b.bound.radius);
            if !unbounded && !any(&near) {
                continue;
            }
            locate(&self.poses[a.frame], &a.spheres, &mut self.centers[i]);
            locate(&self.poses[b.frame], &b.spheres, &mut self.centers[j]);
            let mut hit = if unbounded { [true; LANES] } else { NO_LANE };
            for (center, sphere) in self.centers[i].iter().zip(&a.spheres) {
                if !any(&touch_each_other(center, &self.bounds[j], sphere.radius + b.bound.radius)) {
                    continue;
                }
                for (other, second) in self.centers[j].iter().zip(&b.spheres) {
                    unite(&mut hit, &touch_each_other(center, other, sphere.radius + second.radius));
                }
                if !self.confirms && any(&hit) {
                    break;
                }
            }
            let pair = [a.body, b.body];
            if any(&hit) && self.confirmed_hit(&hit, pair, i, Some(j)) {
                return Some(pair);
            }
        }
        None
    }

    /// Returns whether bodies touch in any of the states in which their spheres do.
    #[inline(never)]
    fn confirmed_hit(&mut self, hit: &Mask, pair: [usize; 2], i: usize, j: Option<usize>) -> bool {
        if !self.confirms {
            return true;
        }
        let mut last: Option<[Isometry3<f64>; 2]> = None;
        (0..LANES).filter(|l| hit[*l]).any(|l| {
            let first = pose_of(&self.poses[self.moving[i].frame], l);
            let second = j.map_or_else(Isometry3::identity, |j| pose_of(&self.poses[self.moving[j].frame], l));
            // Lanes that are left are filled with the same state.
            let same = last.as_ref().is_some_and(|l| *l == [first, second]);
            let touches = !same && self.confirm.is_touching(pair, [&first, &second]);
            last = Some([first, second]);
            touches
        })
    }
}

fn array(p: &Point3<f64>) -> [f64; 3] {
    [p.x, p.y, p.z]
}

#[inline(always)]
fn unite(mask: &mut Mask, other: &Mask) {
    for l in 0..LANES {
        mask[l] |= other[l];
    }
}

/// Computes the centres of spheres in the world, unless this has been done.
#[inline(always)]
fn locate(pose: &LanePose, spheres: &[Sphere], centers: &mut Vec<LanePoint>) {
    if centers.is_empty() {
        for s in spheres {
            centers.push(pose.point(&array(&s.center)));
        }
    }
}

impl<C: Confirm> Validity for BodyChecker<C> {
    fn is_valid(&mut self, state: &[f64]) -> bool {
        self.are_valid(state, state.len().max(1))
    }

    fn are_valid(&mut self, states: &[f64], dimension: usize) -> bool {
        // A state that is too short cannot be tested, and is not possible.
        if dimension < self.columns.len() || self.fixed_touch() {
            return false;
        }
        states.chunks(LANES * dimension).all(|some| {
            self.load(some, dimension);
            self.first_hit().is_none()
        })
    }

    fn lanes(&self) -> usize {
        LANES
    }
}
