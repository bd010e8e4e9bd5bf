//! The motion of a coordinate through states at given times.

use crate::state::State;

/// How a coordinate moves between two waypoints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// At a constant velocity.
    Linear,
    /// By a polynomial of degree 3 with the velocities of both waypoints.
    Cubic,
    /// By a polynomial of degree 5 with the velocities and accelerations of both waypoints.
    Quintic,
}

/// States to be reached at given times.
#[derive(Debug, Clone, PartialEq)]
pub struct Waypoints {
    times: Vec<f64>,
    states: Vec<State>,
    interpolation: Interpolation,
}

impl Waypoints {
    /// Returns the motion through states at times, s. Returns `None` if there are none, if their numbers differ, if the
    /// times do not ascend, or if a number is not finite.
    pub fn new(times: Vec<f64>, states: Vec<State>, interpolation: Interpolation) -> Option<Waypoints> {
        let ascending = times.windows(2).all(|w| w[0] < w[1]);
        let finite = times.iter().all(|t| t.is_finite())
            && states.iter().all(|s| [s.position, s.velocity, s.acceleration].iter().all(|x| x.is_finite()));
        let valid = !times.is_empty() && times.len() == states.len() && ascending && finite;
        valid.then_some(Waypoints { times, states, interpolation })
    }

    /// Returns the time of the last waypoint, s.
    pub fn end(&self) -> f64 {
        self.times[self.times.len() - 1]
    }

    /// Returns the state at a time, s. Before the first waypoint the coordinate is at rest there, after the last one
    /// likewise.
    pub fn at(&self, t: f64) -> State {
        let last = self.times.len() - 1;
        if t <= self.times[0] || t >= self.times[last] {
            return State::at(self.states[if t <= self.times[0] { 0 } else { last }].position);
        }
        let k = self.times.partition_point(|time| *time <= t) - 1;
        let whole = self.times[k + 1] - self.times[k];
        let u = (t - self.times[k]) / whole;
        let (a, b) = (self.states[k], self.states[k + 1]);
        let way = b.position - a.position;
        // Velocities and accelerations by the share u of the time between the waypoints.
        let (va, vb) = (a.velocity * whole, b.velocity * whole);
        let (aa, ab) = (a.acceleration * whole * whole, b.acceleration * whole * whole);
        let c = match self.interpolation {
            Interpolation::Linear => [way, 0.0, 0.0, 0.0, 0.0],
            Interpolation::Cubic => [va, 3.0 * way - 2.0 * va - vb, va + vb - 2.0 * way, 0.0, 0.0],
            Interpolation::Quintic => [
                va,
                aa / 2.0,
                10.0 * way - 6.0 * va - 4.0 * vb - 1.5 * aa + 0.5 * ab,
                -15.0 * way + 8.0 * va + 7.0 * vb + 1.5 * aa - ab,
                6.0 * way - 3.0 * (va + vb) - 0.5 * (aa - ab),
            ],
        };
        State {
            position: a.position + u * (c[0] + u * (c[1] + u * (c[2] + u * (c[3] + u * c[4])))),
            velocity: (c[0] + u * (2.0 * c[1] + u * (3.0 * c[2] + u * (4.0 * c[3] + u * 5.0 * c[4])))) / whole,
            acceleration: (2.0 * c[1] + u * (6.0 * c[2] + u * (12.0 * c[3] + u * 20.0 * c[4]))) / (whole * whole),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A polynomial of the given degree is reproduced, with its derivatives.
    fn reproduces(interpolation: Interpolation, c: [f64; 6]) {
        let state = |t: f64| State {
            position: (0..6).rev().fold(0.0, |sum, k| sum * t + c[k]),
            velocity: (1..6).rev().fold(0.0, |sum, k| sum * t + k as f64 * c[k]),
            acceleration: (2..6).rev().fold(0.0, |sum, k| sum * t + (k * (k - 1)) as f64 * c[k]),
        };
        let times = vec![-1.0, 0.5, 2.0];
        let waypoints = Waypoints::new(times.clone(), times.into_iter().map(state).collect(), interpolation).unwrap();
        for t in [-0.7, 0.0, 0.6, 1.9] {
            let (a, b) = (waypoints.at(t), state(t));
            for (a, b) in [(a.position, b.position), (a.velocity, b.velocity), (a.acceleration, b.acceleration)] {
                assert!((a - b).abs() < 1e-12, "{interpolation:?} at {t}: {a} {b}");
            }
        }
    }

    #[test]
    fn polynomials_of_the_degree_are_reproduced() {
        reproduces(Interpolation::Linear, [0.3, -0.4, 0.0, 0.0, 0.0, 0.0]);
        reproduces(Interpolation::Cubic, [0.3, -0.4, 0.9, 0.2, 0.0, 0.0]);
        reproduces(Interpolation::Quintic, [0.3, -0.4, 0.9, 0.2, -0.5, 0.1]);
    }

    #[test]
    fn coordinate_rests_before_and_after() {
        let states = vec![State::moving(1.0, 2.0), State::moving(3.0, 4.0)];
        let waypoints = Waypoints::new(vec![1.0, 2.0], states, Interpolation::Cubic).unwrap();
        assert_eq!([0.0, 1.0, 2.0, 9.0].map(|t| waypoints.at(t)), [1.0, 1.0, 3.0, 3.0].map(State::at));
        assert_eq!(Waypoints::new(vec![1.0, 1.0], vec![State::at(0.0); 2], Interpolation::Linear), None);
        assert_eq!(Waypoints::new(vec![1.0], vec![State::at(f64::NAN)], Interpolation::Linear), None);
    }
}
