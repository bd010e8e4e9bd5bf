//! Shortest paths of cars in the plane: of Dubins, forward only, and of Reeds and Shepp, in both directions.
//!
//! The words and their lengths are those of A. M. Shkel and V. Lumelsky, "Classification of the Dubins set" (2001), and of
//! J. A. Reeds and L. A. Shepp, "Optimal paths for a car that goes both forwards and backwards" (1990).

use std::f64::consts::{FRAC_PI_2, PI};

use libm::{acos, asin, atan2, cos, hypot, sin, sqrt};

/// A full turn, rad.
const TURN: f64 = 2.0 * PI;
/// Error up to which a word counts as a path to its end, in radii and rad.
const MAX_MISS: f64 = 1e-6;
/// Angles and lengths up to this count as 0.
const ROUNDING: f64 = 1e-9;

/// How a car may move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CarMotion {
    /// Forward only. The path back is another one.
    Dubins,
    /// Forward only, or backward only: the shorter one of the path and of the path back, driven backward.
    SymmetricDubins,
    /// Forward and backward.
    ReedsShepp,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
enum Steer {
    Left,
    #[default]
    Straight,
    Right,
}
use Steer::{Left, Right, Straight};

/// A path of up to five arcs and lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CarPath {
    /// Direction and signed length of each piece, in radii; negative: backward.
    pieces: [(Steer, f64); 5],
    radius: f64,
}

impl CarPath {
    /// Returns the shortest path between two poses x, y (m) and yaw (rad) of a car with a turning radius, m.
    pub fn shortest(motion: CarMotion, radius: f64, from: [f64; 3], to: [f64; 3]) -> CarPath {
        let unit = match motion {
            CarMotion::Dubins => dubins(relative(radius, from, to)),
            CarMotion::ReedsShepp => reeds_shepp(relative(radius, from, to)),
            CarMotion::SymmetricDubins => {
                let (there, back) = (dubins(relative(radius, from, to)), dubins(relative(radius, to, from)));
                if length(&back) < length(&there) { reversed(&back) } else { there }
            }
        };
        CarPath { pieces: unit, radius }
    }

    /// Returns the length, m.
    pub fn length(&self) -> f64 {
        length(&self.pieces) * self.radius
    }

    /// Returns the pose at a share of the path, from 0 to 1, which begins at a pose.
    pub fn at(&self, from: [f64; 3], share: f64) -> [f64; 3] {
        let mut left = length(&self.pieces) * share.clamp(0.0, 1.0);
        let mut pose = [0.0, 0.0, from[2]];
        for (steer, piece) in self.pieces {
            let part = left.min(piece.abs());
            pose = driven(pose, steer, part.copysign(piece));
            left -= part;
            if left <= 0.0 {
                break;
            }
        }
        [from[0] + pose[0] * self.radius, from[1] + pose[1] * self.radius, wrapped(pose[2])]
    }
}

fn length(pieces: &[(Steer, f64); 5]) -> f64 {
    pieces.iter().map(|(_, l)| l.abs()).sum()
}

/// Returns the path driven backward from its end.
fn reversed(pieces: &[(Steer, f64); 5]) -> [(Steer, f64); 5] {
    let mut back = *pieces;
    back.reverse();
    back.map(|(steer, l)| (steer, -l))
}

/// Returns the target as seen from the start, in radii.
fn relative(radius: f64, from: [f64; 3], to: [f64; 3]) -> [f64; 3] {
    let (dx, dy) = ((to[0] - from[0]) / radius, (to[1] - from[1]) / radius);
    let (s, c) = (sin(from[2]), cos(from[2]));
    [c * dx + s * dy, c * dy - s * dx, wrapped(to[2] - from[2])]
}

fn driven([x, y, yaw]: [f64; 3], steer: Steer, l: f64) -> [f64; 3] {
    match steer {
        Straight => [x + l * cos(yaw), y + l * sin(yaw), yaw],
        Left => [x + sin(yaw + l) - sin(yaw), y + cos(yaw) - cos(yaw + l), yaw + l],
        Right => [x + sin(yaw) - sin(yaw - l), y + cos(yaw - l) - cos(yaw), yaw - l],
    }
}

/// Returns an angle from -π to π.
pub(crate) fn wrapped(angle: f64) -> f64 {
    let rest = angle - TURN * libm::floor(angle / TURN + 0.5);
    if rest.is_finite() { rest } else { 0.0 }
}

