//! Motion profiles to a position at rest, or to a velocity, within limits of velocity, acceleration and jerk.

use serde::{Deserialize, Serialize};

/// A profile from 0 to 1 in seven segments of constant jerk.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct UnitProfile {
    jerk: f64,
    /// Duration of a segment with nonzero jerk, s.
    tj: f64,
    /// Duration of the whole acceleration phase, s.
    ta: f64,
    /// Duration of the phase of constant velocity, s.
    tv: f64,
}

impl UnitProfile {
    /// Computes the profile within limits of velocity, acceleration and jerk, which must be positive and are relative
    /// to the length of the path.
    pub(crate) fn new(v: f64, a: f64, j: f64) -> UnitProfile {
        let j = j.min(a * 1e6);
        let tj = if v * j < a * a { (v / j).sqrt() } else { a / j };
        let ta = if v * j < a * a { 2.0 * tj } else { tj + v / a };
        let tv = 1.0 / v - ta;
        if tv >= 0.0 {
            return UnitProfile { jerk: j, tj, ta, tv };
        }
        // The path is too short to reach the maximum velocity.
        let (tj, ta) = if 1.0 >= 2.0 * a * a * a / (j * j) {
            let tj = a / j;
            (tj, tj / 2.0 + (tj * tj / 4.0 + 1.0 / a).sqrt())
        } else {
            let tj = libm::cbrt(0.5 / j);
            (tj, 2.0 * tj)
        };
        UnitProfile { jerk: j, tj, ta, tv: 0.0 }
    }
    /// Returns the duration, s.
    pub(crate) fn duration(&self) -> f64 {
        2.0 * self.ta + self.tv
    }
    /// Returns position, velocity and acceleration at time `t`, s.
    pub(crate) fn at(&self, t: f64) -> [f64; 3] {
        let total = self.duration();
        if t <= 0.0 {
            return [0.0; 3];
        }
        if t >= total {
            return [1.0, 0.0, 0.0];
        }
        let top = self.jerk * self.tj * (self.ta - self.tj);
        if t <= self.ta {
            self.accelerating(t)
        } else if t <= self.ta + self.tv {
            [top * self.ta / 2.0 + top * (t - self.ta), top, 0.0]
        } else {
            let [s, v, a] = self.accelerating(total - t);
            [1.0 - s, v, -a]
        }
    }
    /// Returns position, velocity and acceleration at time `t` (s) of the acceleration phase.
    fn accelerating(&self, t: f64) -> [f64; 3] {
        let (j, tj, ta) = (self.jerk, self.tj, self.ta);
        let a = j * tj;
        let top = a * (ta - tj);
        if t <= tj {
            [j * t * t * t / 6.0, j * t * t / 2.0, j * t]
        } else if t <= ta - tj {
            [a / 6.0 * (3.0 * t * t - 3.0 * tj * t + tj * tj), a * (t - tj / 2.0), a]
        } else {
            let u = ta - t;
            [top * ta / 2.0 - top * u + j * u * u * u / 6.0, top - j * u * u / 2.0, j * u]
        }
    }
}

/// The motion of several coordinates to a target position or velocity.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct MotionProfile {
    start: Vec<f64>,
    velocity: Vec<f64>,
    accel: Vec<f64>,
    /// The target position, or the target velocity.
    target: Vec<f64>,
    brake: f64,
    kind: ProfileKind,
    time: f64,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
enum ProfileKind {
    Position(Option<UnitProfile>),
    Velocity(Vec<Option<UnitProfile>>),
}

/// Position, velocity and acceleration of each coordinate.
pub(crate) type MotionState = [Vec<f64>; 3];

/// Value of a limit that is not specified.
const NO_LIMIT: f64 = 1e9;

fn limit_or_none(list: &[f64], i: usize) -> f64 {
    list.get(i).copied().filter(|x| x.is_finite() && *x > 0.0).unwrap_or(NO_LIMIT)
}

