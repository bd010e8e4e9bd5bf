//! Converts URDF geometries to shapes.

use std::{collections::BTreeMap, rc::Rc};

use nalgebra::{Isometry3, Rotation3, Vector3};
use tatu_importers_common::{MeshPiece, ShapeBuilder};
use tatu_plugin_api::safe::{Builder, Fail, Node, Result, Value};

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
    /// Validates a geometry. Returns `Ok(Err(reason))` for a mesh that cannot be read.
    pub fn read(
        geometry: &Geometry,
        pose: Isometry3<f64>,
        what: &str,
        line: u64,
        meshes: &mut MeshCache,
        source: (&Builder<'_>, &str),
    ) -> Result<Result<PlacedSolid, String>> {
        let positive = |numbers: &[f64]| {
            check_finite(numbers, what, line)?;
            match numbers.iter().find(|x| **x <= 0.0) {
                Some(x) => {
                    Err(Fail::argument(format!("{what}: expected a length greater than 0, found {x}")).at("", line))
                }
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
            // In URDF, the length is that of the cylindrical part, without the caps.
            Geometry::Capsule { radius, length } => {
                positive(&[*radius, *length])?;
                SolidForm::Primitive("capsule", [2.0 * radius, 2.0 * radius, length + 2.0 * radius])
            }
            Geometry::Mesh { filename, scale } => {
                let scale = scale.unwrap_or([1.0; 3]);
                check_finite(&scale, what, line)?;
                match meshes.get(filename, scale, source) {
                    Ok(mesh) => SolidForm::Mesh(mesh),
                    Err(why) => return Ok(Err(format!("the mesh `{filename}` is ignored: {why}"))),
                }
            }
        };
        Ok(Ok(PlacedSolid { pose, form }))
    }

    /// Returns the geometry as a part of a compound; a mesh is replaced by its bounding box.
    pub fn part(&self) -> Value {
        let (primitive, size, pose) = match &self.form {
            SolidForm::Primitive(p, size) => (*p, *size, self.pose),
            SolidForm::Mesh(mesh) => {
                let (center, size) = bounds(mesh);
                ("box", size, self.pose * nalgebra::Translation3::from(center))
            }
        };
        let text = |s: &str| Value::text(s);
        Value::Map(vec![
            (text("primitive"), text(primitive)),
            (text("size"), Value::from(size)),
            (text("position"), Value::from(<[f64; 3]>::from(pose.translation.vector))),
            (text("orientation"), Value::from(euler(&pose))),
        ])
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

/// Returns the Euler angles of a pose about x, then the new y, then the new z, rad, as parts of compounds require.
fn euler(pose: &Isometry3<f64>) -> [f64; 3] {
    let r: Rotation3<f64> = pose.rotation.to_rotation_matrix();
    let b = libm::asin(r[(0, 2)].clamp(-1.0, 1.0));
    if libm::cos(b) < 1e-9 {
        // Gimbal lock: the first and third axes coincide, so the whole rotation is assigned to the first angle.
        return [libm::atan2(r[(2, 1)], r[(1, 1)]), b, 0.0];
    }
    [libm::atan2(-r[(1, 2)], r[(2, 2)]), b, libm::atan2(-r[(0, 1)], r[(0, 0)])]
}

/// Returns the centre and the size of a mesh's bounding box; each side is at least 0.1 mm long.
fn bounds(pieces: &[MeshPiece]) -> (Vector3<f64>, [f64; 3]) {
    let (mut low, mut high) = (Vector3::repeat(f64::MAX), Vector3::repeat(f64::MIN));
    for p in pieces.iter().flat_map(|p| &p.points) {
        low = low.inf(&Vector3::from(*p));
        high = high.sup(&Vector3::from(*p));
    }
    ((low + high) / 2.0, <[f64; 3]>::from((high - low).map(|x| x.max(1e-4))))
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

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use nalgebra::UnitQuaternion;

    use super::*;

    #[test]
    fn euler_angles_of_parts_reproduce_the_pose() {
        for (r, p, y) in
            [(0.0, 0.0, 0.0), (0.3, -0.4, 1.2), (1.5, FRAC_PI_2, 0.2), (0.0, -FRAC_PI_2, 0.0), (3.0, 0.1, -2.0)]
        {
            let q = UnitQuaternion::from_euler_angles(r, p, y);
            let [a, b, c] = euler(&Isometry3::from_parts(Default::default(), q));
            let turn = |axis: Vector3<f64>, x: f64| UnitQuaternion::from_scaled_axis(axis * x);
            let back = turn(Vector3::x(), a) * turn(Vector3::y(), b) * turn(Vector3::z(), c);
            assert!(back.angle_to(&q) < 1e-6, "{r} {p} {y}: {}", back.angle_to(&q));
        }
    }
}
