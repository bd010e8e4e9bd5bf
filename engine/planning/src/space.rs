//! State spaces: what a state consists of, distances, and motions between states.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::{
    curves::{CarMotion, CarPath, wrapped},
    random::Random,
};

/// One part of a state.
#[derive(Debug, Clone, PartialEq)]
pub enum Subspace {
    /// Numbers between bounds, such as positions of joints or coordinates: rad or m. Distance: Euclidean.
    Reals {
        /// Lower bounds.
        low: Vec<f64>,
        /// Upper bounds, as many.
        high: Vec<f64>,
    },
    /// An angle, rad, from -π to π. Distance: the shorter way around.
    Circle,
    /// An orientation: a quaternion x y z w. Distance: half the angle of the rotation between two, at most π/2.
    Rotation,
    /// The pose of a car in the plane: x, y (m) and yaw (rad). Distance: the length of the path that it drives, m.
    Car {
        /// Lower bounds of x and y.
        low: [f64; 2],
        /// Upper bounds of x and y.
        high: [f64; 2],
        /// Turning radius, m.
        radius: f64,
        /// How it may move.
        motion: CarMotion,
    },
}

impl Subspace {
    /// Returns the count of its numbers in a state.
    pub fn dimension(&self) -> usize {
        match self {
            Subspace::Reals { low, .. } => low.len(),
            Subspace::Circle => 1,
            Subspace::Rotation => 4,
            Subspace::Car { .. } => 3,
        }
    }

    fn flaw(&self) -> Option<String> {
        let bounded = |low: &[f64], high: &[f64]| {
            if low.is_empty() {
                return Some("it has no numbers; expected at least one pair of bounds".to_owned());
            }
            if low.len() != high.len() {
                return Some(format!("{} lower and {} upper bounds; expected as many", low.len(), high.len()));
            }
            let flawed = low.iter().zip(high).position(|(l, h)| !(l.is_finite() && h.is_finite() && l <= h))?;
            let (l, h) = (low[flawed], high[flawed]);
            Some(format!("number {} has the bounds {l} and {h}; expected finite ones, the lower first", flawed + 1))
        };
        match self {
            Subspace::Reals { low, high } => bounded(low, high),
            Subspace::Car { radius, .. } if !(radius.is_finite() && *radius > 0.0) => {
                Some(format!("the turning radius is {radius}; expected a length above 0"))
            }
            Subspace::Car { low, high, .. } => bounded(low, high),
            Subspace::Circle | Subspace::Rotation => None,
        }
    }

    /// Returns the largest distance between two states, or an estimate for cars.
    fn extent(&self) -> f64 {
        let diagonal =
            |low: &[f64], high: &[f64]| libm::sqrt(low.iter().zip(high).map(|(l, h)| (h - l) * (h - l)).sum::<f64>());
        match self {
            Subspace::Reals { low, high } => diagonal(low, high),
            Subspace::Circle => PI,
            Subspace::Rotation => FRAC_PI_2,
            Subspace::Car { low, high, .. } => diagonal(low, high) + FRAC_PI_2,
        }
    }

    fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        match self {
            Subspace::Reals { .. } => {
                let mut sum = 0.0;
                for (x, y) in a.iter().zip(b) {
                    sum += (x - y) * (x - y);
                }
                libm::sqrt(sum)
            }
            Subspace::Circle => wrapped(a[0] - b[0]).abs(),
            Subspace::Rotation => libm::acos(dot(a, b).abs().min(1.0)),
            Subspace::Car { radius, motion, .. } => CarPath::shortest(*motion, *radius, pose(a), pose(b)).length(),
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn pose(state: &[f64]) -> [f64; 3] {
    [state[0], state[1], state[2]]
}

/// A part with its weight and its place in a state.
#[derive(Debug, Clone, PartialEq)]
struct Part {
    space: Subspace,
    weight: f64,
    first: usize,
    extent: f64,
}

/// The set of all states of a problem: parts one after another, each with a weight in distances.
///
/// ```
/// use tatu_planning::StateSpace;
///
/// let room = StateSpace::se2([0.0, 0.0], [5.0, 4.0])?;
/// assert_eq!(room.dimension(), 3);
/// let middle = room.motion(&[1.0, 1.0, 3.0], &[2.0, 1.0, -3.0]).at(0.5);
/// assert!((middle[0] - 1.5).abs() < 1e-12 && middle[2].abs() > 3.0);
/// # Ok::<(), tatu_planning::SpaceError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct StateSpace {
    parts: Vec<Part>,
    dimension: usize,
    extent: f64,
}

/// Why there is no such space: a sentence that names the part, what is wrong and what is expected.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SpaceError(pub String);

impl std::fmt::Display for SpaceError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for SpaceError {}

impl StateSpace {
    /// Returns the space of these parts and their weights.
    ///
    /// # Errors
    ///
    /// Fails if there are no parts, if bounds or a radius are not usable, or if a weight is not above 0.
    pub fn new(parts: Vec<(Subspace, f64)>) -> Result<Self, SpaceError> {
        if parts.is_empty() {
            return Err(SpaceError("the state space has no parts; expected at least one".to_owned()));
        }
        let mut space = StateSpace { parts: Vec::new(), dimension: 0, extent: 0.0 };
        for (i, (part, weight)) in parts.into_iter().enumerate() {
            if let Some(flaw) = part.flaw() {
                return Err(SpaceError(format!("part {} of the state space: {flaw}", i + 1)));
            }
            if !(weight.is_finite() && weight > 0.0) {
                let text =
                    format!("part {} of the state space: its weight is {weight}; expected a number above 0", i + 1);
                return Err(SpaceError(text));
            }
            let (first, extent) = (space.dimension, part.extent());
            space.dimension += part.dimension();
            space.extent += weight * extent;
            space.parts.push(Part { space: part, weight, first, extent });
        }
        Ok(space)
    }

    /// Returns the space of numbers between bounds.
    ///
    /// # Errors
    ///
    /// Fails if the bounds are not usable.
    pub fn reals(low: &[f64], high: &[f64]) -> Result<Self, SpaceError> {
        Self::new(vec![(Subspace::Reals { low: low.to_vec(), high: high.to_vec() }, 1.0)])
    }

    /// Returns the space of poses in the plane: x, y, yaw. An angle counts half as much as a length.
    ///
    /// # Errors
    ///
    /// Fails if the bounds are not usable.
    pub fn se2(low: [f64; 2], high: [f64; 2]) -> Result<Self, SpaceError> {
        let place = Subspace::Reals { low: low.to_vec(), high: high.to_vec() };
        Self::new(vec![(place, 1.0), (Subspace::Circle, 0.5)])
    }

    /// Returns the space of poses: x, y, z, and a quaternion x y z w.
    ///
    /// # Errors
    ///
    /// Fails if the bounds are not usable.
    pub fn se3(low: [f64; 3], high: [f64; 3]) -> Result<Self, SpaceError> {
        let place = Subspace::Reals { low: low.to_vec(), high: high.to_vec() };
        Self::new(vec![(place, 1.0), (Subspace::Rotation, 1.0)])
    }

    /// Returns the space of poses of a car.
    ///
    /// # Errors
    ///
    /// Fails if the bounds or the radius are not usable.
    pub fn car(low: [f64; 2], high: [f64; 2], radius: f64, motion: CarMotion) -> Result<Self, SpaceError> {
        Self::new(vec![(Subspace::Car { low, high, radius, motion }, 1.0)])
    }

    /// Returns the count of numbers of a state.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Returns the largest distance between two states, or an estimate for cars.
    pub fn extent(&self) -> f64 {
        self.extent
    }

    /// Returns whether the path back is always the path driven backward.
    pub fn is_symmetric(&self) -> bool {
        !self.parts.iter().any(|p| matches!(p.space, Subspace::Car { motion: CarMotion::Dubins, .. }))
    }

