//! Descriptions of graphs, streams and curves, which scene files and plugins provide as tables.

use serde::{Deserialize, Serialize};
use tatu_errors::Refusal;
use tatu_plugin_api::{abi::*, safe::Value};

use super::values::{CheckedMap, map};
use crate::{
    object::ObjectKind,
    property::{properties, refusal_as_text, unexpected},
};

/// Maximum number of samples that a graph can store.
pub const MAX_GRAPH_SAMPLES: i64 = 1_000_000;

/// Default colours of streams and curves, in order. They are based on the palette of Okabe and Ito, which most people
/// with colour blindness can distinguish, and are dark enough for a white background.
const COLORS: [[f64; 3]; 7] = [
    [0.0, 0.45, 0.70],
    [0.84, 0.37, 0.0],
    [0.0, 0.62, 0.45],
    [0.80, 0.47, 0.65],
    [0.90, 0.62, 0.0],
    [0.34, 0.71, 0.91],
    [0.25, 0.25, 0.25],
];

/// Returns the default colour of the `i`-th stream or curve.
pub fn color(i: usize) -> [f64; 3] {
    COLORS[i % COLORS.len()]
}

/// The transformation of a stream's values, before factor, offset and average.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names are self-explanatory")]
pub enum StreamTransform {
    #[default]
    Raw,
    /// Change per second since the previous sample; undefined for the first one.
    Derivative,
    /// Integral by the trapezoidal rule.
    Integral,
    /// Sum of all samples.
    Cumulative,
}

impl StreamTransform {
    /// Names of the transformations, in the order of the variants.
    pub const NAMES: [&str; 4] = ["raw", "derivative", "integral", "cumulative"];

    /// Returns the transformation with a name; an empty name means raw.
    fn parse(name: &str) -> Option<Self> {
        let all = [Self::Raw, Self::Derivative, Self::Integral, Self::Cumulative];
        if name.is_empty() { Some(Self::Raw) } else { Self::NAMES.iter().position(|n| *n == name).map(|i| all[i]) }
    }
    /// Returns the transformation's name.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}

/// Description of a stream: one value over time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct StreamSpec {
    /// Name of the stream, unique in the graph.
    pub name: String,
    /// Unit of the result, for display.
    pub unit: String,
    /// Red, green, blue, 0 to 1; if `None`, a default colour.
    pub color: Option<[f64; 3]>,
    /// Path of the object that the value belongs to; if empty, a script sets the value.
    pub of: String,
    /// The recorded value: "x", "speed", "joint.position", `object.world_pose[2]`, or a field of a reading.
    pub data: String,
    /// Transformation of the values.
    pub transform: StreamTransform,
    /// Factor that is applied after the transformation.
    pub factor: f64,
    /// Offset that is added after the factor.
    pub offset: f64,
    /// Number of samples in the moving average, which is computed last; 1 for no averaging.
    pub window: u32,
    /// Whether the stream is recorded but not plotted.
    pub hidden: bool,
}

impl StreamSpec {
    const KEYS: &[&str] = &["name", "unit", "color", "of", "data", "transform", "factor", "offset", "window", "hidden"];

    /// Parses the table of a stream.
    pub fn from_value(value: &Value) -> Result<Self, Refusal> {
        let blank = StreamSpec { factor: 1.0, window: 1, ..Default::default() };
        let spec = blank.with(value)?;
        if spec.name.is_empty() {
            return Err(Refusal(TATU_ERR_ARGUMENT, "a stream must have a `name`".into()));
        }
        if spec.of.is_empty() != spec.data.is_empty() {
            let text = format!("the stream `{}` must specify both `of` and `data`, or neither", spec.name);
            return Err(Refusal(TATU_ERR_ARGUMENT, text));
        }
        Ok(spec)
    }
    /// Returns a copy with the changes that a table specifies.
    pub fn with(&self, value: &Value) -> Result<Self, Refusal> {
        let keys = CheckedMap::new("a stream", value, Self::KEYS)?;
        let other =
            |now: &String, key| Ok(Some(keys.text(key)?).filter(|t: &String| !t.is_empty()).unwrap_or(now.clone()));
        let name = keys.text("transform")?;
        let transform = match StreamTransform::parse(&name) {
            Some(StreamTransform::Raw) if name.is_empty() => self.transform,
            Some(t) => t,
            None => return keys.invalid_value("transform", &format!("one of {}", StreamTransform::NAMES.join(", "))),
        };
        Ok(StreamSpec {
            name: other(&self.name, "name")?,
            unit: other(&self.unit, "unit")?,
            color: keys.color("color")?.or(self.color),
            of: other(&self.of, "of")?,
            data: other(&self.data, "data")?,
            transform,
            factor: keys.number("factor")?.unwrap_or(self.factor),
            offset: keys.number("offset")?.unwrap_or(self.offset),
            window: keys.count("window", 1..=10_000)?.map_or(self.window, |n| n as u32),
            hidden: keys.flag("hidden")? || self.hidden,
        })
    }
    /// Returns the description as a table.
    pub fn to_value(&self) -> Value {
        map([
            ("name", Value::text(&self.name)),
            ("unit", Value::text(&self.unit)),
            ("color", self.color.map_or(Value::Nil, |c| Value::Floats(c.to_vec()))),
            ("of", Value::text(&self.of)),
            ("data", Value::text(&self.data)),
            ("transform", Value::text(self.transform.name())),
            ("factor", Value::Float(self.factor)),
            ("offset", Value::Float(self.offset)),
            ("window", Value::Int(self.window.into())),
            ("hidden", Value::Bool(self.hidden)),
        ])
    }
}

