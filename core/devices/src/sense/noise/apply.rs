//! The stages of noise, in order: shift, random walk, walk, white, density, uniform, outliers, clamp, step, inverse
//! step, limits, dropout.
//!
//! The random numbers of an element depend only on the sensor's seed, the number of its previous measurements, the
//! field's name, the stage and the element's index. They do not depend on earlier draws or on other sensors, so parts
//! of a field can be computed in any order.

use std::ops::Range;

use rayon::prelude::*;
use tatu_plugins::SensorKind;
use tatu_scene::noise::{FieldNoise, NamedField};

use crate::sense::numbers::{FieldNumbers, FieldNumbersMut, rounded};
use crate::sense::random::RandomKey;

/// Offsets that are added to the field's stream, one for each use of random numbers.
const SHIFT: u64 = 1;
const WALK: u64 = 2;
const WHITE: u64 = 3;
const UNIFORM: u64 = 4;
const OUTLIER_CHOICE: u64 = 5;
const OUTLIER: u64 = 6;
const DROPOUT: u64 = 7;
const RANDOM_WALK: u64 = 8;
const DENSITY: u64 = 9;
/// Value used instead of the measurement count in the keys of random numbers that are drawn once per run.
const RUN_CONSTANT: u64 = u64::MAX;

/// Number of elements processed at once.
const BLOCK_LEN: usize = 256;
/// Maximum number of elements per task of the thread pool.
const MAX_TASK_LEN: usize = 1 << 14;

/// The noise of one field of a kind.
pub(super) struct FieldPlan {
    pub name: String,
    pub field: usize,
    pub of: Option<usize>,
    pub valid: Option<usize>,
    pub components: usize,
    nothing: Option<Vec<f64>>,
    noise: FieldNoise,
    /// Stream of the field's random numbers, derived from its name, so that it does not depend on the kind's other
    /// fields.
    stream: u64,
}

/// The inputs of the noise of a field in one measurement.
pub(super) struct FieldMeasurement<'a> {
    pub seed: u64,
    pub drawn: u64,
    /// The field on which the polynomial of `sigma` depends, if it is not the field itself.
    pub of: Option<FieldNumbers<'a>>,
    /// The field that marks valid elements, and how many elements share one mark.
    pub valid: Option<(FieldNumbers<'a>, usize)>,
    /// Offsets per component, which are the same for all rows.
    pub bias: Vec<f64>,
    /// Time from one measurement to the next, s.
    pub period: f64,
}

/// The states of the two kinds of walk of a field, one number per component.
pub(super) struct FieldWalks<'a> {
    /// State of the Gauss-Markov process, in standard deviations.
    pub state: &'a mut Vec<f64>,
    /// State of the random walk, in the field's unit.
    pub random: &'a mut Vec<f64>,
    /// Time since the last measurement or, for the first one, since time 0, s.
    pub passed: f64,
}

/// A part of the elements of a field.
struct FieldChunk<'a> {
    /// Index of its first element in the field.
    first: usize,
    data: FieldNumbersMut<'a>,
    /// Marks elements that became invalid; empty if not needed.
    lost: &'a mut [bool],
}

impl FieldPlan {
    /// Builds the plan for a field. Returns `None` if the kind has no such field, for example because a new version of
    /// its plugin removed it.
    pub fn new(kind: &SensorKind, name: &str, noise: &FieldNoise) -> Option<Self> {
        let find = |name: &String| tatu_scene::noise::find_field(kind, name).ok().map(|m| m.index);
        let NamedField { index, components, nothing, valid: usual, .. } =
            tatu_scene::noise::find_field(kind, name).ok()?;
        let of = match &noise.of {
            Some(of) => Some(find(of)?).filter(|of| *of != index),
            None => None,
        };
        let valid = match &noise.valid {
            Some(valid) => Some(find(valid)?),
            None => usual,
        };
        let stream = xxhash_rust::xxh3::xxh3_64(name.as_bytes());
        Some(FieldPlan {
            name: name.to_owned(),
            field: index,
            of,
            valid,
            components,
            nothing,
            noise: noise.clone(),
            stream,
        })
    }

