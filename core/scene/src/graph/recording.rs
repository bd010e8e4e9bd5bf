//! Graphs: streams that are recorded together, and curves of one stream over another.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};
use tatu_errors::Refusal;
use tatu_plugin_api::abi::*;

use super::{
    CurveSpec, GraphSpec, RecordedStream, StreamSpec,
    spec::{self, CurveAxis},
};

/// Maximum total number of streams and curves of a graph.
const MAX_STREAMS_AND_CURVES: usize = 1000;

/// A curve of a graph.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordedCurve {
    /// Number in the graph; streams and curves share the numbering.
    pub id: i64,
    /// Description of the curve.
    pub spec: CurveSpec,
    /// Red, green, blue, 0 to 1.
    pub color: [f64; 3],
    /// Points of a static curve, which no longer change; `None` for other curves.
    pub points: Option<Vec<Vec<f64>>>,
    /// Whether a script added the curve while no run was in progress: it remains when a run starts.
    pub lasting: bool,
}

/// The recorded data of a graph object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Graph {
    /// Unique name of the graph object.
    pub name: String,
    /// Maximum number of samples; the oldest are discarded.
    pub buffer: usize,
    /// Times of the samples, s.
    pub times: VecDeque<f64>,
    /// Streams, in order of creation.
    pub streams: Vec<RecordedStream>,
    /// Curves, in order of creation.
    pub curves: Vec<RecordedCurve>,
    /// Whether streams and curves that are added now remain when a run starts.
    pub adds_lasting: bool,
    last: i64,
}

