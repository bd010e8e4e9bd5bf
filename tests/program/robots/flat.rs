//! Reads the objects of a robot from a scene saved by the program, for tests of models.

use toml_edit::{DocumentMut, Item, Table};

use crate::kit::*;

/// An object of the saved scene.
pub struct FlatObject {
    pub alias: String,
    pub kind: String,
    pub parent: Option<usize>,
    table: Table,
}

/// The robot: all objects of its saved scene, parents first.
pub struct FlatRobot {
    pub objects: Vec<FlatObject>,
    place: TestFolder,
}

/// A mesh: points, and triangles whose vertices are counter-clockwise when seen from outside.
pub type TriangleMesh = (Vec<[f64; 3]>, Vec<[usize; 3]>);

/// A pose: position, and quaternion x y z w.
#[derive(Clone, Copy)]
pub struct Frame([f64; 3], [f64; 4]);

impl FlatRobot {
    /// Builds a model with these lines in its scene table.
    pub fn new(model: &str, lines: &str) -> Self {
        let place = TestFolder::scene(&format!("[[model]]\nmodel = \"{model}\"\n{lines}\n"));
        place.tatu(&["convert", "scene.toml", "flat.toml"]).good();
        let doc: DocumentMut = place.read("flat.toml").parse().unwrap();
        let mut objects: Vec<FlatObject> = Vec::new();
        for table in doc["object"].as_array_of_tables().unwrap() {
            let text = |key: &str| table.get(key).and_then(Item::as_str).map(str::to_owned);
            let parent = text("parent").map(|p| objects.iter().position(|o| o.alias == p).unwrap());
            let (alias, kind) = (text("alias").unwrap(), text("kind").unwrap());
            objects.push(FlatObject { alias, kind, parent, table: table.clone() });
        }
        FlatRobot { objects, place }
    }
    /// Returns the object with an alias.
    pub fn get(&self, alias: &str) -> &FlatObject {
        let found = self.objects.iter().find(|o| o.alias == alias);
        found.unwrap_or_else(|| panic!("there is no object {alias}"))
    }
    /// Returns the alias of an object's parent; empty if it has none.
    pub fn parent(&self, object: &FlatObject) -> &str {
        object.parent.map_or("", |i| &self.objects[i].alias)
    }
    /// Returns the frame of an object relative to the world when all joints are at 0.
    pub fn frame(&self, object: &FlatObject) -> Frame {
        let array = |key: &str| if object.has(key) { Some(object.numbers(key)) } else { None };
        let position = array("position_m").map_or([0.0; 3], |p| p.try_into().unwrap());
        let turned = array("orientation_deg").map(|e| {
            let half = |i: usize| (e[i].to_radians() / 2.0).sin_cos();
            let about = |i: usize| {
                let mut q = [0.0, 0.0, 0.0, half(i).1];
                q[i] = half(i).0;
                Frame([0.0; 3], q)
            };
            about(0).then(about(1)).then(about(2)).1
        });
        let quaternion = array("quaternion").map(|q| q.try_into().unwrap()).or(turned).unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let local = Frame(position, quaternion);
        object.parent.map_or(local, |p| self.frame(&self.objects[p]).then(local))
    }
    /// Reads the mesh of an object.
    pub fn mesh(&self, object: &FlatObject) -> TriangleMesh {
        let text = self.place.read(object.table["mesh"].as_str().unwrap());
        let count = |what: &str| -> usize {
            let line = text.lines().find_map(|l| l.strip_prefix(&format!("element {what} ")));
            line.unwrap().parse().unwrap()
        };
        let mut lines = text.lines().skip_while(|l| *l != "end_header").skip(1);
        let points = lines.by_ref().take(count("vertex")).map(|l| {
            let all: Vec<f64> = l.split(' ').map(|x| x.parse().unwrap()).collect();
            all.try_into().unwrap()
        });
        let points = points.collect();
        let triangles = lines.take(count("face")).map(|l| {
            let all: Vec<usize> = l.split(' ').skip(1).map(|x| x.parse().unwrap()).collect();
            all.try_into().unwrap()
        });
        (points, triangles.collect())
    }
}