    fn slices<'s>(&self, state: &'s [f64]) -> impl Iterator<Item = (&Part, &'s [f64])> {
        self.parts.iter().map(move |p| (p, &state[p.first..p.first + p.space.dimension()]))
    }

    /// Returns the distance from one state to another: the weighted sum of those of the parts.
    pub fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let mut sum = 0.0;
        for (part, own) in self.slices(a) {
            let other = &b[part.first..part.first + own.len()];
            sum += part.weight * part.space.distance(own, other);
        }
        sum
    }

    /// Returns a lower bound of the distance, at little cost.
    pub(crate) fn least_distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let mut sum = 0.0;
        for (part, own) in self.slices(a) {
            let other = &b[part.first..part.first + own.len()];
            sum += part.weight
                * match part.space {
                    Subspace::Car { .. } => libm::hypot(own[0] - other[0], own[1] - other[1]),
                    _ => part.space.distance(own, other),
                };
        }
        sum
    }

    /// Returns whether distances are costly: those along the paths of cars.
    pub(crate) fn has_cars(&self) -> bool {
        self.parts.iter().any(|p| matches!(p.space, Subspace::Car { .. }))
    }

    /// Returns the number of pieces of a motion of which none is longer, in any part, than a share of its extent.
    pub fn pieces(&self, a: &[f64], b: &[f64], share: f64) -> usize {
        let mut most: f64 = 1.0;
        for (part, own) in self.slices(a) {
            if part.extent > 0.0 {
                let distance = part.space.distance(own, &b[part.first..part.first + own.len()]);
                most = most.max(libm::ceil(distance / (share * part.extent)));
            }
        }
        most.min(1e9) as usize
    }

    /// Returns whether all numbers are within the bounds and all quaternions normalised.
    pub fn is_within(&self, state: &[f64]) -> bool {
        const SLACK: f64 = 1e-9;
        let inside = |x: &[f64], low: &[f64], high: &[f64]| {
            x.iter().zip(low).zip(high).all(|((x, l), h)| *x >= l - SLACK && *x <= h + SLACK)
        };
        state.len() == self.dimension
            && self.slices(state).all(|(part, x)| match &part.space {
                Subspace::Reals { low, high } => inside(x, low, high),
                Subspace::Circle => x[0].abs() <= PI + SLACK,
                Subspace::Rotation => (dot(x, x) - 1.0).abs() < 1e-3,
                Subspace::Car { low, high, .. } => inside(&x[..2], low, high) && x[2].abs() <= PI + SLACK,
            })
    }

    /// Moves a state to the nearest one within the bounds; angles are wrapped, and quaternions normalised.
    pub fn enforce(&self, state: &mut [f64]) {
        for part in &self.parts {
            let x = &mut state[part.first..part.first + part.space.dimension()];
            match &part.space {
                Subspace::Reals { low, high } => clamp(x, low, high),
                Subspace::Circle => x[0] = wrapped(x[0]),
                Subspace::Rotation => normalise(x),
                Subspace::Car { low, high, .. } => {
                    clamp(&mut x[..2], low, high);
                    x[2] = wrapped(x[2]);
                }
            }
        }
    }

    /// Returns a random state.
    pub fn sample(&self, random: &mut Random) -> Vec<f64> {
        let mut state = Vec::with_capacity(self.dimension);
        self.sample_into(random, &mut state);
        state
    }

    /// Replaces a state by a random one.
    pub fn sample_into(&self, random: &mut Random, state: &mut Vec<f64>) {
        state.clear();
        for part in &self.parts {
            match &part.space {
                Subspace::Reals { low, high } => {
                    state.extend(low.iter().zip(high).map(|(l, h)| random.between(*l, *h)));
                }
                Subspace::Circle => state.push(random.between(-PI, PI)),
                Subspace::Rotation => state.extend(random_rotation(random)),
                Subspace::Car { low, high, .. } => {
                    state.extend((0..2).map(|i| random.between(low[i], high[i])));
                    state.push(random.between(-PI, PI));
                }
            }
        }
    }

    /// Returns a random state that is within a distance of another one, except that cars may have to drive further.
    pub fn sample_near(&self, near: &[f64], distance: f64, random: &mut Random) -> Vec<f64> {
        let mut goal = self.sample(random);
        let far = self.straight_distance(near, &goal);
        let share = if far > distance { distance / far * random.unit() } else { random.unit() };
        for (part, own) in self.slices(near) {
            let x = &mut goal[part.first..part.first + own.len()];
            let end = x.to_vec();
            straight(&part.space, own, &end, share, x);
        }
        goal
    }

    fn straight_distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let parts = self.slices(a).map(|(part, x)| {
            let y = &b[part.first..part.first + x.len()];
            part.weight
                * match &part.space {
                    Subspace::Car { .. } => libm::hypot(x[0] - y[0], x[1] - y[1]) + 0.5 * wrapped(x[2] - y[2]).abs(),
                    other => other.distance(x, y),
                }
        });
        parts.sum()
    }

    /// Returns the motion from one state to another.
    pub fn motion<'a>(&'a self, from: &'a [f64], to: &'a [f64]) -> Motion<'a> {
        let car = |(part, x): (&Part, &[f64])| match &part.space {
            Subspace::Car { radius, motion, .. } => {
                Some(CarPath::shortest(*motion, *radius, pose(x), pose(&to[part.first..])))
            }
            _ => None,
        };
        Motion { space: self, from, to, cars: self.slices(from).filter_map(car).collect() }
    }
}

