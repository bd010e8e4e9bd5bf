//! Converts geometries to shapes.

use std::{collections::BTreeMap, rc::Rc};

use nalgebra::{Isometry3, Vector3};
use tatu_importers_common::{MeshPiece, ShapeBuilder, merge_pieces};
use tatu_plugin_api::safe::{Builder, Node, Result, Value};

use crate::{mesh, robot::Geometry, tree::check_finite};

/// A validated geometry, placed in the frame of a body.
#[derive(Debug, Clone)]
pub struct PlacedSolid {
    /// Pose of the centre of the geometry.
    pub pose: Isometry3<f64>,
    /// The primitive or mesh.
    pub form: SolidForm,
}

/// A primitive of the host with its full extents, or a scaled mesh.
#[derive(Debug, Clone)]
pub enum SolidForm {
    Primitive(&'static str, [f64; 3]),
    Mesh(Rc<[MeshPiece]>),
}

/// The reason why a geometry is left out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Defect {
    Mesh(String),
    Form(String),
}

/// A mesh, or the reason for which it could not be read.
type MeshResult = Result<Rc<[MeshPiece]>, String>;

/// Meshes by name and scale, so that each file is read once.
#[derive(Default)]
pub struct MeshCache {
    known: BTreeMap<(String, [u64; 3]), MeshResult>,
    shapes: ShapeBuilder,
    /// Notes on omitted parts of meshes.
    pub notes: Vec<String>,
}