/// The source of one coordinate of a curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum CurveAxis {
    /// A stream, by name.
    Stream(String),
    /// A constant value.
    Always(f64),
}

/// Description of a curve: one stream plotted over another, or three streams as a curve in space.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CurveSpec {
    /// Name of the curve, unique in the graph.
    pub name: String,
    /// Unit of the axes, for display.
    pub unit: String,
    /// Red, green, blue, 0 to 1; if `None`, a default colour.
    pub color: Option<[f64; 3]>,
    /// The sources of the curve's 2 or 3 coordinates.
    pub axes: Vec<CurveAxis>,
}

impl CurveSpec {
    const KEYS: &[&str] = &["name", "unit", "color", "x", "y", "z"];

    /// Parses the table of a curve.
    pub fn from_value(value: &Value) -> Result<Self, Refusal> {
        let keys = CheckedMap::new("a curve", value, Self::KEYS)?;
        let name = keys.text("name")?;
        if name.is_empty() {
            return Err(Refusal(TATU_ERR_ARGUMENT, "a curve must have a `name`".into()));
        }
        let mut axes = Vec::new();
        for key in ["x", "y", "z"] {
            match keys.text_or_number(key)? {
                Some(Err(stream)) => axes.push(CurveAxis::Stream(stream)),
                Some(Ok(number)) => axes.push(CurveAxis::Always(number)),
                None if key == "z" => {}
                None => return keys.invalid_value(key, "the name of a stream, or a number"),
            }
        }
        Ok(CurveSpec { name, unit: keys.text("unit")?, color: keys.color("color")?, axes })
    }
    /// Returns the description as a table.
    pub fn to_value(&self) -> Value {
        let axes = ["x", "y", "z"].into_iter().zip(&self.axes).map(|(key, axis)| match axis {
            CurveAxis::Stream(name) => (key, Value::text(name)),
            CurveAxis::Always(x) => (key, Value::Float(*x)),
        });
        let rest = [
            ("name", Value::text(&self.name)),
            ("unit", Value::text(&self.unit)),
            ("color", self.color.map_or(Value::Nil, |c| Value::Floats(c.to_vec()))),
        ];
        map(rest.into_iter().chain(axes))
    }
}

/// Parses the description of a static copy of a curve. Returns the name of the copy, which is empty if it is to be
/// chosen automatically, and the number of the curve.
pub fn parse_static_copy(value: &Value) -> Result<(String, i64), Refusal> {
    let keys = CheckedMap::new("a copy", value, &["name", "curve"])?;
    match keys.count("curve", 1..=i64::from(u32::MAX))? {
        Some(curve) => Ok((keys.text("name")?, curve)),
        None => keys.invalid_value("curve", "the number of a curve, from 1"),
    }
}

/// Description of a graph in a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GraphSpec {
    /// Whether the graph records only on request.
    pub explicit: bool,
    /// Maximum number of samples stored per stream.
    pub buffer: usize,
    /// Streams that the graph records, in order.
    pub streams: Vec<StreamSpec>,
    /// Curves of one stream over another.
    pub curves: Vec<CurveSpec>,
}

impl Default for GraphSpec {
    fn default() -> Self {
        GraphSpec { explicit: false, buffer: 10_000, streams: Vec::new(), curves: Vec::new() }
    }
}

fn list<T>(all: &[T], value: impl Fn(&T) -> Value) -> Value {
    Value::List(all.iter().map(value).collect())
}

fn read_list<T>(value: &Value, read: impl Fn(&Value) -> Result<T, Refusal>) -> Result<Vec<T>, String> {
    let Value::List(all) = value else { return unexpected(value) };
    refusal_as_text(all.iter().map(read).collect())
}

properties! { PROPERTIES: GraphSpec, PropertyOwner::Kind(ObjectKind::Graph) =>
    "graph.explicit" bool = false, None explicit: "Whether the graph records only on request; otherwise, it records at the end of each step.";
    "graph.buffer" int from 1.0 to (MAX_GRAPH_SAMPLES as f64) = 10_000, Graph buffer: "Number of samples of each stream that the graph stores; the oldest samples are discarded.";
    "graph.streams" list = none, Graph { get |g: &GraphSpec| list(&g.streams, StreamSpec::to_value), set |g: &mut GraphSpec, v| { g.streams = read_list(v, StreamSpec::from_value)?; Ok(true) } }: "Streams that the graph records: name, unit, color, of, data, transform, factor, offset, window, hidden.";
    "graph.curves" list = none, Graph { get |g: &GraphSpec| list(&g.curves, CurveSpec::to_value), set |g: &mut GraphSpec, v| { g.curves = read_list(v, CurveSpec::from_value)?; Ok(true) } }: "Curves of one stream against another: name, x, y, z, unit, color.";
}
