//! Tests of beams against references that share no code with them: dense sampling, closed-form solutions, and a
//! different library.

mod brute;
mod bundles;
mod candidates;
mod convex;
mod flat;
mod library;
mod moving;
mod rays;
mod round;
mod scenes;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use tatu_geometry::Form;

use super::{Beam, BeamScene, BeamTarget, Faces, Hit};

/// Random numbers that are the same in every run (SplitMix64).
pub(super) struct TestRng(pub u64);

impl TestRng {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }

    pub fn vector(&mut self, size: f64) -> Vector3<f64> {
        Vector3::new(self.between(-size, size), self.between(-size, size), self.between(-size, size))
    }

    pub fn pose(&mut self, size: f64) -> Isometry3<f64> {
        let turn = UnitQuaternion::from_scaled_axis(self.vector(3.0));
        Isometry3::from_parts(Translation3::from(self.vector(size)), turn)
    }

    /// Returns a random cone; in some cases, its minimum distance, incidence or faces are also limited.
    fn cone(&mut self, pose: Isometry3<f64>, widest: f64) -> Beam {
        let mut beam = Beam::cone(pose, self.between(0.02, widest), self.between(1.0, 6.0));
        if self.chance(0.3) {
            beam.near = self.between(0.0, 1.2);
        }
        if self.chance(0.3) {
            beam.max_incidence = self.between(0.1, 1.5);
        }
        if self.chance(0.3) {
            beam.faces = if self.chance(0.5) { Faces::FRONT } else { Faces::BACK };
        }
        beam
    }
}

fn target(object: u64, pose: Isometry3<f64>, form: Form) -> BeamTarget {
    BeamTarget { object, group: 0, world_from_target: pose, form, color: [0.7; 3], opacity: 1.0, texture: None }
}

fn cast_on(form: Form, pose: Isometry3<f64>, beam: &Beam) -> Hit {
    let mut scene = BeamScene::default();
    scene.set([target(1, pose, form)]);
    scene.cast_one(beam)
}

fn mesh(vertices: Vec<Point3<f64>>, triangles: Vec<[u32; 3]>) -> Form {
    Form::Mesh {
        mesh: std::sync::Arc::new(tatu_geometry::Mesh { vertices, triangles, ..Default::default() }),
        convex: false,
    }
}

/// Returns the approximate signed distance of a point from the surface of a form, positive outside; for a mesh, from
/// the plane of its first triangle.
fn surface_distance(form: &Form, p: &Point3<f64>) -> f64 {
    let radial = p.xy().coords.norm();
    match form {
        Form::Plane => p.z,
        Form::Sphere { radius } => p.coords.norm() - radius,
        Form::Box { half } => (p.coords.abs() - half).max(),
        Form::Cylinder { radius, half_length } => (radial - radius).max(p.z.abs() - half_length),
        Form::Capsule { radius, half_length } => {
            (p - Point3::new(0.0, 0.0, p.z.clamp(-half_length, *half_length))).norm() - radius
        }
        Form::Mesh { mesh, .. } => {
            let [a, b, c] = mesh.triangles[0].map(|v| mesh.vertices[v as usize]);
            (b - a).cross(&(c - a)).normalize().dot(&(p - a))
        }
    }
}

/// Checks that a hit is admissible, and that no admissible sampled point is nearer, so that the hit is the minimum.
///
/// The tolerance covers rounding of angles in the sampling; an incorrect candidate has a much larger error. Returns
/// whether something was hit, and whether the sampling came within 0.1 mm of it.
fn check_minimum(form: &Form, beam: &Beam, pose: Isometry3<f64>, grid: usize, dice: &mut TestRng) -> (bool, bool) {
    let hit = cast_on(form.clone(), pose, beam);
    let sampled = brute::nearest(beam, &pose, &brute::patches(form), grid, dice);
    let story = || format!("{hit:?}, sampled {sampled}: {form:?} {pose:?} {beam:?}");
    assert!(hit.distance <= sampled + 1e-8, "too far: {}", story());
    if !hit.is_some() {
        return (false, false);
    }
    assert!((hit.point.coords.norm() - hit.distance).abs() < 1e-8, "{}", story());
    assert!((hit.normal.norm() - 1.0).abs() < 1e-9 && hit.normal.dot(&hit.point.coords) < 1e-9, "{}", story());
    // The hit must be on the surface, and its normal must point outward after it is flipped back.
    let to_form = pose.inverse() * beam.world_from_beam;
    let place = to_form * hit.point;
    assert!(surface_distance(form, &place).abs() < 1e-8, "off the surface: {}", story());
    let normal = to_form * hit.normal;
    let outward = match form {
        Form::Plane | Form::Mesh { .. } => surface_distance(form, &(place + normal)),
        // The solids are convex, with the origin inside.
        _ => normal.dot(&place.coords),
    };
    let outward = if outward > 0.0 { hit.normal } else { -hit.normal };
    assert!(brute::is_admissible(beam, &hit.point, &outward, 1e-6), "does not count: {}", story());
    (true, (sampled - hit.distance).abs() < 1e-4)
}
