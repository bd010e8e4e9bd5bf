//! A solver that keeps limits in every step, and says why a goal cannot be reached.

use crate::{
    chain::{Chain, ChainError},
    descent::{Descent, Search},
    linkage::{FrameId, Linkage},
    random::Random,
    reach_task::{Distance, Goal, Target},
    refusal::{MAX_RESTARTS, ReachSettings, Reached, Refusal},
};

/// Number of starts for distances that are reported.
const REPORTED_STARTS: u32 = 4;
/// Greatest singular value that counts as that of a singular direction, and the least share of the error along it.
const SINGULAR: f64 = 0.02;
const SINGULAR_SHARE: f64 = 0.5;
/// If the least error is a rotation but for this share, m/rad, the orientation is what cannot be reached.
const TURNED_SHARE: f64 = 0.01;

/// Moves joints so that tips reach goals. All memory is allocated by [`new`](Self::new).
#[derive(Debug, Clone)]
pub struct ReachSolver {
    search: Search,
    /// The nearest positions of all descents.
    overall: Vec<f64>,
    /// The best positions of a search for a reason.
    reported: Vec<f64>,
}

impl ReachSolver {
    /// Compiles the joints that move some frames of a linkage.
    ///
    /// # Errors
    ///
    /// Fails like [`Chain::new`].
    pub fn new(linkage: &Linkage, tips: &[FrameId]) -> Result<Self, ChainError> {
        let chain = Chain::new(linkage, tips)?;
        let n = chain.joints().len();
        Ok(ReachSolver { search: Search::new(chain), overall: vec![0.0; n], reported: vec![0.0; n] })
    }

    /// Returns the joints and their order in all arrays of positions, from base to tip.
    pub fn joints(&self) -> &[FrameId] {
        self.search.chain.joints()
    }
    /// Returns the compiled chain.
    pub fn chain(&self) -> &Chain {
        &self.search.chain
    }
    /// Returns the positions that the last call found, rad or m; after a refusal, the nearest ones.
    pub fn positions(&self) -> &[f64] {
        &self.overall
    }

    /// Searches for positions within all limits for which all tips reach their goals: first from the start, then from
    /// others. `blocked` returns what the mechanism would collide with at some positions, if anything; other positions
    /// are then searched for.
    ///
    /// # Errors
    ///
    /// Returns the reason if none were found.
    pub fn solve(
        &mut self,
        goals: &[Goal],
        settings: &ReachSettings<'_>,
        blocked: &mut dyn FnMut(&[f64]) -> Option<u64>,
    ) -> Result<Reached, Refusal> {
        self.check(goals, settings).map_err(Refusal::Invalid)?;
        self.search.set_targets(goals, true);
        self.search.iterations = 0;
        self.search.set_box(settings.max_change.map(|change| (settings.start, change)));
        let restarts = if settings.max_change.is_some() { 0 } else { settings.restarts.min(MAX_RESTARTS) };
        let descent = Descent::quick(settings.iterations, settings.posture);
        let (mut random, mut least, mut collision) = (Random(settings.seed), f64::INFINITY, None);
        for restart in 0..=restarts {
            self.search.start(restart, settings.start, &mut random);
            let reached = self.search.descend(descent);
            if reached {
                self.search.turn_towards(settings.start);
                match blocked(&self.search.best) {
                    None => {
                        self.overall.copy_from_slice(&self.search.best);
                        let (distance, iterations) = (self.search.best_distance, self.search.iterations);
                        return Ok(Reached { distance, iterations, restarts: restart });
                    }
                    Some(what) if collision.is_none() => collision = Some(what),
                    Some(_) => {}
                }
            }
            if self.search.best_error < least {
                least = self.search.best_error;
                self.overall.copy_from_slice(&self.search.best);
            }
        }
        match collision {
            Some(what) => Err(Refusal::Collision(what)),
            None => self.explain(goals, settings, blocked),
        }
    }