    /// Computes the stages before white noise, and advances the walks. Returns an offset per component, which applies
    /// to all rows.
    pub fn bias(&self, seed: u64, drawn: u64, walk: Option<FieldWalks<'_>>) -> Vec<f64> {
        let mut bias = vec![0.0; self.components];
        let noise = &self.noise;
        let once = RandomKey::new(seed, RUN_CONSTANT, self.stream.wrapping_add(SHIFT));
        for (c, bias) in bias.iter_mut().enumerate() {
            let uniform = 2.0 * once.uniform(c as u64) - 1.0;
            // The normal number has a different index from the uniform one, so that the two are independent.
            let normal = once.normal((c + self.components) as u64);
            *bias += of_component(&noise.shift, c) * uniform + of_component(&noise.shift_sigma, c) * normal;
        }
        let Some(walking) = walk else { return bias };
        if !noise.random_walk.is_empty() {
            let key = RandomKey::new(seed, drawn, self.stream.wrapping_add(RANDOM_WALK));
            walking.random.resize(self.components, 0.0);
            let root = walking.passed.max(0.0).sqrt();
            for (c, (s, bias)) in walking.random.iter_mut().zip(&mut bias).enumerate() {
                *s += of_component(&noise.random_walk, c) * root * key.normal(c as u64);
                *bias += *s;
            }
        }
        if let Some(w) = &noise.walk {
            let key = RandomKey::new(seed, drawn, self.stream.wrapping_add(WALK));
            let (state, x) = (walking.state, walking.passed.max(0.0) / w.tau);
            // The walk starts in its stationary distribution.
            let begins = state.len() != self.components;
            let (left, new) = if begins { (0.0, 1.0) } else { (libm::exp(-x), (-libm::expm1(-2.0 * x)).sqrt()) };
            state.resize(self.components, 0.0);
            for (c, (s, bias)) in state.iter_mut().zip(&mut bias).enumerate() {
                *s = left * *s + if new > 0.0 { new * key.normal(c as u64) } else { 0.0 };
                *bias += of_component(&w.sigma, c) * *s;
            }
        }
        bias
    }

    /// Returns whether the noise includes a walk of either kind.
    pub fn has_walks(&self) -> bool {
        self.noise.walk.is_some() || !self.noise.random_walk.is_empty()
    }

    /// Applies all stages that [`bias`](Self::bias) does not include. `lost` has one entry per element, or is empty if
    /// it is not needed.
    pub fn apply(
        &self,
        data: FieldNumbersMut<'_>,
        lost: &mut [bool],
        m: &FieldMeasurement<'_>,
        pool: &rayon::ThreadPool,
    ) {
        let n = data.len();
        if n <= MAX_TASK_LEN {
            return self.apply_chunk(FieldChunk { first: 0, data, lost }, m);
        }
        // The size of a task is a multiple of the block size, because a block consists of whole rows.
        let task = MAX_TASK_LEN / self.block() * self.block();
        let mut parts: Vec<FieldChunk<'_>> = Vec::with_capacity(n.div_ceil(task));
        let mut losts = lost.chunks_mut(task);
        for (i, data) in data.parts(task).into_iter().enumerate() {
            parts.push(FieldChunk { first: i * task, data, lost: losts.next().unwrap_or_default() });
        }
        pool.install(|| parts.into_par_iter().for_each(|part| self.apply_chunk(part, m)));
    }

    /// Returns the number of elements in a block, which consists of whole rows.
    fn block(&self) -> usize {
        BLOCK_LEN / self.components * self.components
    }

    fn key(&self, m: &FieldMeasurement<'_>, stage: u64) -> RandomKey {
        RandomKey::new(m.seed, m.drawn, self.stream.wrapping_add(stage))
    }

    fn apply_chunk(&self, part: FieldChunk<'_>, m: &FieldMeasurement<'_>) {
        let FieldChunk { first, mut data, lost } = part;
        let (n, block) = (data.len(), self.block());
        for at in (0..n).step_by(block) {
            self.apply_block(&mut data, at..(at + block).min(n), first, lost, m);
        }
    }

