//! Drawings: points, lines, faces and small solids in space.

use std::collections::VecDeque;

use nalgebra::{Isometry3, Point3, Vector3};
use serde::{Deserialize, Serialize};
use tatu_errors::Refusal;
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_scene::graph::{CheckedMap, map};

/// The form of the items of a drawing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names are self-explanatory")]
pub enum DrawingForm {
    Points,
    Lines,
    Triangles,
    /// Small flat or solid marks, like all following `*Points`. All of them except `SpherePoints` have a normal.
    TrianglePoints,
    QuadPoints,
    DiscPoints,
    CubePoints,
    SpherePoints,
    /// Points, each of which is connected to the previous one.
    LineStrip,
}

impl DrawingForm {
    const NAMES: [&str; 9] = [
        "points",
        "lines",
        "triangles",
        "triangle_points",
        "quad_points",
        "disc_points",
        "cube_points",
        "sphere_points",
        "line_strip",
    ];

    fn parse(name: &str) -> Option<Self> {
        use DrawingForm::*;
        let all =
            [Points, Lines, Triangles, TrianglePoints, QuadPoints, DiscPoints, CubePoints, SpherePoints, LineStrip];
        Self::NAMES.iter().position(|n| *n == name).map(|i| all[i])
    }
    /// Returns the form's name.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
    /// Returns the number of points of an item, and whether a normal follows them.
    pub fn layout(self) -> (usize, bool) {
        match self {
            DrawingForm::Points | DrawingForm::SpherePoints | DrawingForm::LineStrip => (1, false),
            DrawingForm::Lines => (2, false),
            DrawingForm::Triangles => (3, false),
            _ => (1, true),
        }
    }
}

/// A set of items of one form.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Drawing {
    /// The form of its items.
    pub form: DrawingForm,
    /// Size of points and lines, in pixels, or of marks, in m.
    pub size: f64,
    /// Red, green and blue components, from 0 to 1.
    pub color: [f64; 3],
    /// The object to which the drawing is attached; 0 for the world.
    pub parent: tatu_object,
    /// Maximum number of items; 0 stands for [`Drawing::MAX_ITEMS`].
    pub capacity: usize,
    /// Whether a new item replaces the oldest one when the drawing is full.
    pub cyclic: bool,
    /// Maximum distance between a new item and an existing one, m, at which the new item is not added; 0 if all are
    /// added. The first points of the items are compared.
    pub tolerance: f64,
    /// Whether the drawing is retained when the run stops.
    pub persistent: bool,
    /// Number of values that follow the points and normal of an item, for an individual colour, size and transparency.
    pub extra: usize,
    /// Items in the parent's frame: points, normal, and extra values.
    pub items: VecDeque<Vec<f64>>,
}

impl Drawing {
    const KEYS: &[&str] =
        &["form", "size", "color", "parent", "capacity", "cyclic", "tolerance", "persistent", "extra"];
    /// Maximum number of items of any drawing.
    pub const MAX_ITEMS: usize = 1_000_000;

