//! Streams: one value over time, with its transformation.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::{StreamSpec, StreamTransform};

/// A stream of a graph.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordedStream {
    /// Number in the graph, unique among streams and curves.
    pub id: i64,
    /// Description of the stream.
    pub spec: StreamSpec,
    /// Red, green, blue, 0 to 1.
    pub color: [f64; 3],
    /// One value for each time of the graph; NaN if it is missing.
    pub values: VecDeque<f64>,
    /// Whether a script added the stream while no run was in progress: it remains when a run starts.
    pub lasting: bool,
    /// The value that a script has set since the last sample, if any.
    pub given: Option<f64>,
    /// Time and untransformed value of the previous sample.
    before: Option<(f64, f64)>,
    /// Integral or sum up to the previous sample.
    sum: f64,
    /// The transformed values to be averaged, newest last.
    window: VecDeque<f64>,
}

impl RecordedStream {
    /// Creates a stream in a graph that already has `recorded` samples, which are missing in this stream.
    pub fn new(id: i64, spec: StreamSpec, color: [f64; 3], recorded: usize) -> Self {
        let color = spec.color.unwrap_or(color);
        RecordedStream {
            id,
            color,
            spec,
            values: std::iter::repeat_n(f64::NAN, recorded).collect(),
            lasting: false,
            given: None,
            before: None,
            sum: 0.0,
            window: VecDeque::new(),
        }
    }
    /// Discards all samples.
    pub fn clear(&mut self) {
        let (spec, color, lasting) = (std::mem::take(&mut self.spec), self.color, self.lasting);
        *self = RecordedStream { color, lasting, ..RecordedStream::new(self.id, spec, color, 0) };
    }
    /// Adds a sample; `number` is `None` if the value is missing.
    pub fn add_sample(&mut self, time: f64, number: Option<f64>) {
        let value = number.filter(|x| x.is_finite()).and_then(|x| self.apply_transform(time, x));
        self.values.push_back(value.unwrap_or(f64::NAN));
    }

    fn apply_transform(&mut self, time: f64, x: f64) -> Option<f64> {
        let before = self.before.replace((time, x));
        let made = match self.spec.transform {
            StreamTransform::Raw => x,
            StreamTransform::Derivative => {
                let (t, y) = before.filter(|(t, _)| *t != time)?;
                (x - y) / (time - t)
            }
            StreamTransform::Integral => {
                self.sum += before.map_or(0.0, |(t, y)| (x + y) / 2.0 * (time - t));
                self.sum
            }
            StreamTransform::Cumulative => {
                self.sum += x;
                self.sum
            }
        };
        let made = made * self.spec.factor + self.spec.offset;
        if self.spec.window <= 1 {
            return Some(made);
        }
        self.window.push_back(made);
        while self.window.len() > self.spec.window as usize {
            self.window.pop_front();
        }
        // Recomputing the sum each time prevents rounding errors from accumulating.
        Some(self.window.iter().sum::<f64>() / self.window.len() as f64)
    }
}

#[cfg(test)]
mod tests {
    use crate::graph::*;

    fn made(transform: StreamTransform, factor: f64, offset: f64, window: u32, f: impl Fn(f64) -> f64) -> Vec<f64> {
        let spec = StreamSpec { name: "s".into(), transform, factor, offset, window, ..Default::default() };
        let mut s = RecordedStream::new(1, spec, [0.0; 3], 0);
        for i in 0..5 {
            let t = f64::from(i) * 0.5;
            s.add_sample(t, Some(f(t)));
        }
        s.values.into_iter().collect()
    }

    #[test]
    fn transforms_match_closed_forms() {
        let line = |t: f64| 3.0 * t;
        assert_eq!(made(StreamTransform::Raw, 2.0, 1.0, 1, line), [1.0, 4.0, 7.0, 10.0, 13.0]);
        let slope = made(StreamTransform::Derivative, 1.0, 0.0, 1, line);
        assert!(slope[0].is_nan());
        assert_eq!(slope[1..], [3.0; 4]);
        // The integral of 3 t is 1.5 t^2, for which the trapezoidal rule is exact.
        assert_eq!(made(StreamTransform::Integral, 1.0, 0.0, 1, line), [0.0, 0.375, 1.5, 3.375, 6.0]);
        assert_eq!(made(StreamTransform::Cumulative, 1.0, 0.0, 1, line), [0.0, 1.5, 4.5, 9.0, 15.0]);
        // The means of (0), (0, 1.5), (0, 1.5, 3), (1.5, 3, 4.5) and (3, 4.5, 6).
        assert_eq!(made(StreamTransform::Raw, 1.0, 0.0, 3, line), [0.0, 0.75, 1.5, 3.0, 4.5]);
    }

    #[test]
    fn missing_samples_are_nan() {
        let mut s = RecordedStream::new(1, StreamSpec { factor: 1.0, window: 1, ..Default::default() }, [0.0; 3], 2);
        s.add_sample(0.0, None);
        s.add_sample(1.0, Some(5.0));
        s.add_sample(2.0, Some(f64::INFINITY));
        let missing: Vec<bool> = s.values.iter().map(|v| v.is_nan()).collect();
        assert_eq!(missing, [true, true, true, false, true]);
    }
}
