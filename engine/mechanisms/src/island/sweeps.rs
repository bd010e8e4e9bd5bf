//! Sweeps over all contacts, each of which solves one contact given the impulses of all others.
//!
//! If the responses of all rows to each other are known, because a direct solution was tried first, a sweep updates the
//! velocities of all rows; otherwise it updates those of the joints, from which it computes the velocity of a row.

use nalgebra::Vector3;

use super::{Island, MAX_SWEEPS, MIN_BOUNCE_SPEED, SWEEP_TOLERANCE};
use crate::{contact::ContactPoint, vector::dot};

impl Island {
    /// Sweeps over all contacts until their impulses no longer change, at most [`MAX_SWEEPS`] times; returns the number
    /// of sweeps, and whether any impulse has changed.
    pub(super) fn sweep(&mut self, contacts: &[ContactPoint], h: f64) -> (usize, bool) {
        self.row_velocities.clear();
        if self.resting.covers(&self.rows) {
            for point in &self.rows.points {
                let velocity = |row: usize| point.start[row] + self.rows.velocity_change(point, row);
                self.row_velocities.extend([0, 1, 2].map(velocity));
            }
        }
        for sweep in 1..=MAX_SWEEPS {
            let mut most = 0.0f64;
            for (i, contact) in contacts.iter().enumerate() {
                most = most.max(self.solve_normal(i, contact, h)).max(self.solve_friction(i, contact));
            }
            if most <= SWEEP_TOLERANCE {
                return (sweep, sweep > 1);
            }
        }
        (MAX_SWEEPS, true)
    }

    /// Returns the velocity of a row with the impulses so far, m/s.
    #[inline]
    fn row_velocity(&self, i: usize, row: usize) -> f64 {
        let point = &self.rows.points[i];
        let known = self.row_velocities.get(3 * i + row).copied();
        known.unwrap_or_else(|| point.start[row] + self.rows.velocity_change(point, row))
    }

    /// Applies an impulse along a row to the velocities of the sweeps, N s.
    #[inline]
    fn push_row(&mut self, i: usize, row: usize, impulse: f64) {
        if self.row_velocities.is_empty() {
            self.rows.apply_impulse(i, row, impulse);
            return;
        }
        for (velocity, response) in self.row_velocities.iter_mut().zip(self.resting.responses(3 * i + row)) {
            *velocity += response * impulse;
        }
    }

    /// Computes the normal impulse of a contact, given all other impulses; returns the change of its normal velocity,
    /// m/s.
    fn solve_normal(&mut self, i: usize, contact: &ContactPoint, h: f64) -> f64 {
        let point = &self.rows.points[i];
        if point.normal == 0.0 {
            return 0.0;
        }
        let old = self.impulses[i][0];
        let velocity = self.row_velocity(i, 0);
        let least = point.min_velocity(h);
        let mut new = (old + (least - velocity) / point.normal).max(0.0);
        let fast = contact.impulse == Vector3::zeros() || contact.restitution >= 1.0;
        if contact.restitution > 0.0 && fast && point.approach < -MIN_BOUNCE_SPEED && (new > 0.0 || self.bounces[i]) {
            self.bounces[i] = true;
            new = (old + (-contact.restitution * point.approach - velocity) / point.normal).max(0.0);
        }
        self.impulses[i][0] = new;
        let change = (new - old).abs() * point.normal;
        if change > 0.0 {
            self.push_row(i, 0, new - old);
        }
        change
    }

    /// Computes the friction impulse of a contact, given all other impulses; returns an upper bound on the change of
    /// its tangential velocity, m/s.
    ///
    /// The contact sticks if the impulse that stops its sliding is within the bound. Otherwise a projected gradient
    /// step is done: the impulse is changed against the velocity, then projected onto the circle of the bound. At the
    /// fixed point, the impulse is opposite to the velocity, whatever the inertia.
    fn solve_friction(&mut self, i: usize, contact: &ContactPoint) -> f64 {
        let point = &self.rows.points[i];
        let [a, b, c] = point.tangents;
        let [normal, old1, old2] = self.impulses[i];
        let bound = contact.friction * normal;
        if a + c == 0.0 || (bound == 0.0 && old1 == 0.0 && old2 == 0.0) {
            return 0.0;
        }
        let slide = |row: usize| dot(point.axes[row], contact.slide.into());
        let velocity = |row: usize| self.row_velocity(i, row) - slide(row);
        let (v1, v2) = (velocity(1), velocity(2));
        let determinant = a * c - b * b;
        let mut new = [old1 - (c * v1 - b * v2) / determinant, old2 - (a * v2 - b * v1) / determinant];
        let length = |x: [f64; 2]| (x[0] * x[0] + x[1] * x[1]).sqrt();
        // With this condition, a contact with an immovable tangential direction is not treated as sticking.
        let sticks = length(new) <= bound && determinant > 1e-12 * a * c;
        if !sticks {
            let pace = 1.0 / (a + c);
            new = [old1 - pace * v1, old2 - pace * v2];
            let size = length(new);
            if size > bound {
                new = new.map(|x| x * bound / size);
            }
        }
        (self.impulses[i][1], self.impulses[i][2]) = (new[0], new[1]);
        let change = length([new[0] - old1, new[1] - old2]) * (a + c);
        if change > 0.0 {
            self.push_row(i, 1, new[0] - old1);
            self.push_row(i, 2, new[1] - old2);
        }
        change
    }

    /// Computes in `z` the velocities at which each contact separates with at least its desired speed.
    pub(super) fn solve_separation(&mut self, speeds: &[f64]) {
        self.velocities.clear();
        self.velocities.resize(speeds.len(), 0.0);
        for _ in 0..MAX_SWEEPS {
            let mut most = 0.0f64;
            for (i, speed) in speeds.iter().enumerate() {
                let point = &self.rows.points[i];
                if point.normal == 0.0 || (*speed == 0.0 && self.velocities[i] == 0.0 && point.distance > 0.0) {
                    continue;
                }
                let (old, missing) = (self.velocities[i], speed - self.rows.velocity_change(point, 0));
                let new = (old + missing / point.normal).max(0.0);
                self.velocities[i] = new;
                most = most.max((new - old).abs() * point.normal);
                self.rows.apply_impulse(i, 0, new - old);
            }
            if most <= 1e-9 {
                break;
            }
        }
    }
}