    fn check(&self, goals: &[Goal], settings: &ReachSettings<'_>) -> Result<(), &'static str> {
        let n = self.overall.len();
        if goals.len() != self.search.chain.tips() {
            return Err("goals: expected one for each tip");
        }
        let numbers = |x: &[f64]| x.len() == n && x.iter().all(|x| x.is_finite());
        if !numbers(settings.start) {
            return Err("start: expected a finite number for each joint");
        }
        if settings.posture.is_some_and(|p| !numbers(p)) {
            return Err("posture: expected a finite number for each joint");
        }
        if settings.max_change.is_some_and(|c| c.len() != n || !c.iter().all(|x| *x >= 0.0)) {
            return Err("max_change: expected a number of at least 0 for each joint");
        }
        for goal in goals {
            let pose = goal.pose.translation.vector.iter().chain(goal.pose.rotation.coords.iter());
            let is_positive = |x: &f64| *x > 0.0 && x.is_finite();
            if !pose.copied().all(f64::is_finite) || !goal.weights.iter().chain(&goal.precision).all(is_positive) {
                return Err("goals: expected finite poses, and weights and precisions above 0");
            }
        }
        Ok(())
    }

    /// Returns why the goals were not reached. `overall` are the nearest positions. The search without limits may find
    /// positions within them, which are then the result.
    fn explain(
        &mut self,
        goals: &[Goal],
        settings: &ReachSettings<'_>,
        blocked: &mut dyn FnMut(&[f64]) -> Option<u64>,
    ) -> Result<Reached, Refusal> {
        let nearest = self.search.look(&self.overall);
        let from_here = settings.max_change.is_some() || settings.restarts < MAX_RESTARTS;
        if from_here && let Some((joint, by)) = self.least_excess(settings, false) {
            return Err(match settings.max_change {
                Some(_) => Refusal::Change { joint, by },
                None => self.singular_direction().unwrap_or(Refusal::NotFound(nearest)),
            });
        }
        match self.least_excess(settings, true) {
            Some((joint, by)) if by != 0.0 => return Err(Refusal::Limit { joint, by }),
            Some(_) if !from_here => {
                self.search.best.copy_from_slice(&self.reported);
                self.search.turn_towards(settings.start);
                self.overall.copy_from_slice(&self.search.best);
                let distance = self.search.look(&self.overall);
                let reached = Reached { distance, iterations: self.search.iterations, restarts: MAX_RESTARTS + 1 };
                return blocked(&self.overall).map_or(Ok(reached), |what| Err(Refusal::Collision(what)));
            }
            _ => {}
        }
        Err(self.out_of_reach(goals, settings).unwrap_or(Refusal::NotFound(nearest)))
    }

    /// Searches for positions that reach the goals, without limits if `free`. Returns the joint that exceeds its bounds
    /// most, and by how much, in the solution in which this is least; `reported` is this solution. The bounds are the
    /// limits if `free`, and the greatest changes from the start otherwise.
    fn least_excess(&mut self, settings: &ReachSettings<'_>, free: bool) -> Option<(FrameId, f64)> {
        if free {
            self.search.remove_box();
        } else {
            self.search.set_box(None);
        }
        let descent = Descent::quick(settings.iterations, None);
        let (mut random, mut least) = (Random(!settings.seed), None::<(usize, f64)>);
        for restart in 0..=MAX_RESTARTS {
            self.search.start(restart, settings.start, &mut random);
            if !self.search.descend(descent) {
                continue;
            }
            let most = if free {
                self.search.turn_into_limits();
                largest_excess(&self.search.best, self.search.chain.limits().iter().copied())
            } else {
                self.search.turn_towards(settings.start);
                let change = |i: usize| settings.max_change.map_or(f64::INFINITY, |change| change[i]);
                let bounds = settings.start.iter().enumerate().map(|(i, q)| [q - change(i), q + change(i)]);
                largest_excess(&self.search.best, bounds)
            };
            if least.is_none_or(|least| most.1.abs() < least.1.abs()) {
                least = Some(most);
                self.reported.copy_from_slice(&self.search.best);
            }
        }
        least.map(|(i, by)| (self.search.chain.joints()[i], by))
    }

    /// Returns by how much the goals are out of reach even without limits.
    fn out_of_reach(&mut self, goals: &[Goal], settings: &ReachSettings<'_>) -> Option<Refusal> {
        for oriented in [false, true] {
            self.search.set_targets(goals, oriented);
            let found = self.least_distance(settings);
            let greatest = |k: usize| goals.iter().map(|g| g.precision[k]).fold(0.0, f64::max);
            if oriented && found.angle > greatest(1) && found.distance < TURNED_SHARE * found.angle {
                return Some(Refusal::Orientation { by: found.angle });
            }
            if found.distance > greatest(0) {
                return Some(Refusal::OutOfReach { by: found.distance, inside: self.is_inside(), oriented });
            }
        }
        None
    }

    /// Returns the least distance from the targets without limits, and leaves the positions there.
    fn least_distance(&mut self, settings: &ReachSettings<'_>) -> Distance {
        self.search.remove_box();
        let (mut random, mut least, mut found) = (Random(settings.seed), f64::INFINITY, Distance::default());
        for restart in 0..=REPORTED_STARTS {
            self.search.start(restart, settings.start, &mut random);
            self.search.descend(Descent::careful());
            if self.search.best_error < least {
                (least, found) = (self.search.best_error, self.search.best_distance);
                self.reported.copy_from_slice(&self.search.best);
            }
        }
        self.search.best.copy_from_slice(&self.reported);
        found
    }

    /// Returns whether the first target that is missed is nearer to the first joint than the tip is.
    fn is_inside(&mut self) -> bool {
        self.search.chain.place(&self.search.best);
        let missed = |(tip, target): (usize, &Target)| {
            let root = self.search.chain.root(tip)?;
            let at = self.search.chain.tip(tip).1;
            Some(((target.place - at).norm(), (target.place - root).norm() < (at - root).norm()))
        };
        let all = self.search.targets.iter().enumerate().filter_map(missed);
        all.fold((0.0, false), |a, b| if b.0 > a.0 { b } else { a }).1
    }

    /// Returns the direction in which the tips must move at the nearest positions, if no joint moves them there.
    fn singular_direction(&mut self) -> Option<Refusal> {
        let search = &mut self.search;
        search.look(&self.overall);
        let value = search.step.weakest_direction()?;
        let (weak, error) = (&search.step.rest[..search.rows], &search.step.error[..search.rows]);
        let norm = error.iter().map(|e| e * e).sum::<f64>().sqrt();
        let along: f64 = weak.iter().zip(error).map(|(w, e)| w * e).sum();
        if value > SINGULAR || along.abs() < SINGULAR_SHARE * norm {
            return None;
        }
        let mut direction = [0.0; 6];
        search.targets[0].spread(&search.chain.tip(0).0, weak, &mut direction);
        Some(Refusal::Singular { direction: direction.map(|x| x * along.signum()) })
    }
}

/// Returns which value is furthest outside of its bounds, and by how much: negative below the lower one, 0 if all are
/// within.
fn largest_excess(q: &[f64], bounds: impl Iterator<Item = [f64; 2]>) -> (usize, f64) {
    let excess = q.iter().zip(bounds).map(|(q, [low, high])| (q - high).max(0.0) + (q - low).min(0.0));
    excess.enumerate().fold((0, 0.0), |a: (usize, f64), b| if b.1.abs() > a.1.abs() { b } else { a })
}
