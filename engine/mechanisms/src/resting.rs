//! Direct solution of contacts that rest: the bodies stick together or separate, and none slides or bounces.
//!
//! Where several distributions of force have the same effect, as under a table with four legs, sweeps end at one that
//! depends on where they started, often with all of the force on a few points; the torque that friction can carry is
//! then lost. This solution is the least one: the weighted sum of the squares of all impulses is minimal.
//!
//! With the rows W of all contacts that press, W l = b is solved by proximal point iterations: (W + e I) (l' - l) =
//! b - W l, starting at 0. Each divides the error by at least 1 + s / e (with the weights below, e times the greatest),
//! where s is the least response of W that is not 0, and adds nothing to directions without response. Which contacts
//! press is found by pivoting, as in `pivot`.
//!
//! If friction were distributed evenly, it would exceed the bound at points that carry little load. Each friction
//! impulse is therefore weighted by the inverse square of its bound. The bound is first derived from the impulses so
//! far and then, if a bound is exceeded, from the normal impulses found, as in iteratively reweighted least squares:
//! with weights D, (W + e D) (l' - l) = b - W l leads to the solution with the least l.D l.
//!
//! Source: Rockafellar, Monotone operators and the proximal point algorithm, SIAM Journal on Control and Optimization
//! 14, 1976, for the iteration.

use crate::{
    contact::ContactPoint,
    coupling::DelassusMatrix,
    jacobian::ContactJacobian,
    vector::{Vec3, dot_slices},
};

/// Maximum number of contacts that are solved directly; the duration grows with the cube of the number.
const MAX_CONTACTS: usize = 48;
/// Maximum number of solutions for different sets of pressing contacts and weights.
const MAX_TRIES: usize = 8;
/// The regularisation e of the iteration, relative to the greatest response.
const REGULARIZATION: f64 = 1e-9;
/// Maximum number of iterations.
const MAX_ITERATIONS: usize = 6;
/// Maximum number of times that friction is weighted by its bounds.
const MAX_REWEIGHTINGS: usize = 2;
/// Minimum bound of friction, relative to the greatest, that is used as a weight; 0 would be an infinite weight.
const MIN_BOUND_SHARE: f64 = 0.01;
/// Tolerance of the friction bound, relative to the bound.
const FRICTION_TOLERANCE: f64 = 1e-9;

/// The result of an attempt to find the impulses.
pub(crate) enum RestingOutcome {
    /// All contacts rest under the impulses found.
    Rests,
    /// Some contact slides; the impulses found satisfy everything but its friction bound, and are limited to it.
    Slides,
    /// No impulses were found.
    Fails,
}

/// The solver, with its memory.
#[derive(Debug, Clone, Default)]
pub(crate) struct RestingSolver {
    /// The contacts that can move; the other tables below have one entry for each of them, or for each of their rows.
    points: Vec<usize>,
    coupling: DelassusMatrix,
    /// Impulses along the rows of each contact, N s.
    found: Vec<Vec3>,
    presses: Vec<bool>,
    /// Velocities to be gained by the impulses, m/s.
    targets: Vec<f64>,
    active: Vec<usize>,
    /// Weights of the rows in the norm that is minimal.
    weights: Vec<f64>,
    /// Lower triangle of the factor of the active rows, by rows.
    factor: Vec<f64>,
    step: Vec<f64>,
    /// Impulses of all contacts, N s: those found, and those given for contacts that cannot move.
    pub impulses: Vec<Vec3>,
}

impl RestingSolver {
    /// Returns whether the number of contacts that transmit force is at most `MAX_CONTACTS`.
    pub fn is_small_enough(rows: &ContactJacobian) -> bool {
        rows.points.iter().filter(|p| p.normal > 0.0).count() <= MAX_CONTACTS
    }

    /// Discards the responses, which may be those of an earlier factorisation.
    pub fn forget(&mut self) {
        self.points.clear();
    }

    /// Returns whether the responses of all rows are known.
    pub fn covers(&self, rows: &ContactJacobian) -> bool {
        self.points.len() == rows.points.len()
    }

    /// Returns the responses of all rows to an impulse along one of them, 1/kg, if [`covers`](Self::covers).
    #[inline]
    pub fn responses(&self, row: usize) -> &[f64] {
        self.coupling.row(row)
    }