fn clamp(x: &mut [f64], low: &[f64], high: &[f64]) {
    for ((x, l), h) in x.iter_mut().zip(low).zip(high) {
        *x = if x.is_nan() { *l } else { x.clamp(*l, *h) };
    }
}

fn normalise(q: &mut [f64]) {
    let norm = libm::sqrt(dot(q, q));
    if norm > 1e-9 && norm.is_finite() {
        q.iter_mut().for_each(|x| *x /= norm);
    } else {
        q.copy_from_slice(&[0.0, 0.0, 0.0, 1.0]);
    }
}

/// Returns a uniformly distributed rotation (K. Shoemake, "Uniform random rotations", 1992).
fn random_rotation(random: &mut Random) -> [f64; 4] {
    let (u, a, b) = (random.unit(), random.between(0.0, 2.0 * PI), random.between(0.0, 2.0 * PI));
    let (r, s) = (libm::sqrt(1.0 - u), libm::sqrt(u));
    [r * libm::sin(a), r * libm::cos(a), s * libm::sin(b), s * libm::cos(b)]
}

/// Writes the state at a share of the straight way between two.
fn straight(space: &Subspace, a: &[f64], b: &[f64], share: f64, out: &mut [f64]) {
    match space {
        Subspace::Reals { .. } => {
            for ((o, x), y) in out.iter_mut().zip(a).zip(b) {
                *o = x + (y - x) * share;
            }
        }
        Subspace::Circle => out[0] = wrapped(a[0] + wrapped(b[0] - a[0]) * share),
        Subspace::Rotation => {
            let cosine = dot(a, b);
            let angle = libm::acos(cosine.abs().min(1.0));
            let sign = if cosine < 0.0 { -1.0 } else { 1.0 };
            let sine = libm::sin(angle);
            let (ka, kb) = if sine < 1e-9 {
                (1.0 - share, share)
            } else {
                (libm::sin((1.0 - share) * angle) / sine, libm::sin(share * angle) / sine)
            };
            for ((o, x), y) in out.iter_mut().zip(a).zip(b) {
                *o = ka * x + kb * sign * y;
            }
            normalise(out);
        }
        Subspace::Car { .. } => {
            for i in 0..2 {
                out[i] = a[i] + (b[i] - a[i]) * share;
            }
            out[2] = wrapped(a[2] + wrapped(b[2] - a[2]) * share);
        }
    }
}

