//! Noise that the host applies to the fields of a sensor after each measurement.
//!
//! - `apply`: the stages of noise, in order;
//! - this module: the state that is stored between measurements, which consists of walks and delayed readings.
//!
//! A scene declares noise as a [`NoiseSpec`] of the crate `tatu-scene`.

mod apply;

use std::{
    collections::{BTreeMap, VecDeque},
    sync::Arc,
};

use serde::{Deserialize, Serialize};

#[cfg(test)]
use tatu_scene::noise::FieldNoise;
pub use tatu_scene::noise::NoiseSpec;

use super::{
    ReadingBuffer,
    numbers::{FieldNumbers, FieldNumbersMut},
};
use apply::{FieldMeasurement, FieldPlan, FieldWalks};
use tatu_plugins::SensorKind;

/// The noise of a sensor, with its state.
#[derive(Default)]
pub struct SensorNoise {
    /// The declaration from which the noise was built.
    spec: Option<Arc<NoiseSpec>>,
    plans: Vec<FieldPlan>,
    latency: f64,
    state: NoiseState,
}

/// The state stored between measurements.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct NoiseState {
    /// The walks of each field, by name.
    walks: BTreeMap<String, SavedWalks>,
    /// Delayed readings that are not visible yet, oldest first.
    held: VecDeque<HeldReading>,
}

/// The walks of a field.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
struct SavedWalks {
    /// Time of the last measurement, s.
    time: f64,
    /// The state of each component's Gauss-Markov process in standard deviations.
    state: Vec<f64>,
    /// The value of each component's random walk, in the field's unit.
    random: Vec<f64>,
}

/// A delayed reading: its time, sequence number and fields.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct HeldReading {
    pub time: f64,
    pub sequence: u64,
    pub fields: ReadingBuffer,
}

/// A measurement to which noise is applied.
pub struct RawMeasurement<'a> {
    pub kind: &'a SensorKind,
    pub seed: u64,
    pub drawn: u64,
    pub time: f64,
    /// Time from one measurement to the next, s.
    pub period: f64,
    pub fields: &'a mut [u64],
    /// For each field, the index of its first word and its number of elements.
    pub spans: &'a [(usize, usize)],
}

impl SensorNoise {
    /// Creates noise with a saved state.
    pub fn from_state(memory: NoiseState) -> Self {
        SensorNoise { state: memory, ..Default::default() }
    }

    /// Returns the state of the noise, for snapshots.
    pub fn state(&self) -> &NoiseState {
        &self.state
    }

    /// Replaces the noise by the scene's current declaration. Walks that are still declared keep their state.
    pub fn update(now: &mut Option<Box<SensorNoise>>, spec: Option<&Arc<NoiseSpec>>, kind: &SensorKind) {
        let same = match (&*now, spec) {
            (None, None) => true,
            (Some(n), Some(spec)) => n.spec.as_ref().is_some_and(|s| Arc::ptr_eq(s, spec)),
            _ => false,
        };
        if same {
            return;
        }
        let mut memory = now.take().map(|n| n.state).unwrap_or_default();
        let Some(spec) = spec else {
            // Without a declaration there is no latency, so the readings that are still held will be released at the
            // next check.
            if !memory.held.is_empty() {
                memory.walks.clear();
                *now = Some(Box::new(SensorNoise { state: memory, ..Default::default() }));
            }
            return;
        };
        let plans: Vec<FieldPlan> =
            spec.fields.iter().filter_map(|(name, noise)| FieldPlan::new(kind, name, noise)).collect();
        memory.walks.retain(|name, _| plans.iter().any(|p| p.name == *name && p.has_walks()));
        let latency = spec.latency.unwrap_or(0.0);
        *now = Some(Box::new(SensorNoise { spec: Some(spec.clone()), plans, latency, state: memory }));
    }