    /// Finds the impulses under which all contacts rest at the end of a step of duration `h`, s. `start` are the
    /// impulses that `jacobian` already includes. Contacts that cannot move keep theirs. The tolerance is a velocity,
    /// m/s.
    pub fn solve(
        &mut self,
        rows: &ContactJacobian,
        contacts: &[ContactPoint],
        start: &[Vec3],
        h: f64,
        tolerance: f64,
    ) -> RestingOutcome {
        self.points.clear();
        self.points.extend((0..rows.points.len()).filter(|i| rows.points[*i].normal > 0.0));
        self.coupling.update(rows, &self.points);
        self.set_targets(rows, contacts, start, h);
        self.presses.clear();
        let presses = |(i, point): (usize, &usize)| start[*point][0] > 0.0 || self.targets[3 * i] > 0.0;
        self.presses.extend(self.points.iter().enumerate().map(presses));
        self.found.clear();
        self.found.extend(self.points.iter().map(|p| start[*p]));
        self.weigh_friction(contacts);
        let mut reweightings = 0;
        for _ in 0..MAX_TRIES {
            self.select_active_rows(rows, contacts);
            if !self.find_impulses(tolerance) {
                return RestingOutcome::Fails;
            }
            if self.update_pressing(tolerance) {
                continue;
            }
            if reweightings < MAX_REWEIGHTINGS && self.exceeds_friction(contacts) {
                self.weigh_friction(contacts);
                reweightings += 1;
                continue;
            }
            let outcome = self.limit_friction(contacts);
            self.impulses.clear();
            self.impulses.extend_from_slice(start);
            self.points.iter().zip(&self.found).for_each(|(point, found)| self.impulses[*point] = *found);
            return outcome;
        }
        RestingOutcome::Fails
    }

    /// Computes the velocities that the impulses must add to those without any impulse.
    fn set_targets(&mut self, rows: &ContactJacobian, contacts: &[ContactPoint], start: &[Vec3], h: f64) {
        self.targets.clear();
        for (i, &p) in self.points.iter().enumerate() {
            let (point, contact) = (&rows.points[p], &contacts[p]);
            let slide = |row: usize| crate::vector::dot(point.axes[row], contact.slide.into());
            let target = [point.min_velocity(h), slide(1), slide(2)];
            for (row, target) in target.into_iter().enumerate() {
                let responses = self.coupling.row(3 * i + row);
                let effect = |(w, p): (&[f64], &usize)| (0..3).map(|r| w[r] * start[*p][r]).sum::<f64>();
                let given: f64 = responses.chunks_exact(3).zip(&self.points).map(effect).sum();
                self.targets.push(target - point.start[row] + given);
            }
        }
    }

    fn select_active_rows(&mut self, rows: &ContactJacobian, contacts: &[ContactPoint]) {
        self.active.clear();
        for (i, &p) in self.points.iter().enumerate().filter(|(i, _)| self.presses[*i]) {
            let (point, contact) = (&rows.points[p], &contacts[p]);
            self.active.push(3 * i);
            if contact.friction > 0.0 && point.tangents[0] + point.tangents[2] > 0.0 {
                self.active.extend([3 * i + 1, 3 * i + 2]);
            }
        }
    }

    /// Finds the impulses of the active rows, without weights if the iteration does not converge with them; returns false
    /// if there are none.
    fn find_impulses(&mut self, tolerance: f64) -> bool {
        if self.factorize() && self.iterate(tolerance) {
            return true;
        }
        let weighted = self.weights.iter().any(|weight| *weight != 1.0);
        self.weights.fill(1.0);
        weighted && self.factorize() && self.iterate(tolerance)
    }

    /// Factorises the active rows; returns false if a pivot is not positive.
    fn factorize(&mut self) -> bool {
        let n = self.active.len();
        let greatest = self.active.iter().map(|i| self.coupling.row(*i)[*i]).fold(0.0, f64::max);
        self.factor.clear();
        self.factor.resize(n * n, 0.0);
        for r in 0..n {
            let responses = self.coupling.row(self.active[r]);
            let (above, row) = self.factor.split_at_mut(r * n);
            for c in 0..r {
                let other = &above[c * n..][..=c];
                let sum = dot_slices(&row[..c], other);
                row[c] = (responses[self.active[c]] - sum) / other[c];
            }
            let sum = dot_slices(&row[..r], &row[..r]);
            let pivot = responses[self.active[r]] + REGULARIZATION * greatest * self.weights[self.active[r]] - sum;
            if pivot.is_nan() || pivot <= 0.0 {
                return false;
            }
            row[r] = pivot.sqrt();
        }
        true
    }