/// The way from one state to another: a straight line in each part, or the path of a car.
#[derive(Debug, Clone)]
pub struct Motion<'a> {
    space: &'a StateSpace,
    from: &'a [f64],
    to: &'a [f64],
    cars: Vec<CarPath>,
}

impl Motion<'_> {
    /// Returns the state at a share of the way, from 0 to 1.
    pub fn at(&self, share: f64) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.space.dimension);
        self.append_at(share, &mut out);
        out
    }

    /// Appends the state at a share of the way, from 0 to 1.
    pub fn append_at(&self, share: f64, out: &mut Vec<f64>) {
        let begin = out.len();
        if share >= 1.0 {
            // The end itself, without rounding.
            out.extend_from_slice(self.to);
            return;
        }
        out.extend_from_slice(self.from);
        let mut cars = self.cars.iter();
        for (part, x) in self.space.slices(self.from) {
            let o = &mut out[begin + part.first..begin + part.first + x.len()];
            if matches!(part.space, Subspace::Car { .. }) {
                if let Some(path) = cars.next() {
                    o.copy_from_slice(&path.at(pose(x), share));
                }
            } else {
                straight(&part.space, x, &self.to[part.first..part.first + x.len()], share, o);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mixed() -> StateSpace {
        StateSpace::new(vec![
            (Subspace::Reals { low: vec![-1.0, 0.0], high: vec![1.0, 4.0] }, 2.0),
            (Subspace::Circle, 1.0),
            (Subspace::Rotation, 1.5),
            (Subspace::Car { low: [-3.0; 2], high: [3.0; 2], radius: 0.5, motion: CarMotion::ReedsShepp }, 1.0),
        ])
        .unwrap()
    }

    #[test]
    fn motions_lead_from_start_to_end_in_proportion() {
        let (space, mut random) = (mixed(), Random::new(1));
        for _ in 0..300 {
            let (a, b) = (space.sample(&mut random), space.sample(&mut random));
            assert!(space.is_within(&a));
            let motion = space.motion(&a, &b);
            assert!(space.distance(&a, &motion.at(0.0)) < 1e-6);
            assert_eq!(motion.at(1.0), b);
            let (whole, part) = (space.distance(&a, &b), space.distance(&a, &motion.at(0.3)));
            assert!((part - 0.3 * whole).abs() < 1e-5 * (1.0 + whole), "{part} {whole}");
        }
    }

    #[test]
    fn near_samples_are_near() {
        let space = StateSpace::se3([0.0; 3], [1.0; 3]).unwrap();
        let mut random = Random::new(2);
        for _ in 0..300 {
            let a = space.sample(&mut random);
            let b = space.sample_near(&a, 0.2, &mut random);
            assert!(space.is_within(&b) && space.distance(&a, &b) <= 0.2 + 1e-9);
        }
    }

    #[test]
    fn bad_bounds_are_refused_with_a_reason() {
        let text = |r: Result<StateSpace, SpaceError>| r.unwrap_err().0;
        assert!(text(StateSpace::new(vec![])).contains("no parts"));
        assert!(text(StateSpace::reals(&[], &[])).contains("no numbers"));
        assert!(text(StateSpace::reals(&[0.0], &[1.0, 2.0])).contains("1 lower and 2 upper"));
        assert!(text(StateSpace::reals(&[0.0, f64::NAN], &[1.0, 2.0])).contains("number 2"));
        assert!(text(StateSpace::reals(&[3.0], &[1.0])).contains("the lower first"));
        assert!(text(StateSpace::new(vec![(Subspace::Circle, 0.0)])).contains("weight"));
        assert!(text(StateSpace::car([0.0; 2], [1.0; 2], 0.0, CarMotion::Dubins)).contains("radius"));
    }

    #[test]
    fn enforced_states_are_within_bounds() {
        let space = mixed();
        let mut state = vec![f64::NAN, 9.0, 7.0, 0.0, 0.0, 0.0, 0.0, 5.0, -5.0, 4.0];
        space.enforce(&mut state);
        assert!(space.is_within(&state), "{state:?}");
    }
}