impl PlacedSolid {
    /// Validates a geometry. The error for a mesh that cannot be read, and for a length that is not positive, is a
    /// sentence.
    pub fn read(
        geometry: &Geometry,
        pose: Isometry3<f64>,
        what: &str,
        line: u64,
        meshes: &mut MeshCache,
        source: (&Builder<'_>, &str),
    ) -> Result<PlacedSolid, Defect> {
        let finite = |numbers: &[f64]| check_finite(numbers, what, line).map_err(|e| Defect::Form(e.text().to_owned()));
        let positive = |numbers: &[f64]| {
            finite(numbers)?;
            match numbers.iter().find(|x| **x <= 0.0) {
                Some(x) => Err(Defect::Form(format!("{what}: expected a length greater than 0, found {x}"))),
                None => Ok(()),
            }
        };
        let form = match geometry {
            Geometry::Box { size } => {
                positive(size)?;
                SolidForm::Primitive("box", *size)
            }
            Geometry::Sphere { radius } => {
                positive(&[*radius])?;
                SolidForm::Primitive("sphere", [2.0 * radius; 3])
            }
            Geometry::Cylinder { radius, length } => {
                positive(&[*radius, *length])?;
                SolidForm::Primitive("cylinder", [2.0 * radius, 2.0 * radius, *length])
            }
            Geometry::Ellipsoid { radii } => {
                positive(radii)?;
                SolidForm::Primitive("sphere", radii.map(|r| 2.0 * r))
            }
            Geometry::Plane { size: [x, y] } => {
                positive(&[*x, *y])?;
                SolidForm::Primitive("plane", [*x, *y, 0.1])
            }
            // The length is that of the cylindrical part, without the caps.
            Geometry::Capsule { radius, length } => {
                positive(&[*radius, *length])?;
                SolidForm::Primitive("capsule", [2.0 * radius, 2.0 * radius, length + 2.0 * radius])
            }
            Geometry::Mesh { filename, scale } => {
                let scale = scale.unwrap_or([1.0; 3]);
                finite(&scale)?;
                let why = |why| Defect::Mesh(format!("{what}: the mesh `{filename}` is ignored: {why}"));
                SolidForm::Mesh(meshes.get(filename, scale, source).map_err(why)?)
            }
        };
        Ok(PlacedSolid { pose, form })
    }

    /// Returns whether the geometry is a plane, which has no end.
    pub fn is_plane(&self) -> bool {
        matches!(self.form, SolidForm::Primitive("plane", _))
    }

    /// Returns the geometry as a part of a compound. A mesh collides as its convex hull if `convex` is set.
    pub fn part(&self, builder: &Builder<'_>, convex: bool, friction: Option<f64>) -> Result<Value> {
        let text = |s: &str| Value::text(s);
        let (primitive, size) = match &self.form {
            SolidForm::Primitive(p, size) => (*p, *size),
            SolidForm::Mesh(_) => ("mesh", [1.0; 3]),
        };
        let q = self.pose.rotation.coords;
        let mut part = vec![
            (text("primitive"), text(primitive)),
            (text("size"), Value::from(size)),
            (text("position"), Value::from(<[f64; 3]>::from(self.pose.translation.vector))),
            (text("quaternion"), Value::from([q.x, q.y, q.z, q.w])),
        ];
        part.extend(friction.map(|friction| (text("friction"), Value::Float(friction))));
        if let SolidForm::Mesh(pieces) = &self.form {
            let (points, triangles) = merge_pieces(pieces);
            part.push((text("mesh"), Value::Int(builder.mesh(&points, &triangles)?)));
            part.push((text("convex"), Value::Bool(convex)));
        }
        Ok(Value::Map(part))
    }

    /// Returns convex meshes that together have about the form of a mesh, at most `most`; none for other forms, and for a
    /// mesh that is convex.
    pub fn convex_parts(&self, most: u32) -> Vec<PlacedSolid> {
        let SolidForm::Mesh(pieces) = &self.form else { return Vec::new() };
        if most == 0 {
            return Vec::new();
        }
        let (points, triangles) = merge_pieces(pieces);
        let vertices = points.into_iter().map(nalgebra::Point3::from).collect();
        let mesh = tatu_geometry::Mesh { vertices, triangles, coordinates: Vec::new() };
        let solid = |part: tatu_geometry::Mesh| {
            let points = part.vertices.iter().map(|p| p.coords.into()).collect();
            let piece = MeshPiece { points, triangles: part.triangles, ..MeshPiece::default() };
            PlacedSolid { pose: self.pose, form: SolidForm::Mesh(vec![piece].into()) }
        };
        tatu_physics::convex_parts(&mesh, most).into_iter().map(solid).collect()
    }

    /// Returns points of the surface, in the frame of the body: the corners of boxes and meshes, and of round forms the
    /// ends of axes and 24 points of each circle.
    pub fn surface_points(&self) -> Vec<Vector3<f64>> {
        let moved = |p: Vector3<f64>| (self.pose * nalgebra::Point3::from(p)).coords;
        match &self.form {
            SolidForm::Primitive("box", size) => {
                let half = Vector3::from(*size) / 2.0;
                let sign = |i: usize, axis: usize| if i >> axis & 1 == 0 { -1.0 } else { 1.0 };
                let corner = |i: usize| half.component_mul(&Vector3::new(sign(i, 0), sign(i, 1), sign(i, 2)));
                (0..8).map(|i| moved(corner(i))).collect()
            }
            SolidForm::Primitive("plane", _) => Vec::new(),
            SolidForm::Primitive("sphere", [x, y, z]) if x != y || y != z => {
                let ends = [Vector3::x() * *x, Vector3::y() * *y, Vector3::z() * *z];
                ends.into_iter().flat_map(|end| [end / 2.0, -end / 2.0]).map(moved).collect()
            }
            SolidForm::Primitive(form, [d, _, length]) => {
                let (radius, half) = (d / 2.0, length / 2.0);
                let ring = if *form == "cylinder" { half } else { half - radius };
                let on_circle = |i: usize| {
                    let angle = i as f64 * std::f64::consts::PI / 12.0;
                    (radius * libm::cos(angle), radius * libm::sin(angle))
                };
                let circle = |z: f64| (0..24).map(on_circle).map(move |(x, y)| Vector3::new(x, y, z));
                let ends = [Vector3::new(0.0, 0.0, half), Vector3::new(0.0, 0.0, -half)];
                circle(ring).chain(circle(-ring)).chain(ends).map(moved).collect()
            }
            SolidForm::Mesh(pieces) => {
                pieces.iter().flat_map(|p| &p.points).map(|p| moved(Vector3::from(*p))).collect()
            }
        }
    }

    /// Returns the height of the lowest point if the frame of the body has this pose, m.
    pub fn lowest(&self, body: &Isometry3<f64>) -> f64 {
        let at = body * self.pose;
        let z = at.translation.z;
        // The directions of the axes of the form that point downward.
        let down = at.rotation.inverse() * Vector3::z();
        match &self.form {
            SolidForm::Primitive("box", size) => z - down.abs().dot(&(Vector3::from(*size) / 2.0)),
            SolidForm::Primitive("cylinder", [d, _, length]) => {
                z - down.xy().norm() * d / 2.0 - down.z.abs() * length / 2.0
            }
            SolidForm::Primitive("plane", _) => f64::MAX,
            SolidForm::Primitive("sphere", size) => z - down.component_mul(&(Vector3::from(*size) / 2.0)).norm(),
            SolidForm::Primitive(_, [d, _, length]) => z - d / 2.0 - down.z.abs() * (length - d) / 2.0,
            SolidForm::Mesh(pieces) => {
                let heights = pieces.iter().flat_map(|p| &p.points).map(|p| (at * nalgebra::Point3::from(*p)).z);
                heights.fold(f64::MAX, f64::min)
            }
        }
    }

    /// Sets up `node` as a shape with this geometry and pose. `color` is red, green, blue and opacity; without
    /// it, a mesh has its own materials.
    pub fn shape<'a>(
        &self,
        builder: &Builder<'a>,
        node: Node<'a>,
        color: Option<[f64; 4]>,
        meshes: &mut MeshCache,
    ) -> Result<Node<'a>> {
        let [r, g, b, opacity] = color.unwrap_or([0.7, 0.7, 0.7, 1.0]);
        let node = set_object_pose(node, &self.pose)?.set("shape.color", [r, g, b])?;
        if opacity < 1.0 {
            node.set("shape.opacity", opacity)?;
        }
        match &self.form {
            SolidForm::Primitive(p, size) => node.set("shape.primitive", *p)?.set("shape.size", *size),
            SolidForm::Mesh(pieces) => meshes.shapes.shape(builder, node, pieces, color.is_none()),
        }
    }
}

/// Sets the pose of an object relative to its parent.
pub fn set_object_pose<'a>(node: Node<'a>, pose: &Isometry3<f64>) -> Result<Node<'a>> {
    let q = pose.rotation.coords;
    node.set("object.position", <[f64; 3]>::from(pose.translation.vector))?
        .set("object.quaternion", [q.x, q.y, q.z, q.w])
}

impl MeshCache {
    fn get(&mut self, name: &str, scale: [f64; 3], (builder, package_root): (&Builder<'_>, &str)) -> MeshResult {
        let key = (name.to_owned(), scale.map(f64::to_bits));
        let known = self.known.entry(key).or_insert_with(|| {
            // The up axis of the file is ignored, as in RViz and Gazebo.
            let read = mesh::find(builder, name, package_root)?;
            self.notes.extend(read.notes.iter().map(|note| format!("the mesh `{name}`: {note}")));
            let mut pieces = read.model.pieces;
            if scale != [1.0; 3] {
                pieces.iter_mut().for_each(|p| *p = p.moved(scale, &Isometry3::identity()));
            }
            Ok(pieces.into())
        });
        known.clone()
    }
}