    /// Parses a drawing from a table; `form` is required.
    pub fn from_value(value: &Value) -> Result<Self, Refusal> {
        let keys = CheckedMap::new("a drawing", value, Self::KEYS)?;
        let Some(form) = DrawingForm::parse(&keys.text("form")?) else {
            return keys.invalid_value("form", &format!("one of {}", DrawingForm::NAMES.join(", ")));
        };
        Ok(Drawing {
            form,
            size: keys.number("size")?.unwrap_or(1.0),
            color: keys.color("color")?.unwrap_or([1.0, 0.0, 0.0]),
            parent: keys.object("parent")?,
            capacity: keys.count("capacity", 0..=Self::MAX_ITEMS as i64)?.unwrap_or(0) as usize,
            cyclic: keys.flag("cyclic")?,
            tolerance: keys.number("tolerance")?.unwrap_or(0.0),
            persistent: keys.flag("persistent")?,
            extra: keys.count("extra", 0..=16)?.unwrap_or(0) as usize,
            items: VecDeque::new(),
        })
    }
    /// Converts the drawing to a table, without its items.
    pub fn entries(&self) -> Value {
        map([
            ("form", Value::text(self.form.name())),
            ("size", Value::Float(self.size)),
            ("color", Value::Floats(self.color.to_vec())),
            ("parent", Value::Object(self.parent)),
            ("capacity", Value::Int(self.capacity as i64)),
            ("cyclic", Value::Bool(self.cyclic)),
            ("tolerance", Value::Float(self.tolerance)),
            ("persistent", Value::Bool(self.persistent)),
            ("extra", Value::Int(self.extra as i64)),
        ])
    }
    /// Returns the number of values of an item.
    pub fn stride(&self) -> usize {
        let (points, normal) = self.form.layout();
        3 * (points + usize::from(normal)) + self.extra
    }
    /// Applies a transform to an item.
    fn moved(&self, item: &[f64], by: &Isometry3<f64>) -> Vec<f64> {
        let (points, normal) = self.form.layout();
        let mut out = item.to_vec();
        for (i, three) in out.chunks_exact_mut(3).take(points + usize::from(normal)).enumerate() {
            let v = Vector3::new(three[0], three[1], three[2]);
            let v = if i < points { (by * Point3::from(v)).coords } else { by.rotation * v };
            three.copy_from_slice(v.as_slice());
        }
        out
    }
    /// Adds items, given as concatenated values in world coordinates; `frame` is the parent's pose. Returns the number
    /// of items added. Items that are too close to existing ones are not added, nor are those beyond the capacity,
    /// unless the drawing is cyclic.
    pub fn add(&mut self, items: &[f64], frame: &Isometry3<f64>) -> Result<usize, Refusal> {
        let stride = self.stride();
        if items.is_empty() || !items.len().is_multiple_of(stride) || !items.iter().all(|x| x.is_finite()) {
            let text = format!(
                "the items of a drawing of `{}` must be finite numbers, {stride} per item; found {} numbers",
                self.form.name(),
                items.len()
            );
            return Err(Refusal(TATU_ERR_ARGUMENT, text));
        }
        let (into, most) = (frame.inverse(), if self.capacity == 0 { Self::MAX_ITEMS } else { self.capacity });
        let mut added = 0;
        for item in items.chunks_exact(stride) {
            let item = self.moved(item, &into);
            let near = |other: &Vec<f64>| {
                let apart = |i: usize| (item[i] - other[i]).powi(2);
                apart(0) + apart(1) + apart(2) <= self.tolerance * self.tolerance
            };
            if self.tolerance > 0.0 && self.items.iter().any(near) {
                continue;
            }
            if self.items.len() >= most {
                if !self.cyclic {
                    break;
                }
                self.items.pop_front();
            }
            self.items.push_back(item);
            added += 1;
        }
        Ok(added)
    }
    /// Returns the concatenated values of all items, in world coordinates.
    pub fn in_world(&self, frame: &Isometry3<f64>) -> Vec<f64> {
        self.items.iter().flat_map(|item| self.moved(item, frame)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(capacity: usize, cyclic: bool, tolerance: f64) -> Drawing {
        let value = map([
            ("form", Value::text("points")),
            ("capacity", Value::Int(capacity as i64)),
            ("cyclic", Value::Bool(cyclic)),
            ("tolerance", Value::Float(tolerance)),
        ]);
        Drawing::from_value(&value).unwrap()
    }
    const ORIGIN: fn() -> Isometry3<f64> = Isometry3::identity;

    #[test]
    fn full_drawing_refuses_items_or_drops_the_oldest() {
        let mut full = points(2, false, 0.0);
        assert_eq!(full.add(&[0.0; 9], &ORIGIN()), Ok(2));
        assert_eq!(full.add(&[1.0, 0.0, 0.0], &ORIGIN()), Ok(0));
        let mut ring = points(2, true, 0.0);
        for x in 0..4 {
            assert_eq!(ring.add(&[f64::from(x), 0.0, 0.0], &ORIGIN()), Ok(1));
        }
        assert_eq!(ring.in_world(&ORIGIN()), [2.0, 0.0, 0.0, 3.0, 0.0, 0.0]);
    }

    #[test]
    fn items_too_close_to_others_are_not_added() {
        let mut d = points(0, false, 0.1);
        assert_eq!(d.add(&[0.0, 0.0, 0.0, 0.05, 0.0, 0.0, 0.2, 0.0, 0.0], &ORIGIN()), Ok(2));
        assert!(d.add(&[1.0, 2.0], &ORIGIN()).is_err() && d.add(&[f64::NAN, 0.0, 0.0], &ORIGIN()).is_err());
    }

    #[test]
    fn items_move_with_their_object() {
        let mut d = points(0, false, 0.0);
        let at = |x: f64| Isometry3::translation(x, 0.0, 0.0);
        assert_eq!(d.add(&[3.0, 1.0, 0.0], &at(2.0)), Ok(1));
        assert_eq!(d.in_world(&at(5.0)), [6.0, 1.0, 0.0]);
    }
}