    /// Processes a block of rows of a part whose first element is element `before` of the field.
    fn apply_block(
        &self,
        data: &mut FieldNumbersMut<'_>,
        rows: Range<usize>,
        before: usize,
        lost: &mut [bool],
        m: &FieldMeasurement<'_>,
    ) {
        let noise = &self.noise;
        let (at, n) = (rows.start, rows.len());
        let first = (before + at) as u64;
        let (mut value, mut there, mut gone) = ([0.0; BLOCK_LEN], [true; BLOCK_LEN], [false; BLOCK_LEN]);
        let (value, there, gone) = (&mut value[..n], &mut there[..n], &mut gone[..n]);
        let (mut drawn, mut x) = ([0.0; BLOCK_LEN], [0.0; BLOCK_LEN]);
        let (drawn, x) = (&mut drawn[..n], &mut x[..n]);
        data.view().load(at, value);
        self.find_invalid(value, there, first as usize, m);
        // The polynomial of sigma is evaluated at the value before anything is added.
        match m.of {
            Some(of) if !noise.sigma.is_empty() => of.load(first as usize, x),
            _ => x.copy_from_slice(value),
        }
        for_components(value, &m.bias, |v, b| if b != 0.0 { v + b } else { v });
        if !noise.sigma.is_empty() {
            self.key(m, WHITE).normals(first, drawn);
            add_white(value, x, drawn, &noise.sigma);
        }
        if is_any_nonzero(&noise.density) && m.period > 0.0 {
            self.key(m, DENSITY).normals(first, drawn);
            let root = (1.0 / m.period).sqrt();
            drawn.iter_mut().for_each(|d| *d *= root);
            add(value, drawn, &noise.density);
        }
        if is_any_nonzero(&noise.uniform) {
            symmetric(self.key(m, UNIFORM), first, drawn);
            add(value, drawn, &noise.uniform);
        }
        if let Some(o) = noise.outliers.as_ref().filter(|o| o.probability > 0.0) {
            let (whether, size) = (self.key(m, OUTLIER_CHOICE), self.key(m, OUTLIER));
            for (i, v) in value.iter_mut().enumerate() {
                let index = first + i as u64;
                if whether.uniform(index) < o.probability {
                    let c = i % self.components;
                    let more = of_component(&o.sigma, c) * size.normal(index)
                        + of_component(&o.uniform, c) * (2.0 * size.uniform(index | 1 << 62) - 1.0);
                    // An error of 0 is not added, because that would turn -0 into 0.
                    *v = if more != 0.0 { *v + more } else { *v };
                }
            }
        }
        if let Some([low, high]) = noise.clamp {
            value.iter_mut().for_each(|v| *v = v.clamp(low, high));
        }
        if is_any_nonzero(&noise.step) {
            for_components(value, &noise.step, |v, s| if s > 0.0 { rounded(v / s) * s } else { v });
        }
        if is_any_nonzero(&noise.inverse_step) {
            // The inverses of values within half a step of 0 become infinite, and are marked as lost below.
            for_components(value, &noise.inverse_step, |v, s| {
                if s > 0.0 && v != 0.0 { 1.0 / (rounded(1.0 / (v * s)) * s) } else { v }
            });
            value.iter().zip(gone.iter_mut()).for_each(|(v, g)| *g |= !v.is_finite());
        }
        if let Some([low, high]) = noise.limits {
            value.iter().zip(gone.iter_mut()).for_each(|(v, g)| *g |= !(low..=high).contains(v));
        }
        if noise.dropout > 0.0 {
            let key = self.key(m, DROPOUT);
            let together = m.valid.map_or(1, |(_, group)| group) as u64;
            for (i, g) in gone.iter_mut().enumerate() {
                *g |= key.uniform((first + i as u64) / together) < noise.dropout;
            }
        }
        self.mark_lost(value, there, gone);
        data.store(at, value, there);
        if let Some(lost) = lost.get_mut(rows) {
            lost.copy_from_slice(gone);
        }
    }

    /// Clears `there` for elements that are invalid according to another field or their own value, which must not be
    /// changed.
    fn find_invalid(&self, value: &[f64], there: &mut [bool], first: usize, m: &FieldMeasurement<'_>) {
        match (&m.valid, &self.nothing) {
            (Some((valid, group)), _) => {
                there.iter_mut().enumerate().for_each(|(i, t)| *t = !valid.is_zero((first + i) / group));
            }
            (None, Some(nothing)) if nothing.len() == 1 => {
                value.iter().zip(there.iter_mut()).for_each(|(v, t)| *t = *v != nothing[0]);
            }
            (None, Some(nothing)) => {
                let rows = value.chunks_exact(nothing.len()).zip(there.chunks_exact_mut(nothing.len()));
                rows.for_each(|(row, there)| there.fill(row != nothing.as_slice()));
            }
            (None, None) => {}
        }
        value.iter().zip(there.iter_mut()).for_each(|(v, t)| *t &= v.is_finite());
    }

