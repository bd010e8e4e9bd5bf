//! Configurations between those of a path.

use std::f64::consts::TAU;

use crate::kit::{Fail, Result, algebra as al};

/// How a path runs between its configurations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Curve {
    /// On straight lines.
    Linear,
    /// Each inner configuration is the middle control point of a quadratic Bezier curve. `strength`, above 0 and at most
    /// 1, is the share of the halves of the segments before and after it that the curve replaces. If the last
    /// configuration equals the first the path also bends there, unless it is `open`.
    Bezier { strength: f64, open: bool },
}

/// A path as a table of configurations.
pub(super) struct PathTable<'a> {
    path: &'a [f64],
    /// Distance of each configuration along the path, ascending.
    lengths: &'a [f64],
    /// For each element 0: linear, 1: an angle that changes the shorter way, 2: part of a quaternion.
    types: &'a [f64],
    /// Number of elements of a configuration.
    count: usize,
}

impl<'a> PathTable<'a> {
    pub(super) fn new(path: &'a [f64], lengths: &'a [f64], types: &'a [f64]) -> Result<Self> {
        let count = path.len().checked_div(lengths.len()).unwrap_or(0);
        if count == 0 || path.len() != count * lengths.len() {
            return Err(Fail::argument(format!(
                "{} numbers do not form a path of {} configurations",
                path.len(),
                lengths.len()
            )));
        }
        if !lengths.windows(2).all(|w| w[0] <= w[1]) {
            return Err(Fail::argument("the lengths along the path must ascend").help("use sim.getPathLengths"));
        }
        Ok(PathTable { path, lengths, types, count })
    }

    fn config(&self, i: usize) -> &[f64] {
        &self.path[i.min(self.lengths.len() - 1) * self.count..][..self.count]
    }

    /// Returns the configuration at a distance along the path, which is clamped to the path.
    pub(super) fn at(&self, distance: f64, curve: Curve) -> Vec<f64> {
        match curve {
            Curve::Linear => self.on_lines(distance),
            Curve::Bezier { strength, open } => self.on_curve(distance, strength, open),
        }
    }

    fn on_lines(&self, distance: f64) -> Vec<f64> {
        let i = self.lengths.partition_point(|l| *l <= distance).clamp(1, self.lengths.len().max(2) - 1) - 1;
        let (from, to) = (self.lengths[i], self.lengths.get(i + 1).copied().unwrap_or(self.lengths[i]));
        let u = if to > from { ((distance - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        self.between(self.config(i), self.config(i + 1), u)
    }

    fn on_curve(&self, distance: f64, strength: f64, open: bool) -> Vec<f64> {
        let last = self.lengths.len() - 1;
        let (start, total) = (self.lengths[0], self.lengths[last]);
        let distance = distance.clamp(start, total);
        let closed = !open && last > 1 && self.config(0) == self.config(last);
        let half = |i: usize| (self.lengths[i + 1] - self.lengths[i]) / 2.0 * strength;
        // The nearest configuration by segments' middles bends the path, if the distance is within its curve.
        let i = self.lengths.partition_point(|l| *l <= distance).clamp(1, last.max(1)) - 1;
        let middle = (self.lengths[i] + self.lengths[(i + 1).min(last)]) / 2.0;
        let bend = if distance < middle { i } else { (i + 1).min(last) };
        let is_end = bend == 0 || bend == last;
        if is_end && !closed {
            return self.on_lines(distance);
        }
        // At the end of a closed path the curve continues at the beginning.
        let (before, after) = if is_end { (half(last - 1), half(0)) } else { (half(bend - 1), half(bend)) };
        let offset = distance - self.lengths[bend];
        if offset < -before || offset > after || before + after <= 0.0 {
            return self.on_lines(distance);
        }
        let wrapped = |d: f64| {
            let d = if is_end && d < start { d + total - start } else { d };
            self.on_lines(if is_end && d > total { d - total + start } else { d })
        };
        let (from, to) = (wrapped(self.lengths[bend] - before), wrapped(self.lengths[bend] + after));
        let u = (offset + before) / (before + after);
        let handle = self.config(bend);
        self.between(&self.between(&from, handle, u), &self.between(handle, &to, u), u)
    }

    /// Interpolates between two configurations; `u` is from 0 to 1.
    fn between(&self, a: &[f64], b: &[f64], u: f64) -> Vec<f64> {
        let n = self.count;
        let is_angle = |k: usize| self.types.get(k) == Some(&1.0);
        let mut out: Vec<f64> = (0..n)
            .map(
                |k| if is_angle(k) { wrap_angle(a[k] + wrap_angle(b[k] - a[k]) * u) } else { a[k] + (b[k] - a[k]) * u },
            )
            .collect();
        let is_pose = self.types.is_empty() && n == 7;
        let quaternion = if is_pose { Some(3) } else { self.types.iter().position(|t| *t == 2.0) };
        if let Some(q) = quaternion.filter(|q| q + 4 <= n) {
            let rotation = |from: &[f64]| al::pose([0.0; 3], [from[q], from[q + 1], from[q + 2], from[q + 3]]);
            out[q..q + 4].copy_from_slice(&al::rotation(&al::interpolate(&rotation(a), &rotation(b), u)));
        }
        out
    }
}

/// Wraps an angle to -pi..pi.
pub(super) fn wrap_angle(a: f64) -> f64 {
    a - TAU * (a / TAU).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNER: [f64; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0];

    fn near(a: &[f64], b: &[f64]) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?} {b:?}");
    }

    #[test]
    fn corner_is_rounded_by_its_strength() {
        let table = PathTable::new(&CORNER, &[0.0, 1.0, 2.0], &[]).unwrap();
        let at = |d: f64, strength: f64| table.at(d, Curve::Bezier { strength, open: false });
        near(&at(0.75, 1.0), &[0.71875, 0.03125, 0.0]);
        near(&at(1.0, 1.0), &[0.875, 0.125, 0.0]);
        near(&at(1.25, 1.0), &[0.96875, 0.28125, 0.0]);
        near(&at(0.75, 0.5), &[0.75, 0.0, 0.0]);
        near(&at(1.0, 0.5), &[0.9375, 0.0625, 0.0]);
        near(&at(1.25, 0.5), &[1.0, 0.25, 0.0]);
    }

    #[test]
    fn closed_path_bends_where_it_begins() {
        let square = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0];
        let table = PathTable::new(&square, &[0.0, 1.0, 2.0, 3.0, 4.0], &[]).unwrap();
        for d in [0.0, 4.0] {
            near(&table.at(d, Curve::Bezier { strength: 1.0, open: false }), &[0.125, 0.125]);
            near(&table.at(d, Curve::Bezier { strength: 1.0, open: true }), &[0.0, 0.0]);
        }
    }

    #[test]
    fn angles_and_quaternions_turn_the_shorter_way() {
        let table = PathTable::new(&[3.0, -3.0], &[0.0, 1.0], &[1.0]).unwrap();
        assert!((table.at(0.5, Curve::Linear)[0].abs() - std::f64::consts::PI).abs() < 1e-9);
        let s = std::f64::consts::FRAC_1_SQRT_2;
        let turn = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -s, -s];
        let table = PathTable::new(&turn, &[0.0, 1.0], &[2.0; 4]).unwrap();
        let third = table.at(1.0 / 3.0, Curve::Linear);
        let angle = 2.0 * third[2].abs().atan2(third[3].abs());
        assert!((angle - std::f64::consts::PI / 6.0).abs() < 1e-9, "{third:?}");
    }
}