impl MotionProfile {
    /// Computes a motion to a position at rest: all coordinates first decelerate to rest, then move synchronously.
    pub(crate) fn to(start: &[f64], velocity: &[f64], target: &[f64], limits: [&[f64]; 3]) -> MotionProfile {
        let n = start.len();
        let velocity: Vec<f64> = (0..n).map(|i| velocity.get(i).copied().unwrap_or(0.0)).collect();
        let accel: Vec<f64> = (0..n).map(|i| limit_or_none(limits[1], i)).collect();
        let brake = (0..n).map(|i| velocity[i].abs() / accel[i]).fold(0.0, f64::max);
        let mut p = MotionProfile {
            start: start.to_vec(),
            velocity,
            accel,
            target: (0..n).map(|i| target.get(i).copied().unwrap_or(start[i])).collect(),
            brake,
            kind: ProfileKind::Position(None),
            time: 0.0,
        };
        let [stopped, ..] = p.braking(brake);
        let way = |i: usize| (p.target[i] - stopped[i]).abs();
        let least = |k: usize| {
            (0..n).filter(|i| way(*i) > 1e-12).map(|i| limit_or_none(limits[k], i) / way(i)).reduce(f64::min)
        };
        p.kind = ProfileKind::Position(match (least(0), least(1), least(2)) {
            (Some(v), Some(a), Some(j)) => Some(UnitProfile::new(v, a, j)),
            _ => None,
        });
        p
    }
    /// Computes a motion to a velocity, each coordinate independently.
    pub(crate) fn to_velocity(
        start: &[f64],
        velocity: &[f64],
        target: &[f64],
        accel: &[f64],
        jerk: &[f64],
    ) -> MotionProfile {
        let n = start.len();
        let velocity: Vec<f64> = (0..n).map(|i| velocity.get(i).copied().unwrap_or(0.0)).collect();
        let target: Vec<f64> = (0..n).map(|i| target.get(i).copied().unwrap_or(0.0)).collect();
        let unit = |i: usize| {
            let change = (target[i] - velocity[i]).abs();
            (change > 1e-12)
                .then(|| UnitProfile::new(limit_or_none(accel, i) / change, limit_or_none(jerk, i) / change, NO_LIMIT))
        };
        let units = (0..n).map(unit).collect();
        MotionProfile {
            start: start.to_vec(),
            velocity,
            accel: Vec::new(),
            target,
            brake: 0.0,
            kind: ProfileKind::Velocity(units),
            time: 0.0,
        }
    }
    /// Returns the duration, s.
    pub(crate) fn duration(&self) -> f64 {
        match &self.kind {
            ProfileKind::Position(u) => self.brake + u.map_or(0.0, |u| u.duration()),
            ProfileKind::Velocity(all) => all.iter().flatten().map(UnitProfile::duration).fold(0.0, f64::max),
        }
    }
    fn braking(&self, t: f64) -> MotionState {
        let mut out: MotionState = [vec![], vec![], vec![]];
        for (i, v) in self.velocity.iter().enumerate() {
            let a = -v.signum() * self.accel[i];
            let stop = v.abs() / self.accel[i];
            let u = t.min(stop);
            out[0].push(self.start[i] + v * u + a * u * u / 2.0);
            out[1].push(if t >= stop { 0.0 } else { v + a * u });
            out[2].push(if t >= stop { 0.0 } else { a });
        }
        out
    }
    /// Returns the state at a time since the start.
    pub(crate) fn at(&self, t: f64) -> MotionState {
        match &self.kind {
            ProfileKind::Position(_) if t < self.brake => self.braking(t),
            ProfileKind::Position(unit) => {
                let [from, ..] = self.braking(self.brake);
                let [s, v, a] = unit.map_or([1.0, 0.0, 0.0], |u| u.at(t - self.brake));
                let way: Vec<f64> = self.target.iter().zip(&from).map(|(to, from)| to - from).collect();
                // Return the target itself at the end, which avoids rounding errors.
                let at = |i: usize| if s >= 1.0 { self.target[i] } else { from[i] + way[i] * s };
                [
                    (0..from.len()).map(at).collect(),
                    way.iter().map(|w| w * v).collect(),
                    way.iter().map(|w| w * a).collect(),
                ]
            }
            ProfileKind::Velocity(units) => {
                let mut out: MotionState = [vec![], vec![], vec![]];
                for (i, unit) in units.iter().enumerate() {
                    let change = self.target[i] - self.velocity[i];
                    let at = |t: f64| unit.map_or([1.0, 0.0, 0.0], |u| u.at(t));
                    // Simpson's rule is exact within the cubic segments, and sufficiently accurate at their boundaries.
                    const INTERVALS: usize = 64;
                    let h = t / INTERVALS as f64;
                    let weight = |k: usize| {
                        if k == 0 || k == INTERVALS {
                            1.0
                        } else if k % 2 == 1 {
                            4.0
                        } else {
                            2.0
                        }
                    };
                    let area: f64 = (0..=INTERVALS).map(|k| weight(k) * at(h * k as f64)[0]).sum::<f64>() * h / 3.0;
                    let [s, v, _] = at(t);
                    out[0].push(self.start[i] + self.velocity[i] * t + change * area);
                    out[1].push(self.velocity[i] + change * s);
                    out[2].push(change * v);
                }
                out
            }
        }
    }
    /// Advances the profile by `dt`, s. Returns whether the target has been reached, the state, and the unused part of
    /// `dt`, s.
    pub(crate) fn step(&mut self, dt: f64) -> (bool, MotionState, f64) {
        self.time += dt;
        let end = self.duration();
        let over = self.time - end;
        // A target velocity is maintained after it has been reached, so the time of such a profile is not clamped.
        let at = if matches!(self.kind, ProfileKind::Position(_)) { self.time.min(end) } else { self.time };
        (over >= -1e-9, self.at(if (-1e-9..0.0).contains(&over) { end } else { at }), over.max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn duration_of_a_long_motion_equals_the_closed_form() {
        // Length 1, v 0.5, a 1, j 10: tj = 0.1, ta = 0.1 + 0.5 = 0.6, T = 1 / 0.5 + ta.
        let u = UnitProfile::new(0.5, 1.0, 10.0);
        assert!((u.duration() - 2.6).abs() < 1e-12);
        assert!((u.at(1.3)[0] - 0.5).abs() < 1e-12, "half of the distance at half of the time");
        assert!((u.at(1.3)[1] - 0.5).abs() < 1e-12);
    }

    #[test]
    fn profile_is_smooth_and_within_its_limits() {
        for (v, a, j) in [(0.5, 1.0, 10.0), (5.0, 1.0, 10.0), (5.0, 50.0, 10.0), (0.1, 9.0, 1.0)] {
            let u = UnitProfile::new(v, a, j);
            let mut last = u.at(0.0);
            let h = u.duration() / 1000.0;
            for k in 1..=1000 {
                let now = u.at(h * f64::from(k));
                assert!(now[1] <= v + 1e-9 && now[2].abs() <= a + 1e-9, "{v} {a} {j}");
                assert!((now[0] - last[0] - (now[1] + last[1]) / 2.0 * h).abs() < 1e-5);
                assert!((now[2] - last[2]).abs() <= j * h + 1e-9);
                last = now;
            }
            assert!((last[0] - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn initial_velocity_is_braked_before_the_target_is_reached() {
        let mut p = MotionProfile::to(&[0.0, 1.0], &[0.2, 0.0], &[1.0, 0.0], [&[0.5, 0.5], &[1.0, 1.0], &[10.0, 10.0]]);
        let mut done = false;
        for _ in 0..200 {
            let (arrived, [at, v, _], _) = p.step(0.05);
            done = arrived;
            if arrived {
                assert_eq!((at, v), (vec![1.0, 0.0], vec![0.0, 0.0]));
                break;
            }
        }
        assert!(done);
    }

    #[test]
    fn target_velocity_is_reached() {
        let p = MotionProfile::to_velocity(&[0.0], &[0.0], &[1.0], &[1.0], &[1e9]);
        let [at, v, _] = p.at(p.duration());
        // With constant acceleration: t = 1 s, distance 0.5 m.
        assert!((p.duration() - 1.0).abs() < 1e-3 && (v[0] - 1.0).abs() < 1e-9 && (at[0] - 0.5).abs() < 1e-2);
    }
}