impl Graph {
    /// Creates an empty graph from a description, leaving out inconsistent streams and curves.
    pub fn new(spec: &GraphSpec, name: String) -> Self {
        let mut graph = Self::blank(spec, name);
        for s in &spec.streams {
            let _ = graph.add_stream(s.clone());
        }
        for c in &spec.curves {
            let _ = graph.add_curve(c.clone());
        }
        graph
    }
    /// Creates an empty graph from a description, or returns why the description is inconsistent.
    pub fn try_new(spec: &GraphSpec, name: String) -> Result<Self, Refusal> {
        let mut graph = Self::blank(spec, name);
        for s in &spec.streams {
            graph.add_stream(s.clone())?;
        }
        for c in &spec.curves {
            graph.add_curve(c.clone())?;
        }
        Ok(graph)
    }
    fn blank(spec: &GraphSpec, name: String) -> Self {
        let (streams, curves) = (Vec::new(), Vec::new());
        Graph { name, buffer: spec.buffer, times: VecDeque::new(), streams, curves, adds_lasting: false, last: 0 }
    }
    /// Creates an empty graph from a description, with those streams and curves of `before` that remain when a run
    /// starts. They keep their numbers.
    pub fn restarted(spec: &GraphSpec, name: String, before: &Graph) -> Self {
        let mut graph = Self::new(spec, name);
        let known = |graph: &Graph, id: i64, name: &str| id <= graph.last || graph.find(name).is_some();
        let (declared, mut last) = (graph.last, graph.last);
        for s in before.streams.iter().filter(|s| s.lasting && s.id > declared) {
            if !known(&graph, s.id, &s.spec.name) {
                let mut stream = s.clone();
                stream.clear();
                graph.streams.push(stream);
                last = last.max(s.id);
            }
        }
        for c in before.curves.iter().filter(|c| c.lasting && c.id > declared) {
            if !known(&graph, c.id, &c.spec.name) {
                graph.curves.push(c.clone());
                last = last.max(c.id);
            }
        }
        graph.last = last;
        graph
    }
    fn next_number(&mut self, name: &str) -> Result<i64, Refusal> {
        if self.streams.len() + self.curves.len() >= MAX_STREAMS_AND_CURVES {
            return Err(Refusal(
                TATU_ERR_SPACE,
                format!("the graph already has {MAX_STREAMS_AND_CURVES} streams and curves"),
            ));
        }
        if self.find(name).is_some() {
            return Err(Refusal(TATU_ERR_ARGUMENT, format!("the graph already has a stream or curve `{name}`")));
        }
        self.last += 1;
        Ok(self.last)
    }
    /// Adds a stream and returns its number, from 1. A lasting stream with the same name is replaced, so that a script
    /// that is started again can add its streams again.
    pub fn add_stream(&mut self, spec: StreamSpec) -> Result<i64, Refusal> {
        if let Some(stream) = self.streams.iter_mut().find(|s| s.lasting && s.spec.name == spec.name) {
            stream.color = spec.color.unwrap_or(stream.color);
            stream.spec = spec;
            return Ok(stream.id);
        }
        let id = self.next_number(&spec.name)?;
        let color = spec::color(self.streams.len());
        let mut stream = RecordedStream::new(id, spec, color, self.times.len());
        stream.lasting = self.adds_lasting;
        self.streams.push(stream);
        Ok(id)
    }
    /// Adds a curve and returns its number, as [`add_stream`](Self::add_stream) does. The streams that the curve refers to must exist.
    pub fn add_curve(&mut self, spec: CurveSpec) -> Result<i64, Refusal> {
        for axis in &spec.axes {
            if let CurveAxis::Stream(name) = axis
                && !self.streams.iter().any(|s| s.spec.name == *name)
            {
                let text = format!("the curve `{}` refers to the stream `{name}`, which does not exist", spec.name);
                return Err(Refusal(TATU_ERR_ARGUMENT, text));
            }
        }
        let lasting = self.adds_lasting;
        if let Some(curve) = self.curves.iter_mut().find(|c| c.lasting && c.spec.name == spec.name) {
            let color = spec.color.unwrap_or(curve.color);
            *curve = RecordedCurve { id: curve.id, spec, color, points: None, lasting };
            return Ok(curve.id);
        }
        let id = self.next_number(&spec.name)?;
        let color = spec.color.unwrap_or(spec::color(self.curves.len()));
        self.curves.push(RecordedCurve { id, spec, color, points: None, lasting });
        Ok(id)
    }
    /// Adds a static copy of a curve in its current state, and returns the number of the copy. If `name` is empty, the
    /// name of the copy is derived from the curve's.
    pub fn freeze(&mut self, curve: i64, name: &str) -> Result<i64, Refusal> {
        let Some(of) = self.curves.iter().find(|c| c.id == curve).cloned() else {
            return Err(Refusal(TATU_ERR_MISSING, format!("the graph has no curve {curve}")));
        };
        let points = self.points(&of);
        let mut name = if name.is_empty() { format!("{} (static)", of.spec.name) } else { name.to_owned() };
        while self.find(&name).is_some() {
            name += "'";
        }
        let id = self.next_number(&name)?;
        let color = spec::color(self.curves.len());
        let spec = CurveSpec { name, ..of.spec };
        let lasting = self.adds_lasting;
        self.curves.push(RecordedCurve { id, spec, color, points: Some(points), lasting });
        Ok(id)
    }
    /// Removes a stream or a curve; returns whether it existed. Curves of a removed stream become static.
    pub fn remove(&mut self, id: i64) -> bool {
        if let Some(stream) = self.streams.iter().find(|s| s.id == id) {
            let name = stream.spec.name.clone();
            for i in 0..self.curves.len() {
                let uses = self.curves[i].spec.axes.iter().any(|a| matches!(a, CurveAxis::Stream(n) if *n == name));
                if uses && self.curves[i].points.is_none() {
                    self.curves[i].points = Some(self.points(&self.curves[i]));
                }
            }
        }
        let before = self.streams.len() + self.curves.len();
        self.streams.retain(|s| s.id != id);
        self.curves.retain(|c| c.id != id);
        self.streams.len() + self.curves.len() < before
    }
    /// Returns the number of a stream or curve, by name.
    pub fn find(&self, name: &str) -> Option<i64> {
        let stream = self.streams.iter().find(|s| s.spec.name == name).map(|s| s.id);
        stream.or_else(|| self.curves.iter().find(|c| c.spec.name == name).map(|c| c.id))
    }
    /// Returns a stream by number.
    pub fn stream(&mut self, id: i64) -> Result<&mut RecordedStream, Refusal> {
        let missing = || Refusal(TATU_ERR_MISSING, format!("the graph has no stream {id}"));
        self.streams.iter_mut().find(|s| s.id == id).ok_or_else(missing)
    }
    /// Discards all samples.
    pub fn clear(&mut self) {
        self.times.clear();
        self.streams.iter_mut().for_each(RecordedStream::clear);
    }
    /// Adds a sample to each stream. `numbers` contains one value for each stream, in order; `None` is a missing value.
    pub fn add_sample(&mut self, time: f64, numbers: &[Option<f64>]) {
        if self.times.len() >= self.buffer {
            self.times.pop_front();
            for s in &mut self.streams {
                s.values.pop_front();
            }
        }
        self.times.push_back(time);
        for (s, number) in self.streams.iter_mut().zip(numbers) {
            s.add_sample(time, *number);
        }
    }
    /// Returns the points of a curve, one for each sample; missing coordinates are NaN.
    pub fn points(&self, curve: &RecordedCurve) -> Vec<Vec<f64>> {
        if let Some(points) = &curve.points {
            return points.clone();
        }
        let axis = |axis: &CurveAxis, i: usize| match axis {
            CurveAxis::Always(x) => *x,
            CurveAxis::Stream(name) => {
                let stream = self.streams.iter().find(|s| s.spec.name == *name);
                stream.and_then(|s| s.values.get(i)).copied().unwrap_or(f64::NAN)
            }
        };
        (0..self.times.len()).map(|i| curve.spec.axes.iter().map(|a| axis(a, i)).collect()).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::graph::*;

    fn stream(name: &str) -> StreamSpec {
        StreamSpec { name: name.into(), factor: 1.0, window: 1, ..Default::default() }
    }
    fn curve(name: &str, axes: &[&str]) -> CurveSpec {
        let axes = axes.iter().map(|a| CurveAxis::Stream((*a).into())).collect();
        CurveSpec { name: name.into(), unit: String::new(), color: None, axes }
    }

    #[test]
    fn oldest_samples_are_discarded_at_capacity() {
        let spec = GraphSpec { buffer: 3, streams: vec![stream("a")], ..Default::default() };
        let mut g = Graph::new(&spec, "g".into());
        for i in 0..5 {
            g.add_sample(f64::from(i), &[Some(f64::from(i * i))]);
        }
        assert_eq!(Vec::from(g.times.clone()), [2.0, 3.0, 4.0]);
        assert_eq!(Vec::from(g.streams[0].values.clone()), [4.0, 9.0, 16.0]);
        g.clear();
        assert!(g.times.is_empty() && g.streams[0].values.is_empty());
    }

    #[test]
    fn curve_plots_one_stream_over_another() {
        let spec = GraphSpec { streams: vec![stream("a"), stream("b")], ..Default::default() };
        let mut g = Graph::new(&spec, "g".into());
        let live = g.add_curve(curve("c", &["a", "b"])).unwrap();
        g.add_sample(0.0, &[Some(1.0), Some(2.0)]);
        let frozen = g.freeze(live, "").unwrap();
        g.add_sample(1.0, &[Some(3.0), None]);
        let of = |g: &Graph, id| g.points(g.curves.iter().find(|c| c.id == id).unwrap());
        assert_eq!(of(&g, frozen), [[1.0, 2.0]]);
        let points = of(&g, live);
        assert_eq!(points[0], [1.0, 2.0]);
        assert!(points.len() == 2 && points[1][0] == 3.0 && points[1][1].is_nan());
        assert!(g.add_curve(curve("d", &["a", "none"])).is_err());
        assert!(g.add_stream(stream("c")).is_err(), "names are unique");
        assert!(g.remove(live) && !g.remove(live));
    }
}