impl FlatObject {
    pub fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }
    pub fn numbers(&self, key: &str) -> Vec<f64> {
        let Some(item) = self.table.get(key) else { panic!("{} has no {key}", self.alias) };
        numbers_of(item.as_value().unwrap())
    }
    pub fn number(&self, key: &str) -> f64 {
        self.numbers(key)[0]
    }
    /// Returns a Boolean property; false if the key is missing, because false is the default and is not written.
    pub fn is(&self, key: &str) -> bool {
        self.table.get(key).and_then(Item::as_bool) == Some(true)
    }
    /// Returns whether the object is visible in pictures.
    pub fn is_visible(&self) -> bool {
        self.table.get("visible").and_then(Item::as_bool) != Some(false)
    }
    pub fn text(&self, key: &str) -> &str {
        self.table.get(key).and_then(Item::as_str).unwrap_or_else(|| panic!("{} has no {key}", self.alias))
    }
    /// Returns size and position of each part of a compound.
    pub fn parts(&self) -> Vec<(Vec<f64>, Vec<f64>)> {
        let parts = self.table["parts"].as_array().unwrap().iter().map(|p| p.as_inline_table().unwrap());
        parts.map(|p| (numbers_of(&p["size_m"]), p.get("position_m").map_or(vec![0.0; 3], numbers_of))).collect()
    }
}

fn numbers_of(value: &toml_edit::Value) -> Vec<f64> {
    let number = |v: &toml_edit::Value| v.as_float().or_else(|| v.as_integer().map(|i| i as f64)).unwrap();
    value.as_array().map_or_else(|| vec![number(value)], |all| all.iter().map(number).collect())
}

impl Frame {
    fn turn([x, y, z, w]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let t = cross([x, y, z], v).map(|e| 2.0 * e);
        let u = cross([x, y, z], t);
        [v[0] + w * t[0] + u[0], v[1] + w * t[1] + u[1], v[2] + w * t[2] + u[2]]
    }
    pub fn direction(&self, v: [f64; 3]) -> [f64; 3] {
        Self::turn(self.1, v)
    }
    pub fn point(&self, p: [f64; 3]) -> [f64; 3] {
        let d = self.direction(p);
        std::array::from_fn(|i| self.0[i] + d[i])
    }
    pub fn then(&self, Frame(p, [bx, by, bz, bw]): Frame) -> Frame {
        let [x, y, z, w] = self.1;
        let q = [
            w * bx + x * bw + y * bz - z * by,
            w * by - x * bz + y * bw + z * bx,
            w * bz + x * by - y * bx + z * bw,
            w * bw - x * bx - y * by - z * bz,
        ];
        Frame(self.point(p), q)
    }
}

/// Checks that a mesh is closed, and that its triangles face outwards.
#[track_caller]
pub fn is_closed((points, triangles): &TriangleMesh) {
    let mut edges = std::collections::BTreeMap::new();
    let mut volume = 0.0;
    for &[a, b, c] in triangles {
        for edge in [(a, b), (b, c), (c, a)] {
            *edges.entry(edge).or_insert(0) += 1;
        }
        let [p, q, r] = [a, b, c].map(|i| points[i]);
        volume += (p[0] * (q[1] * r[2] - q[2] * r[1])
            + p[1] * (q[2] * r[0] - q[0] * r[2])
            + p[2] * (q[0] * r[1] - q[1] * r[0]))
            / 6.0;
    }
    for (&(a, b), &n) in &edges {
        assert_eq!((n, edges.get(&(b, a))), (1, Some(&1)), "edge {a} {b}");
    }
    // The enclosed volume is positive if the triangles face outwards.
    assert!(volume > 1e-3, "{volume}");
}