fn positive(angle: f64) -> f64 {
    let rest = angle - TURN * libm::floor(angle / TURN);
    // Rounding makes a full turn of what should be none.
    if TURN - rest < 1e-9 { 0.0 } else { rest }
}

/// Collects words, and retains the shortest that leads to the target.
struct Best {
    target: [f64; 3],
    pieces: [(Steer, f64); 5],
    length: f64,
}

impl Best {
    fn new(target: [f64; 3]) -> Self {
        Best { target, pieces: [(Straight, f64::INFINITY); 5], length: f64::INFINITY }
    }
    fn offer(&mut self, word: &[(Steer, f64)]) {
        let total: f64 = word.iter().map(|(_, l)| l.abs()).sum();
        if !total.is_finite() || total >= self.length {
            return;
        }
        let end = word.iter().fold([0.0; 3], |pose, (steer, l)| driven(pose, *steer, *l));
        let miss = (end[0] - self.target[0]).abs().max((end[1] - self.target[1]).abs());
        if miss.max(wrapped(end[2] - self.target[2]).abs()) > MAX_MISS * (1.0 + total) {
            return;
        }
        self.pieces = [(Straight, 0.0); 5];
        self.pieces[..word.len()].copy_from_slice(word);
        self.length = total;
    }
}

fn dubins(target: [f64; 3]) -> [(Steer, f64); 5] {
    let (d, along) = (hypot(target[0], target[1]), atan2(target[1], target[0]));
    let (a, b) = (positive(-along), positive(target[2] - along));
    let (sa, sb, ca, cb, cab) = (sin(a), sin(b), cos(a), cos(b), cos(a - b));
    let mut best = Best::new(target);
    let root = |square: f64| (square >= -1e-12).then(|| sqrt(square.max(0.0)));
    if let Some(p) = root(2.0 + d * d - 2.0 * cab + 2.0 * d * (sa - sb)) {
        let th = atan2(cb - ca, d + sa - sb);
        best.offer(&[(Left, positive(th - a)), (Straight, p), (Left, positive(b - th))]);
    }
    if let Some(p) = root(2.0 + d * d - 2.0 * cab + 2.0 * d * (sb - sa)) {
        let th = atan2(ca - cb, d - sa + sb);
        best.offer(&[(Right, positive(a - th)), (Straight, p), (Right, positive(th - b))]);
    }
    if let Some(p) = root(d * d - 2.0 + 2.0 * cab + 2.0 * d * (sa + sb)) {
        let th = atan2(-ca - cb, d + sa + sb) - atan2(-2.0, p);
        best.offer(&[(Left, positive(th - a)), (Straight, p), (Right, positive(th - b))]);
    }
    if let Some(p) = root(d * d - 2.0 + 2.0 * cab - 2.0 * d * (sa + sb)) {
        let th = atan2(ca + cb, d - sa - sb) - atan2(2.0, p);
        best.offer(&[(Right, positive(a - th)), (Straight, p), (Left, positive(b - th))]);
    }
    let cosine = (6.0 - d * d + 2.0 * cab + 2.0 * d * (sa - sb)) / 8.0;
    if cosine.abs() <= 1.0 {
        let p = positive(-acos(cosine));
        let t = positive(a - atan2(ca - cb, d - sa + sb) + 0.5 * p);
        best.offer(&[(Right, t), (Left, p), (Right, positive(a - b - t + p))]);
    }
    let cosine = (6.0 - d * d + 2.0 * cab + 2.0 * d * (sb - sa)) / 8.0;
    if cosine.abs() <= 1.0 {
        let p = positive(-acos(cosine));
        let t = positive(-a - atan2(ca - cb, d + sa - sb) + 0.5 * p);
        best.offer(&[(Left, t), (Right, p), (Left, positive(b - a - t + p))]);
    }
    best.pieces
}

/// A word for one of the four symmetries, or `None`.
type Word = Option<[(Steer, f64); 5]>;
const NONE: (Steer, f64) = (Straight, 0.0);

fn reeds_shepp(target: [f64; 3]) -> [(Steer, f64); 5] {
    let mut best = Best::new(target);
    let words: [fn(f64, f64, f64) -> Word; 8] = [lsl, lsr, lrl, lrlr_outer, lrlr_inner, lrsl, lrsr, lrslr];
    let [x, y, yaw] = target;
    // The same target as seen from the end of the path, for the words in reverse order.
    let (xb, yb) = (x * cos(yaw) + y * sin(yaw), x * sin(yaw) - y * cos(yaw));
    for word in words {
        for (from_end, x, y) in [(false, x, y), (true, xb, yb)] {
            for flip in [1.0, -1.0] {
                for mirror in [1.0, -1.0] {
                    let Some(mut found) = word(flip * x, mirror * y, flip * mirror * yaw) else { continue };
                    for (steer, l) in &mut found {
                        *l *= flip;
                        *steer = match *steer {
                            Left if mirror < 0.0 => Right,
                            Right if mirror < 0.0 => Left,
                            other => other,
                        };
                    }
                    if from_end {
                        found.reverse();
                    }
                    best.offer(&found);
                }
            }
        }
    }
    best.pieces
}

