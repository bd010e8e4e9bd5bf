//! Streams and curves as scene files and plugins describe them: tables of a few keys.

use serde::{Deserialize, Serialize};
use tatu_errors::Refusal;
use tatu_plugin_api::{abi::*, safe::Value};

use super::values::{Keys, map};

/// Most samples of a stream.
pub const MOST_SAMPLES: i64 = 1_000_000;

/// Colours for those that name none, in order: dark enough on white, distinct to most people (Okabe and Ito's).
const COLORS: [[f64; 3]; 7] = [
    [0.0, 0.45, 0.70],
    [0.84, 0.37, 0.0],
    [0.0, 0.62, 0.45],
    [0.80, 0.47, 0.65],
    [0.90, 0.62, 0.0],
    [0.34, 0.71, 0.91],
    [0.25, 0.25, 0.25],
];

/// The colour of the `i`-th of those that name none.
pub fn color(i: usize) -> [f64; 3] {
    COLORS[i % COLORS.len()]
}

/// What is made of the numbers of a stream, before factor, offset and average.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[allow(missing_docs, reason = "named after what they are")]
pub enum Transform {
    #[default]
    Raw,
    /// Change per second since the sample before; the first has none.
    Derivative,
    /// Sum of the trapezoids under it.
    Integral,
    /// Sum of all samples.
    Cumulative,
}

impl Transform {
    /// Its names, in order of their numbers.
    pub const NAMES: [&str; 4] = ["raw", "derivative", "integral", "cumulative"];

    /// By its name; empty: raw.
    fn parse(name: &str) -> Option<Self> {
        let all = [Self::Raw, Self::Derivative, Self::Integral, Self::Cumulative];
        if name.is_empty() { Some(Self::Raw) } else { Self::NAMES.iter().position(|n| *n == name).map(|i| all[i]) }
    }
    /// Its name.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}

/// One number over time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct StreamSpec {
    /// Its name in the graph.
    pub name: String,
    /// Unit of what is shown; for people.
    pub unit: String,
    /// Red, green, blue, 0 to 1; none: chosen by its place.
    pub color: Option<[f64; 3]>,
    /// Path of the object whose number it is; empty: a script sets it.
    pub of: String,
    /// Which number: "x", "speed", "joint.position", `object.world_pose[2]`, a field of a reading.
    pub data: String,
    /// What is made of it,
    pub transform: Transform,
    /// then times this,
    pub factor: f64,
    /// and more by this,
    pub offset: f64,
    /// and the mean of so many samples at last.
    pub window: u32,
    /// Recorded, but not drawn.
    pub hidden: bool,
}

impl StreamSpec {
    const KEYS: &[&str] = &["name", "unit", "color", "of", "data", "transform", "factor", "offset", "window", "hidden"];

    /// From a table.
    pub fn from_value(value: &Value) -> Result<Self, Refusal> {
        let blank = StreamSpec { factor: 1.0, window: 1, ..Default::default() };
        let spec = blank.with(value)?;
        if spec.name.is_empty() {
            return Err(Refusal(TATU_ERR_ARGUMENT, "a stream has a `name`".into()));
        }
        if spec.of.is_empty() != spec.data.is_empty() {
            let text = format!("the stream `{}` has `of` or `data` without the other: give both or neither", spec.name);
            return Err(Refusal(TATU_ERR_ARGUMENT, text));
        }
        Ok(spec)
    }
    /// Itself, with what a table says.
    pub fn with(&self, value: &Value) -> Result<Self, Refusal> {
        let keys = Keys::new("a stream", value, Self::KEYS)?;
        let other =
            |now: &String, key| Ok(Some(keys.text(key)?).filter(|t: &String| !t.is_empty()).unwrap_or(now.clone()));
        let name = keys.text("transform")?;
        let transform = match Transform::parse(&name) {
            Some(Transform::Raw) if name.is_empty() => self.transform,
            Some(t) => t,
            None => return keys.wrong("transform", &format!("one of {}", Transform::NAMES.join(", "))),
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
    /// As a table.
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

/// One coordinate of a curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Axis {
    /// A stream, by name.
    Stream(String),
    /// Always this.
    Always(f64),
}

/// A curve of one stream over another, or of three in space.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CurveSpec {
    /// Its name in the graph.
    pub name: String,
    /// Unit of its axes; for people.
    pub unit: String,
    /// Red, green, blue, 0 to 1; none: chosen by its place.
    pub color: Option<[f64; 3]>,
    /// 2 or 3 coordinates.
    pub axes: Vec<Axis>,
}

impl CurveSpec {
    const KEYS: &[&str] = &["name", "unit", "color", "x", "y", "z"];

    /// From a table.
    pub fn from_value(value: &Value) -> Result<Self, Refusal> {
        let keys = Keys::new("a curve", value, Self::KEYS)?;
        let name = keys.text("name")?;
        if name.is_empty() {
            return Err(Refusal(TATU_ERR_ARGUMENT, "a curve has a `name`".into()));
        }
        let mut axes = Vec::new();
        for key in ["x", "y", "z"] {
            match keys.text_or_number(key)? {
                Some(Err(stream)) => axes.push(Axis::Stream(stream)),
                Some(Ok(number)) => axes.push(Axis::Always(number)),
                None if key == "z" => {}
                None => return keys.wrong(key, "the name of a stream, or a number"),
            }
        }
        Ok(CurveSpec { name, unit: keys.text("unit")?, color: keys.color("color")?, axes })
    }
    /// As a table.
    pub fn to_value(&self) -> Value {
        let axes = ["x", "y", "z"].into_iter().zip(&self.axes).map(|(key, axis)| match axis {
            Axis::Stream(name) => (key, Value::text(name)),
            Axis::Always(x) => (key, Value::Float(*x)),
        });
        let rest = [
            ("name", Value::text(&self.name)),
            ("unit", Value::text(&self.unit)),
            ("color", self.color.map_or(Value::Nil, |c| Value::Floats(c.to_vec()))),
        ];
        map(rest.into_iter().chain(axes))
    }
}

/// What a copy of a curve is to be: its name (empty: chosen), and the number of the curve.
pub fn keys_of(value: &Value) -> Result<(String, i64), Refusal> {
    let keys = Keys::new("a copy", value, &["name", "curve"])?;
    match keys.count("curve", 1..=i64::from(u32::MAX))? {
        Some(curve) => Ok((keys.text("name")?, curve)),
        None => keys.wrong("curve", "the number of a curve"),
    }
}

/// A graph as the scene describes it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GraphSpec {
    /// Records only on request.
    pub explicit: bool,
    /// Samples of a stream that it keeps.
    pub buffer: usize,
    /// What it records.
    pub streams: Vec<StreamSpec>,
    /// Curves of one stream over another.
    pub curves: Vec<CurveSpec>,
}

impl Default for GraphSpec {
    fn default() -> Self {
        GraphSpec { explicit: false, buffer: 10_000, streams: Vec::new(), curves: Vec::new() }
    }
}