    /// Applies the noise to the fields of a measurement.
    pub fn apply(&mut self, m: RawMeasurement<'_>, pool: &rayon::ThreadPool) {
        // Fields that others depend on are copied, so that their measured values remain available until all fields have
        // been processed.
        let noisy = |i: usize| self.plans.iter().any(|p| p.field == i);
        let asked = self.plans.iter().flat_map(|p| [p.of, p.valid]).flatten();
        let kept: BTreeMap<usize, Vec<u64>> = asked
            .filter(|i| noisy(*i))
            .map(|i| (i, m.fields[m.spans[i].0..].iter().take(m.spans[i].1).copied().collect()))
            .collect();
        let mut cleared: Vec<(usize, usize, Vec<bool>)> = Vec::new();
        for plan in &self.plans {
            let (first, n) = m.spans[plan.field];
            // The words up to the next field belong to this one.
            let end = m.spans.get(plan.field + 1).map_or(m.fields.len(), |(next, _)| *next);
            let (before, rest) = m.fields.split_at_mut(first);
            let (own, after) = rest.split_at_mut(end - first);
            let other = |i: usize| {
                let (place, n) = m.spans[i];
                let words = match kept.get(&i) {
                    Some(kept) => kept.as_slice(),
                    None if i < plan.field => &before[place..],
                    // This field is noisy, so its measured values have been copied.
                    None => &after[place - end..],
                };
                FieldNumbers::of(words, m.kind.fields[i].elem, n).map(|numbers| (numbers, n))
            };
            let of = plan.of.and_then(other).filter(|(_, k)| *k == n).map(|(of, _)| of);
            let valid = plan.valid.and_then(other).filter(|(_, k)| *k > 0 && n % k == 0);
            let valid = valid.map(|(valid, k)| (valid, (n / k).max(1)));
            let walking = plan.has_walks().then(|| {
                let SavedWalks { time, state, random } = self.state.walks.entry(plan.name.clone()).or_default();
                FieldWalks { state, random, passed: m.time - std::mem::replace(time, m.time) }
            });
            let bias = plan.bias(m.seed, m.drawn, walking);
            let mut lost = vec![false; if valid.is_some() { n } else { 0 }];
            let data = FieldNumbersMut::of(own, m.kind.fields[plan.field].elem, n);
            let measure = FieldMeasurement { seed: m.seed, drawn: m.drawn, of, valid, bias, period: m.period };
            if let Some(data) = data {
                plan.apply(data, &mut lost, &measure, pool);
            }
            if let (Some(field), Some((_, group))) = (plan.valid, valid) {
                cleared.push((field, group, lost));
            }
        }
        for (field, group, lost) in cleared {
            let (first, n) = m.spans[field];
            if let Some(mut valid) = FieldNumbersMut::of(&mut m.fields[first..], m.kind.fields[field].elem, n) {
                lost.iter().enumerate().filter(|(_, l)| **l).for_each(|(i, _)| valid.clear(i / group));
            }
        }
    }

    /// Returns whether readings are delayed, or delayed readings are still held.
    pub fn delays(&self) -> bool {
        self.latency > 0.0 || !self.state.held.is_empty()
    }

    /// Returns the sequence number of the newest reading that is held.
    pub fn newest(&self) -> Option<u64> {
        self.state.held.back().map(|r| r.sequence)
    }

    /// Holds back a reading. If the newest held reading has the same time, it is replaced.
    pub fn hold(&mut self, reading: HeldReading) {
        if self.state.held.back().is_some_and(|r| r.time == reading.time) {
            self.state.held.pop_back();
        }
        self.state.held.push_back(reading);
    }

    /// Removes all held readings that are old enough to be visible, and returns the newest of them.
    pub fn release(&mut self, now: f64) -> Option<HeldReading> {
        // Times are sums of steps, so the comparison tolerates rounding errors.
        let old = |r: &HeldReading| r.time + self.latency <= now + 1e-9 * (1.0 + now.abs());
        let n = self.state.held.iter().take_while(|r| old(r)).count();
        self.state.held.drain(..n).next_back()
    }

    /// Drops all held readings.
    pub fn discard_held(&mut self) {
        self.state.held.clear();
    }
}

#[cfg(test)]
pub mod judge;
#[cfg(test)]
mod statistics;
#[cfg(test)]
mod tests;
