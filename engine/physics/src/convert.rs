//! Conversions between nalgebra, which the interface uses, and glam, which rapier uses.

use nalgebra::{Isometry3, Matrix3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rapier3d::{
    dynamics::MassProperties,
    geometry::{SharedShape, TriMeshFlags},
    math::{Matrix, Pose, Rotation, Vector},
    parry::transformation::try_convex_hull,
};
use tatu_geometry::{Form, Mesh};

use crate::MassProps;

pub(crate) fn vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

pub(crate) fn vector_back(v: Vector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

pub(crate) fn pose(p: &Isometry3<f64>) -> Pose {
    let q = &p.rotation.coords;
    Pose { translation: vector(&p.translation.vector), rotation: Rotation::from_xyzw(q.x, q.y, q.z, q.w) }
}

pub(crate) fn pose_back(p: &Pose) -> Isometry3<f64> {
    let q = p.rotation;
    Isometry3::from_parts(
        Translation3::from(vector_back(p.translation)),
        // The engine keeps rotations normalised; normalising again would change bits.
        UnitQuaternion::new_unchecked(Quaternion::new(q.w, q.x, q.y, q.z)),
    )
}

/// Converts a rotation without normalising it again.
pub(crate) fn rotation_back(q: &Rotation) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(q.w, q.x, q.y, q.z))
}

pub(crate) fn mass(m: &MassProps) -> MassProperties {
    let i: &Matrix3<f64> = &m.inertia;
    // If the inertia is diagonal, it is used as given, which avoids rounding errors of a search for principal axes.
    if Matrix3::from_diagonal(&i.diagonal()) == *i {
        return MassProperties::new(vector(&m.com.coords), m.mass, vector(&i.diagonal()));
    }
    let columns = Matrix::from_cols(
        Vector::new(i[(0, 0)], i[(1, 0)], i[(2, 0)]),
        Vector::new(i[(0, 1)], i[(1, 1)], i[(2, 1)]),
        Vector::new(i[(0, 2)], i[(1, 2)], i[(2, 2)]),
    );
    MassProperties::with_inertia_matrix(vector(&m.com.coords), m.mass, columns)
}

/// Returns rapier's shape and its pose in the part's frame, or `None` if the form is degenerate: a mesh without valid
/// triangles, or a form with a size that is not positive.
pub(crate) fn shape(form: &Form) -> Option<(SharedShape, Pose)> {
    let sized = |sizes: &[f64]| sizes.iter().all(|s| s.is_finite() && *s > 0.0);
    match form {
        Form::Plane => Some((SharedShape::halfspace(Vector::Z), Pose::IDENTITY)),
        Form::Box { half } => {
            sized(half.as_slice()).then(|| (SharedShape::cuboid(half.x, half.y, half.z), Pose::IDENTITY))
        }
        Form::Sphere { radius } => sized(&[*radius]).then(|| (SharedShape::ball(*radius), Pose::IDENTITY)),
        Form::Cylinder { radius, half_length } => {
            sized(&[*radius, *half_length]).then(|| (SharedShape::cylinder(*half_length, *radius), y_to_z()))
        }
        Form::Capsule { radius, half_length } => {
            sized(&[*radius]).then(|| (SharedShape::capsule_z(half_length.max(0.0), *radius), Pose::IDENTITY))
        }
        Form::Mesh { mesh, convex } => mesh_shape(mesh, *convex).map(|s| (s, Pose::IDENTITY)),
    }
}

/// Returns the rotation from rapier's cylinders, which are along y, to cylinders along z.
fn y_to_z() -> Pose {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    Pose { translation: Vector::ZERO, rotation: Rotation::from_xyzw(half, 0.0, 0.0, half) }
}

/// Returns the convex hull of a mesh's points, or `None` if they have none, because they lie in a plane or are too few.
pub fn hull(mesh: &Mesh) -> Option<Mesh> {
    let points: Vec<Vector> = mesh.vertices.iter().map(|v| vector(&v.coords)).collect();
    let (points, triangles) = try_convex_hull(&points).ok()?;
    let vertices = points.into_iter().map(|p| Point3::from(vector_back(p))).collect();
    Some(Mesh { vertices, triangles, coordinates: Vec::new() })
}

fn mesh_shape(mesh: &Mesh, convex: bool) -> Option<SharedShape> {
    let count = mesh.vertices.len() as u32;
    let whole = mesh.vertices.iter().all(|v| v.coords.iter().all(|c| c.is_finite()))
        && mesh.triangles.iter().flatten().all(|i| *i < count);
    if !whole || mesh.triangles.is_empty() {
        return None;
    }
    let points: Vec<Vector> = mesh.vertices.iter().map(|v| vector(&v.coords)).collect();
    // A flat "convex" mesh has no hull, but can still collide as a surface.
    if convex && let Some(hull) = SharedShape::convex_hull(&points) {
        return Some(hull);
    }
    // Edges between triangles use the normals of both, which prevents objects from catching on the seams of a flat
    // floor. Meshes of models are often open, so both sides are solid.
    SharedShape::trimesh_with_flags(points, mesh.triangles.clone(), TriMeshFlags::FIX_INTERNAL_EDGES_TWO_SIDED).ok()
}