fn lsl(x: f64, y: f64, yaw: f64) -> Word {
    let (x, y) = (x - sin(yaw), y - 1.0 + cos(yaw));
    let t = atan2(y, x);
    let v = wrapped(yaw - t);
    (t >= -ROUNDING && v >= -ROUNDING).then(|| [(Left, t), (Straight, hypot(x, y)), (Left, v), NONE, NONE])
}
fn lsr(x: f64, y: f64, yaw: f64) -> Word {
    let (x, y) = (x + sin(yaw), y - 1.0 - cos(yaw));
    let square = x * x + y * y;
    if square < 4.0 {
        return None;
    }
    let u = sqrt(square - 4.0);
    let t = wrapped(atan2(y, x) + atan2(2.0, u));
    let v = wrapped(t - yaw);
    (t >= -ROUNDING && v >= -ROUNDING).then_some([(Left, t), (Straight, u), (Right, v), NONE, NONE])
}
fn lrl(x: f64, y: f64, yaw: f64) -> Word {
    let (x, y) = (x - sin(yaw), y - 1.0 + cos(yaw));
    let chord = hypot(x, y);
    if chord > 4.0 {
        return None;
    }
    let u = -2.0 * asin(0.25 * chord);
    let t = wrapped(atan2(y, x) + 0.5 * u + PI);
    (t >= -ROUNDING).then(|| [(Left, t), (Right, u), (Left, wrapped(yaw - t + u)), NONE, NONE])
}