    /// Finds the impulses of the active rows; returns false if they do not reach the tolerance.
    fn iterate(&mut self, tolerance: f64) -> bool {
        let n = self.active.len();
        self.found.clear();
        self.found.resize(self.presses.len(), [0.0; 3]);
        for _ in 0..MAX_ITERATIONS {
            let mut step = std::mem::take(&mut self.step);
            step.clear();
            step.extend(self.active.iter().map(|i| self.residual(*i)));
            self.step = step;
            if self.step.iter().all(|missing| missing.abs() <= tolerance) {
                return true;
            }
            for r in 0..n {
                let row = &self.factor[r * n..][..=r];
                let sum = dot_slices(&row[..r], &self.step);
                self.step[r] = (self.step[r] - sum) / row[r];
            }
            for r in (0..n).rev() {
                let own = self.step[r] / self.factor[r * n + r];
                self.step[r] = own;
                for c in 0..r {
                    self.step[c] -= self.factor[r * n + c] * own;
                }
            }
            for (i, step) in self.active.iter().zip(&self.step) {
                self.found[i / 3][i % 3] += step;
            }
        }
        self.active.iter().all(|i| self.residual(*i).abs() <= tolerance)
    }

    /// Returns the target velocity of a row minus its velocity, m/s.
    fn residual(&self, row: usize) -> f64 {
        self.targets[row] - dot_slices(self.coupling.row(row), self.found.as_flattened())
    }

    /// Releases contacts that pull, and adds those that would be penetrated; returns whether any has changed.
    fn update_pressing(&mut self, tolerance: f64) -> bool {
        let mut changed = false;
        for i in 0..self.presses.len() {
            let wrong = match self.presses[i] {
                true => self.found[i][0] < 0.0,
                false => self.residual(3 * i) > tolerance,
            };
            if wrong {
                self.presses[i] = !self.presses[i];
                changed = true;
            }
        }
        changed
    }

    fn exceeds_friction(&self, contacts: &[ContactPoint]) -> bool {
        let beyond = |(point, l): (&usize, &Vec3)| {
            let bound = contacts[*point].friction * l[0] * (1.0 + FRICTION_TOLERANCE);
            l[1] * l[1] + l[2] * l[2] > bound * bound
        };
        self.points.iter().zip(&self.found).any(beyond)
    }

    /// Weights the friction of each contact by the inverse square of its bound under the impulses in `found`, relative
    /// to the greatest bound.
    fn weigh_friction(&mut self, contacts: &[ContactPoint]) {
        self.weights.clear();
        self.weights.resize(self.targets.len(), 1.0);
        let bound = |(point, l): (&usize, &Vec3)| contacts[*point].friction * l[0];
        let greatest = self.points.iter().zip(&self.found).map(bound).fold(0.0, f64::max);
        if greatest == 0.0 {
            return;
        }
        for (bound, weights) in self.points.iter().zip(&self.found).map(bound).zip(self.weights.chunks_exact_mut(3)) {
            let share = (bound / greatest).max(MIN_BOUND_SHARE);
            weights[1..].fill(1.0 / (share * share));
        }
    }

    fn limit_friction(&mut self, contacts: &[ContactPoint]) -> RestingOutcome {
        let mut outcome = RestingOutcome::Rests;
        for (point, impulse) in self.points.iter().zip(&mut self.found) {
            let bound = contacts[*point].friction * impulse[0];
            let size = (impulse[1] * impulse[1] + impulse[2] * impulse[2]).sqrt();
            if size > bound * (1.0 + FRICTION_TOLERANCE) {
                let share = bound / size;
                (impulse[1], impulse[2]) = (impulse[1] * share, impulse[2] * share);
                outcome = RestingOutcome::Slides;
            }
        }
        outcome
    }

    /// Returns the greatest change of a row's velocity by a change of the impulses from `start`, m/s.
    pub fn greatest_change(&mut self, start: &[Vec3]) -> f64 {
        let before = self.points.iter().flat_map(|p| &start[*p]);
        self.step.clear();
        self.step.extend(self.found.iter().flatten().zip(before).map(|(new, old)| new - old));
        let effect = |row: usize| dot_slices(self.coupling.row(row), &self.step);
        (0..self.targets.len()).map(|row| effect(row).abs()).fold(0.0, f64::max)
    }
}
