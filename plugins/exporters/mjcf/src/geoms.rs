//! Writes forms.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Vector3};
use tatu_exporters_common::{
    ExportReport, Form, Mechanisms, MeshFiles, NameSpace, Part, Surface, XmlWriter, number, numbers,
};

use crate::{masks::Masks, naming::Names};

/// Group of forms that are only seen, which viewers show.
const SEEN: &str = "2";
/// Group of forms that only collide, which viewers hide.
const HIDDEN: &str = "3";
/// Extents from which on a plane has no end, m.
const ENDLESS: f64 = 1000.0;
/// Distance of the lines that viewers draw on a plane, m.
const GRID: f64 = 1.0;
/// MuJoCo's friction against spinning and rolling, m, where the scene has none.
const DEFAULT_FRICTION: [f64; 2] = [0.005, 0.0001];

/// The meshes of the file.
#[derive(Default)]
pub struct Meshes {
    /// The mesh files.
    pub files: MeshFiles,
    /// Names of meshes, by file.
    pub names: BTreeMap<String, String>,
    taken: NameSpace,
}

impl Meshes {
    fn add(&mut self, alias: &str, points: &[[f64; 3]], triangles: &[[u32; 3]]) -> String {
        let file = self.files.add(alias, points, triangles);
        let stem = file.rsplit('/').next().and_then(|f| f.strip_suffix(".obj")).unwrap_or(&file);
        let taken = &mut self.taken;
        self.names.entry(file.clone()).or_insert_with(|| taken.derived(stem)).clone()
    }
}

/// Adds `pos` and `quat` of a pose to attributes, unless they are the defaults.
pub fn add_pose(attributes: &mut Vec<(&'static str, String)>, pose: &Isometry3<f64>) {
    let place = pose.translation.vector;
    if place != Vector3::zeros() {
        attributes.push(("pos", numbers([place.x, place.y, place.z])));
    }
    let q = pose.rotation.coords;
    if q.xyz() != Vector3::zeros() {
        attributes.push(("quat", numbers([q.w, q.x, q.y, q.z])));
    }
}

/// Returns whether points span a volume, so that they have a convex hull.
fn is_solid(points: &[[f64; 3]]) -> bool {
    let at = |i: usize| Vector3::from(points[i]);
    let Some(first) = (!points.is_empty()).then(|| at(0)) else { return false };
    let all = || points.iter().map(|p| Vector3::from(*p) - first);
    let farthest = |along: &dyn Fn(&Vector3<f64>) -> f64| {
        all().fold((0.0f64, Vector3::zeros()), |best, p| if along(&p) > best.0 { (along(&p), p) } else { best })
    };
    let (length, axis) = farthest(&|p| p.norm());
    let (area, side) = farthest(&|p| axis.cross(p).norm());
    let (height, _) = farthest(&|p| axis.cross(&side).dot(p).abs());
    length > 0.0 && area > 1e-9 * length * length && height > 1e-9 * length * length * length
}

/// Writes the geom of a part.
pub fn write_geom(
    xml: &mut XmlWriter,
    all: &Mechanisms,
    (body, part): (usize, &Part),
    masks: &Masks,
    names: &mut Names,
    meshes: &mut Meshes,
    report: &mut ExportReport,
) {
    let item = &all.items[part.item];
    let mut surface = part.surface;
    let mut attributes: Vec<(&'static str, String)> = Vec::new();
    // The form that stands for the body itself needs no name, and its name can be that of another shape.
    if all.bodies[body].item != Some(part.item) {
        attributes.push(("name", names.geoms.derived(&item.alias)));
    }
    let (kind, size) = match &part.form {
        Form::Box([x, y, z]) => ("box", vec![x / 2.0, y / 2.0, z / 2.0]),
        Form::Sphere { radius } => ("sphere", vec![*radius]),
        Form::Capsule { radius, length } if *length == 0.0 => ("sphere", vec![*radius]),
        Form::Ellipsoid([x, y, z]) => ("ellipsoid", vec![x / 2.0, y / 2.0, z / 2.0]),
        Form::Cylinder { radius, length } => ("cylinder", vec![*radius, length / 2.0]),
        Form::Capsule { radius, length } => ("capsule", vec![*radius, length / 2.0]),
        Form::Plane(_) if body != 0 && all.bodies[body].mass.is_some() => {
            return report.lost("MuJoCo has planes only on what does not move: others are left out", &item.path);
        }
        Form::Plane(extents) => {
            let half = |x: f64| if x >= ENDLESS { 0.0 } else { x / 2.0 };
            ("plane", vec![half(extents[0]), half(extents[1]), GRID])
        }
        Form::Mesh { points, triangles } => {
            if points.len() < 4 || triangles.is_empty() {
                return report.lost("MuJoCo requires four points of a mesh: smaller ones are left out", &item.path);
            }
            if surface.is_some() && !is_solid(points) {
                report.lost(
                    "MuJoCo requires that a mesh that collides has a volume: flat ones do not collide",
                    &item.path,
                );
                surface = None;
                if !part.is_shown {
                    return;
                }
            }
            if surface.is_some_and(|s| !s.convex) {
                report.lost("MuJoCo collides with the convex hulls of meshes: hollows are filled", &item.path);
            }
            attributes.push(("type", "mesh".to_owned()));
            attributes.push(("mesh", meshes.add(&item.alias, points, triangles)));
            ("", Vec::new())
        }
    };
    if !kind.is_empty() {
        attributes.push(("type", kind.to_owned()));
        attributes.push(("size", numbers(size)));
    }
    add_pose(&mut attributes, &part.pose);
    attributes.push(("rgba", numbers(part.look.rgba)));
    match surface {
        Some(surface) => {
            let [contype, conaffinity] = masks.of(all, body, &surface);
            attributes.push(("contype", contype.to_string()));
            attributes.push(("conaffinity", conaffinity.to_string()));
            add_friction(&mut attributes, &surface);
            if !part.is_shown {
                attributes.push(("group", HIDDEN.to_owned()));
            }
        }
        None => {
            let only_seen = [("contype", "0"), ("conaffinity", "0"), ("group", SEEN)];
            attributes.extend(only_seen.map(|(key, value)| (key, value.to_owned())));
        }
    }
    xml.empty("geom", &attributes);
}

fn add_friction(attributes: &mut Vec<(&'static str, String)>, surface: &Surface) {
    let Surface { friction, spinning, rolling, .. } = *surface;
    let condim = match () {
        () if rolling > 0.0 => 6,
        () if spinning > 0.0 => 4,
        () if friction == 0.0 => 1,
        () => 3,
    };
    if condim != 3 {
        attributes.push(("condim", condim.to_string()));
    }
    if condim > 3 {
        let or_default = |x: f64, i: usize| if x > 0.0 || condim == 6 { x } else { DEFAULT_FRICTION[i] };
        attributes.push(("friction", numbers([friction, or_default(spinning, 0), or_default(rolling, 1)])));
    } else if friction != 1.0 {
        attributes.push(("friction", number(friction)));
    }
}