/// Returns the first and the last angle of words of four arcs.
fn outer_angles(u: f64, v: f64, x: f64, y: f64, yaw: f64) -> (f64, f64) {
    let delta = wrapped(u - v);
    let (a, b) = (sin(u) - sin(delta), cos(u) - cos(delta) - 1.0);
    let first = atan2(y * a - x * b, x * a + y * b);
    let is_far = 2.0 * (cos(delta) - cos(v) - cos(u)) + 3.0 < 0.0;
    let t = wrapped(if is_far { first + PI } else { first });
    (t, wrapped(t - u + v - yaw))
}
fn lrlr_outer(x: f64, y: f64, yaw: f64) -> Word {
    let (x, y) = (x + sin(yaw), y - 1.0 - cos(yaw));
    let rho = 0.25 * (2.0 + hypot(x, y));
    if rho > 1.0 {
        return None;
    }
    let u = acos(rho);
    let (t, v) = outer_angles(u, -u, x, y, yaw);
    (t >= -ROUNDING && v <= ROUNDING).then_some([(Left, t), (Right, u), (Left, -u), (Right, v), NONE])
}
fn lrlr_inner(x: f64, y: f64, yaw: f64) -> Word {
    let (x, y) = (x + sin(yaw), y - 1.0 - cos(yaw));
    let rho = (20.0 - x * x - y * y) / 16.0;
    if !(0.0..=1.0).contains(&rho) {
        return None;
    }
    let u = -acos(rho);
    let (t, v) = outer_angles(u, u, x, y, yaw);
    (t >= -ROUNDING && v >= -ROUNDING).then_some([(Left, t), (Right, u), (Left, u), (Right, v), NONE])
}
fn lrsl(x: f64, y: f64, yaw: f64) -> Word {
    let (x, y) = (x - sin(yaw), y - 1.0 + cos(yaw));
    let rho = hypot(x, y);
    if rho < 2.0 {
        return None;
    }
    let r = sqrt(rho * rho - 4.0);
    let t = wrapped(atan2(y, x) + atan2(r, -2.0));
    let v = wrapped(yaw - FRAC_PI_2 - t);
    (t >= -ROUNDING && r >= 2.0 - ROUNDING && v <= ROUNDING).then_some([
        (Left, t),
        (Right, -FRAC_PI_2),
        (Straight, 2.0 - r),
        (Left, v),
        NONE,
    ])
}
fn lrsr(x: f64, y: f64, yaw: f64) -> Word {
    let (x, y) = (x + sin(yaw), y - 1.0 - cos(yaw));
    let (rho, t) = (hypot(x, y), atan2(x, -y));
    let v = wrapped(t + FRAC_PI_2 - yaw);
    (rho >= 2.0 && t >= -ROUNDING && v <= ROUNDING).then_some([
        (Left, t),
        (Right, -FRAC_PI_2),
        (Straight, 2.0 - rho),
        (Right, v),
        NONE,
    ])
}
fn lrslr(x: f64, y: f64, yaw: f64) -> Word {
    let (x, y) = (x + sin(yaw), y - 1.0 - cos(yaw));
    let square = x * x + y * y;
    if square < 4.0 {
        return None;
    }
    let u = 4.0 - sqrt(square - 4.0);
    let t = wrapped(atan2((4.0 - u) * x - 2.0 * y, -2.0 * x + (u - 4.0) * y));
    let v = wrapped(t - yaw);
    (u <= ROUNDING && t >= -ROUNDING && v >= -ROUNDING).then_some([
        (Left, t),
        (Right, -FRAC_PI_2),
        (Straight, u),
        (Left, -FRAC_PI_2),
        (Right, v),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn pose(random: &mut Random) -> [f64; 3] {
        [random.between(-4.0, 4.0), random.between(-4.0, 4.0), random.between(-PI, PI)]
    }

    #[test]
    fn paths_end_at_their_targets() {
        let mut random = Random::new(3);
        for motion in [CarMotion::Dubins, CarMotion::SymmetricDubins, CarMotion::ReedsShepp] {
            for _ in 0..2000 {
                let (from, to, radius) = (pose(&mut random), pose(&mut random), random.between(0.2, 3.0));
                let path = CarPath::shortest(motion, radius, from, to);
                let end = path.at(from, 1.0);
                assert!(path.length().is_finite(), "{motion:?} {from:?} {to:?}");
                let miss = hypot(end[0] - to[0], end[1] - to[1]).max(wrapped(end[2] - to[2]).abs());
                assert!(miss < 1e-4, "{motion:?} {from:?} {to:?} {end:?}");
            }
        }
    }

    #[test]
    fn backward_paths_are_never_longer_and_symmetric() {
        let mut random = Random::new(4);
        for _ in 0..2000 {
            let (from, to) = (pose(&mut random), pose(&mut random));
            let of = |motion, a, b| CarPath::shortest(motion, 1.0, a, b).length();
            let both = of(CarMotion::ReedsShepp, from, to);
            let symmetric = of(CarMotion::SymmetricDubins, from, to);
            assert!(both <= symmetric + 1e-9 && symmetric <= of(CarMotion::Dubins, from, to) + 1e-9);
            assert!((both - of(CarMotion::ReedsShepp, to, from)).abs() < 1e-6);
            assert!((symmetric - of(CarMotion::SymmetricDubins, to, from)).abs() < 1e-9);
        }
    }

    /// A half turn in place: Dubins' shortest path has the length 7π/3 radii, that of Reeds and Shepp π.
    #[test]
    fn turning_around_has_the_known_lengths() {
        let of = |motion| CarPath::shortest(motion, 2.0, [1.0, 1.0, 0.3], [1.0, 1.0, 0.3 + PI]).length();
        assert!((of(CarMotion::Dubins) - 2.0 * 7.0 * PI / 3.0).abs() < 1e-6);
        assert!((of(CarMotion::ReedsShepp) - 2.0 * PI).abs() < 1e-6);
    }

    /// 3 radii ahead on a straight line, and beside: a line, and two arcs of acos(1 - 1/2) = π/3 for an offset of one
    /// radius at a distance of √3 radii.
    #[test]
    fn simple_paths_have_the_known_lengths() {
        for motion in [CarMotion::Dubins, CarMotion::ReedsShepp] {
            let ahead = CarPath::shortest(motion, 1.0, [0.0; 3], [3.0, 0.0, 0.0]).length();
            assert!((ahead - 3.0).abs() < 1e-9);
            let beside = CarPath::shortest(motion, 1.0, [0.0; 3], [libm::sqrt(3.0), 1.0, 0.0]).length();
            assert!((beside - 2.0 * PI / 3.0).abs() < 1e-6);
        }
        let behind = CarPath::shortest(CarMotion::ReedsShepp, 1.0, [0.0; 3], [-3.0, 0.0, 0.0]).length();
        assert!((behind - 3.0).abs() < 1e-9);
    }
}
