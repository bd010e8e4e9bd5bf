//! The fastest traversal of a path.
//!
//! The path q(s) is divided into equal parts of its parameter s. With x = (ds/dt)^2 and u = d^2s/dt^2, limits of
//! velocity bound x, limits of acceleration are linear in u and x, and a part changes x by 2 u ds. A pass from the end
//! to the start gives the greatest x from which the path can still be left at rest; a pass forward takes the greatest u.
//! This is TOPP-RA of H. Pham and Q.-C. Pham, "A New Approach to Time-Optimal Path Parameterization Based on
//! Reachability Analysis" (2018), with the greatest x found by bisection, since x = 0 is always feasible.

use crate::{
    spline::{Spline, SplinePoint},
    state::MotionError,
};

/// Limits of a coordinate along a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisBounds {
    /// Least and greatest velocity, below and above 0.
    pub velocity: [f64; 2],
    /// Least and greatest acceleration, below and above 0.
    pub acceleration: [f64; 2],
}

/// The fastest traversal of a path from rest to rest.
#[derive(Debug, Clone)]
pub struct PathTiming {
    /// Parameter, its squared velocity, and time at the ends of the parts.
    parameters: Vec<f64>,
    squares: Vec<f64>,
    times: Vec<f64>,
}

/// Bounds of x where the path stands still, and so no limit applies.
const MAX_SQUARED_VELOCITY: f64 = 1e12;

/// Halvings of the range of x: neighbouring numbers are reached.
const BISECTIONS: usize = 64;

impl PathTiming {
    /// Computes the timing of a path with a number of parts, at least 2; the error of the duration is of the order of a
    /// part. `bounds` has an element for each coordinate.
    ///
    /// # Errors
    ///
    /// Bounds that are not on both sides of 0, or not as many as coordinates; a path that cannot be left.
    pub fn new(path: &Spline, bounds: &[AxisBounds], parts: usize) -> Result<PathTiming, MotionError> {
        for axis in bounds {
            let both_sides =
                |[least, greatest]: [f64; 2]| least < 0.0 && greatest > 0.0 && (greatest - least).is_finite();
            if !both_sides(axis.velocity) {
                return Err(MotionError::Velocity(axis.velocity));
            }
            if !both_sides(axis.acceleration) {
                return Err(MotionError::Acceleration(axis.acceleration));
            }
        }
        if bounds.len() != path.dimension() {
            return Err(MotionError::State);
        }
        let parts = parts.max(2);
        let [first, last] = path.range();
        let ds = (last - first) / parts as f64;
        let parameters: Vec<f64> = (0..=parts).map(|k| if k == parts { last } else { first + ds * k as f64 }).collect();
        let points: Vec<SplinePoint> = parameters.iter().map(|s| path.at(*s)).collect();
        let fastest = |k: usize| greatest_square(&points[k], bounds);
        let part = |k: usize, next: f64| Part { here: &points[k], there: &points[k + 1], bounds, ds, next };
        let mut greatest = vec![0.0; parts + 1];
        for k in (0..parts).rev() {
            greatest[k] = part(k, greatest[k + 1]).greatest_square(fastest(k));
        }
        let mut squares = vec![0.0; parts + 1];
        for k in 0..parts {
            let [least, most] = part(k, greatest[k + 1]).accelerations(squares[k]);
            // Rounding errors can make the interval slightly inverted.
            squares[k + 1] = (squares[k] + 2.0 * ds * most.max(least)).clamp(0.0, greatest[k + 1]);
        }
        let mut times = vec![0.0; parts + 1];
        for k in 0..parts {
            let speeds = squares[k].sqrt() + squares[k + 1].sqrt();
            if speeds <= 0.0 {
                return Err(MotionError::Unsolved);
            }
            times[k + 1] = times[k] + 2.0 * ds / speeds;
        }
        Ok(PathTiming { parameters, squares, times })
    }

    /// Returns the duration, s.
    pub fn duration(&self) -> f64 {
        self.times[self.times.len() - 1]
    }

    /// Returns the parameter of the path at a time, s, which is clamped to the traversal.
    pub fn parameter_at(&self, t: f64) -> f64 {
        let t = t.clamp(0.0, self.duration());
        let k = self.times.partition_point(|time| *time <= t).clamp(1, self.times.len() - 1) - 1;
        let (from, to) = (self.squares[k].sqrt(), self.squares[k + 1].sqrt());
        let (since, whole) = (t - self.times[k], self.times[k + 1] - self.times[k]);
        let s = self.parameters[k] + from * since + (to - from) * since * since / (2.0 * whole);
        s.clamp(self.parameters[k], self.parameters[k + 1])
    }
}

/// Returns the greatest x that the limits of velocity allow.
fn greatest_square(point: &SplinePoint, bounds: &[AxisBounds]) -> f64 {
    point.first.iter().zip(bounds).fold(MAX_SQUARED_VELOCITY, |least, (slope, axis)| {
        let limit = axis.velocity[usize::from(*slope > 0.0)] / slope;
        if *slope == 0.0 { least } else { least.min(limit * limit) }
    })
}

/// A part of the path.
struct Part<'a> {
    here: &'a SplinePoint,
    there: &'a SplinePoint,
    bounds: &'a [AxisBounds],
    ds: f64,
    /// Greatest x at its end.
    next: f64,
}

impl Part<'_> {
    /// Returns the least and the greatest u at an x with which the limits of acceleration hold at both ends, and x at
    /// the end is between 0 and the greatest one; the first exceeds the second if there is none.
    fn accelerations(&self, x: f64) -> [f64; 2] {
        let mut range = [-x / (2.0 * self.ds), (self.next - x) / (2.0 * self.ds)];
        let mut narrow = |slope: f64, rest: f64, [least, greatest]: [f64; 2]| {
            // least <= slope u + rest <= greatest
            if slope != 0.0 {
                let (a, b) = ((least - rest) / slope, (greatest - rest) / slope);
                range = [range[0].max(a.min(b)), range[1].min(a.max(b))];
            } else if rest < least || rest > greatest {
                range = [f64::INFINITY, f64::NEG_INFINITY];
            }
        };
        for (c, axis) in self.bounds.iter().enumerate() {
            narrow(self.here.first[c], self.here.second[c] * x, axis.acceleration);
            let (slope, bend) = (self.there.first[c], self.there.second[c]);
            narrow(slope + 2.0 * self.ds * bend, bend * x, axis.acceleration);
        }
        range
    }

    /// Returns the greatest x at the start of the part, at most `limit`.
    fn greatest_square(&self, limit: f64) -> f64 {
        let feasible = |x: f64| {
            let [least, greatest] = self.accelerations(x);
            least <= greatest
        };
        if feasible(limit) {
            return limit;
        }
        let (mut low, mut high) = (0.0, limit);
        for _ in 0..BISECTIONS {
            let middle = low + (high - low) / 2.0;
            if feasible(middle) { low = middle } else { high = middle }
        }
        low
    }
}
