//! Writes forms, with their colours.

use std::collections::BTreeMap;

use nalgebra::Isometry3;
use tatu_exporters_common::{
    ExportReport, Form, MeshFiles, Part, XmlWriter, ellipsoid_mesh, number, numbers, roll_pitch_yaw,
};

/// Thickness of the box that stands for a plane, m.
const PLANE_THICKNESS: f64 = 0.01;

/// The materials of a robot, by colour.
#[derive(Default)]
pub struct Materials {
    names: BTreeMap<[u64; 4], String>,
    colors: Vec<[f64; 4]>,
}

impl Materials {
    /// Adds the colour of a part.
    pub fn add(&mut self, rgba: [f64; 4]) {
        let colors = &mut self.colors;
        self.names.entry(rgba.map(f64::to_bits)).or_insert_with(|| {
            colors.push(rgba);
            format!("color_{}", colors.len())
        });
    }

    /// Writes all materials.
    pub fn write(&self, xml: &mut XmlWriter) {
        for (i, rgba) in self.colors.iter().enumerate() {
            xml.begin("material", &[("name", format!("color_{}", i + 1))]);
            xml.empty("color", &[("rgba", numbers(*rgba))]);
            xml.end();
        }
    }

    fn name(&self, rgba: [f64; 4]) -> &str {
        self.names.get(&rgba.map(f64::to_bits)).map_or("", String::as_str)
    }
}

/// Writes an `<origin>`, unless it is the identity.
pub fn write_origin(xml: &mut XmlWriter, pose: &Isometry3<f64>) {
    let angles = roll_pitch_yaw(&pose.rotation);
    let place = pose.translation.vector;
    let mut attributes = Vec::new();
    if place != nalgebra::Vector3::zeros() {
        attributes.push(("xyz", numbers([place.x, place.y, place.z])));
    }
    if angles != [0.0; 3] {
        attributes.push(("rpy", numbers(angles)));
    }
    if !attributes.is_empty() {
        xml.empty("origin", &attributes);
    }
}

/// A part with the pose of its body in the frame of the link.
pub struct PlacedPart<'a> {
    /// The part.
    pub part: &'a Part,
    /// Pose in the frame of the link.
    pub pose: Isometry3<f64>,
    /// Name of the part's object.
    pub alias: &'a str,
    /// Path of the part's object.
    pub path: &'a str,
}

/// Writes the `<visual>` or `<collision>` of a part, or several that form it.
pub fn write_part(
    xml: &mut XmlWriter,
    placed: &PlacedPart<'_>,
    materials: Option<&Materials>,
    meshes: &mut MeshFiles,
    report: &mut ExportReport,
) {
    let element = if materials.is_some() { "visual" } else { "collision" };
    let mut write = |pose: &Isometry3<f64>, form: &str, attributes: &[(&str, String)]| {
        xml.begin(element, &[]);
        write_origin(xml, pose);
        xml.begin("geometry", &[]);
        xml.empty(form, attributes);
        xml.end();
        if let Some(materials) = materials {
            xml.empty("material", &[("name", materials.name(placed.part.look.rgba).to_owned())]);
        }
        xml.end();
    };
    let ball = |radius: f64| [("radius", number(radius))];
    let pose = &placed.pose;
    match &placed.part.form {
        Form::Box(size) => write(pose, "box", &[("size", numbers(*size))]),
        Form::Sphere { radius } => write(pose, "sphere", &ball(*radius)),
        Form::Cylinder { radius, length } => {
            write(pose, "cylinder", &[("radius", number(*radius)), ("length", number(*length))]);
        }
        Form::Capsule { radius, length } => {
            report.note("URDF has no capsules: each is a cylinder and two spheres", placed.path);
            if *length > 0.0 {
                write(pose, "cylinder", &[("radius", number(*radius)), ("length", number(*length))]);
                for end in [-length / 2.0, length / 2.0] {
                    write(&(pose * Isometry3::translation(0.0, 0.0, end)), "sphere", &ball(*radius));
                }
            } else {
                write(pose, "sphere", &ball(*radius));
            }
        }
        Form::Ellipsoid(size) => {
            report.lost("URDF has no ellipsoids: each is a mesh", placed.path);
            let (points, triangles) = ellipsoid_mesh(*size);
            let name = meshes.add(placed.alias, &points, &triangles);
            write(pose, "mesh", &[("filename", name)]);
        }
        Form::Plane([x, y]) => {
            report.lost("URDF has no planes: each is a thin box", placed.path);
            let below = pose * Isometry3::translation(0.0, 0.0, -PLANE_THICKNESS / 2.0);
            write(&below, "box", &[("size", numbers([*x, *y, PLANE_THICKNESS]))]);
        }
        Form::Mesh { points, triangles } => {
            if materials.is_none() && placed.part.surface.is_some_and(|s| !s.convex) {
                report.note(
                    "meshes that collide with their hollows: URDF leaves it to the program whether they do",
                    placed.path,
                );
            }
            let name = meshes.add(placed.alias, points, triangles);
            write(pose, "mesh", &[("filename", name)]);
        }
    }
}