    /// Sets lost elements to the value that means "invalid". If that value is a row, the row is lost as a whole.
    fn mark_lost(&self, value: &mut [f64], there: &mut [bool], gone: &mut [bool]) {
        gone.iter_mut().zip(&*there).for_each(|(g, t)| *g &= *t);
        match &self.nothing {
            Some(nothing) => {
                if nothing.len() > 1 {
                    gone.chunks_mut(nothing.len()).for_each(|row| row.fill(row.contains(&true)));
                }
                let each = nothing.iter().cycle();
                value.iter_mut().zip(&*gone).zip(each).for_each(|((v, g), x)| *v = if *g { *x } else { *v });
            }
            // If no value means "invalid", the measured value is left unchanged, and another field marks the element.
            None => there.iter_mut().zip(&*gone).for_each(|(t, g)| *t &= !*g),
        }
        // A sum that overflowed is not a valid measurement, and infinity would mean "invalid".
        value.iter().zip(&*gone).zip(there.iter_mut()).for_each(|((v, g), t)| *t &= v.is_finite() || *g);
    }
}

fn is_any_nonzero(size: &[f64]) -> bool {
    size.iter().any(|s| *s != 0.0)
}

fn of_component(size: &[f64], c: usize) -> f64 {
    match size {
        [] => 0.0,
        [one] => *one,
        all => all[c],
    }
}

/// Fills `out` with random numbers in [-1, 1).
fn symmetric(key: RandomKey, first: u64, out: &mut [f64]) {
    (first..).zip(out).for_each(|(i, x)| *x = 2.0 * key.uniform(i) - 1.0);
}

/// Adds random numbers multiplied by `size`. If the size is 0, nothing is added, so that no bit of the value changes.
fn add(value: &mut [f64], drawn: &[f64], size: &[f64]) {
    let sum = |v: f64, d: f64, s: f64| if s > 0.0 { v + s * d } else { v };
    match size {
        [s] => value.iter_mut().zip(drawn).for_each(|(v, d)| *v = sum(*v, *d, *s)),
        all => value.iter_mut().zip(drawn).zip(all.iter().cycle()).for_each(|((v, d), s)| *v = sum(*v, *d, *s)),
    }
}

fn for_components(value: &mut [f64], size: &[f64], f: impl Fn(f64, f64) -> f64) {
    match size {
        [s] => value.iter_mut().for_each(|v| *v = f(*v, *s)),
        all => value.iter_mut().zip(all.iter().cycle()).for_each(|(v, s)| *v = f(*v, *s)),
    }
}

/// Adds normal numbers whose standard deviation is a polynomial in `x`. Nothing is added where the polynomial is
/// negative or not finite.
fn add_white(value: &mut [f64], x: &[f64], drawn: &[f64], sigma: &[Vec<f64>]) {
    let sum = |v: f64, s: f64, d: f64| if s > 0.0 && s < f64::INFINITY { v + s * d } else { v };
    let all = value.iter_mut().zip(x).zip(drawn);
    match sigma {
        [one] => match one.as_slice() {
            [a] => all.for_each(|((v, _), d)| *v = sum(*v, *a, *d)),
            [a, b] => all.for_each(|((v, x), d)| *v = sum(*v, b * x + a, *d)),
            [a, b, c] => all.for_each(|((v, x), d)| *v = sum(*v, (c * x + b) * x + a, *d)),
            many => all.for_each(|((v, x), d)| *v = sum(*v, polynomial(many, *x), *d)),
        },
        each => all.zip(each.iter().cycle()).for_each(|(((v, x), d), p)| *v = sum(*v, polynomial(p, *x), *d)),
    }
}

fn polynomial(c: &[f64], x: f64) -> f64 {
    c.iter().rev().fold(0.0, |sum, c| sum * x + c)
}
