//! Reference implementation of volume beams: finds the nearest admissible point by dense sampling and local search.

use nalgebra::{Isometry3, Point3, Vector3};
use tatu_geometry::Form;

use super::{
    super::{Beam, Volume},
    TestRng,
};

/// A part of a surface, parametrised over the unit square: returns a point and its outward normal.
pub type SurfacePatch = Box<dyn Fn(f64, f64) -> (Point3<f64>, Vector3<f64>)>;

/// Returns the parts of a form's surface. A plane is limited to a square of 40 m.
pub fn patches(form: &Form) -> Vec<SurfacePatch> {
    let at = |x, y, z| Point3::new(x, y, z);
    match form.clone() {
        Form::Plane => vec![Box::new(move |u, v| (at(40.0 * u - 20.0, 40.0 * v - 20.0, 0.0), Vector3::z()))],
        Form::Box { half } => (0..6)
            .map(|face| -> SurfacePatch {
                Box::new(move |u, v| {
                    let (axis, sign) = (face / 2, if face % 2 == 0 { -1.0 } else { 1.0 });
                    let mut place = Vector3::zeros();
                    place[axis] = sign;
                    let normal = place;
                    place[(axis + 1) % 3] = 2.0 * u - 1.0;
                    place[(axis + 2) % 3] = 2.0 * v - 1.0;
                    (place.component_mul(&half).into(), normal)
                })
            })
            .collect(),
        Form::Sphere { radius } => vec![ball(0.0, radius, -1.0, 1.0)],
        Form::Cylinder { radius, half_length } => {
            vec![side(radius, half_length), end(radius, half_length, 1.0), end(radius, half_length, -1.0)]
        }
        Form::Capsule { radius, half_length } => {
            vec![side(radius, half_length), ball(half_length, radius, 0.0, 1.0), ball(-half_length, radius, -1.0, 0.0)]
        }
        Form::Mesh { mesh, .. } => (0..mesh.triangles.len())
            .map(|i| {
                let [a, b, c] = mesh.triangles[i].map(|v| mesh.vertices[v as usize]);
                triangle(a, b, c)
            })
            .collect(),
    }
}

pub fn triangle(a: Point3<f64>, b: Point3<f64>, c: Point3<f64>) -> SurfacePatch {
    let normal = (b - a).cross(&(c - a)).normalize();
    // The square is mapped onto the whole triangle; its edge u = 0 becomes the corner `a`.
    Box::new(move |u, v| (a + (b - a) * (u * (1.0 - v)) + (c - a) * (u * v), normal))
}

fn around(u: f64) -> Vector3<f64> {
    let (sin, cos) = (u * std::f64::consts::TAU).sin_cos();
    Vector3::new(cos, sin, 0.0)
}

fn side(radius: f64, half_length: f64) -> SurfacePatch {
    Box::new(move |u, v| {
        let normal = around(u);
        ((normal * radius + Vector3::z() * (half_length * (2.0 * v - 1.0))).into(), normal)
    })
}

fn end(radius: f64, half_length: f64, sign: f64) -> SurfacePatch {
    Box::new(move |u, v| ((around(u) * (radius * v) + Vector3::z() * (sign * half_length)).into(), Vector3::z() * sign))
}

fn ball(z: f64, radius: f64, low: f64, high: f64) -> SurfacePatch {
    Box::new(move |u, v| {
        let rise = low + (high - low) * v;
        let normal = around(u) * (1.0 - rise * rise).max(0.0).sqrt() + Vector3::z() * rise;
        ((normal * radius + Vector3::z() * z).into(), normal)
    })
}

/// Returns whether a point with a normal, both in the beam's frame, is admissible; `slack` widens every limit.
pub fn is_admissible(beam: &Beam, point: &Point3<f64>, normal: &Vector3<f64>, slack: f64) -> bool {
    let distance = point.coords.norm();
    let (x, y, z) = (point.x, point.y, point.z);
    // Fraction of the distance from the near end to the far one.
    let part = (z - beam.near) / (beam.far - beam.near);
    let between = |a: f64, b: f64| a + (b - a) * part;
    let in_ends = part >= -slack && part <= 1.0 + slack;
    let in_ball = distance >= beam.near - slack && distance <= beam.far + slack;
    let in_volume = match beam.volume {
        Volume::Ray => unreachable!("volumes only"),
        Volume::Cone { half_angle } => in_ball && point.xy().coords.norm().atan2(z) <= half_angle + slack,
        Volume::Pyramid { x_near, y_near, x_far, y_far } => {
            let (wide, high) = (between(x_near, x_far) / 2.0, between(y_near, y_far) / 2.0);
            in_ends && x.abs() <= wide + slack && y.abs() <= high + slack
        }
        Volume::Cylinder { radius_near, radius_far } => {
            in_ends && x.hypot(y) <= between(radius_near, radius_far) + slack
        }
        Volume::Disc { angle, height, gap } => {
            let aside = x.atan2(z).abs();
            // At the vertex of the sector, the angle is undefined.
            let sector = aside <= angle / 2.0 + slack && aside >= gap / 2.0 - slack || x.hypot(z) <= slack;
            in_ball && sector && y.abs() <= height / 2.0 + slack
        }
    };
    let slope = normal.dot(&point.coords) / distance;
    let incidence = slope.abs().min(1.0).acos();
    in_volume
        && (incidence <= beam.max_incidence + slack || beam.max_incidence >= std::f64::consts::FRAC_PI_2)
        && ((slope <= slack && beam.faces.front) || (slope >= -slack && beam.faces.back))
}

/// Returns the smallest distance found on the patches: by a grid on each patch, then by a random search around its best
/// point.
pub fn nearest(beam: &Beam, pose: &Isometry3<f64>, patches: &[SurfacePatch], grid: usize, dice: &mut TestRng) -> f64 {
    let to_beam = beam.world_from_beam.inverse() * pose;
    let mut best = f64::INFINITY;
    for patch in patches {
        let value = |u: f64, v: f64| {
            let (point, normal) = patch(u, v);
            let (point, normal) = (to_beam * point, to_beam * normal);
            if is_admissible(beam, &point, &normal, 0.0) { point.coords.norm() } else { f64::INFINITY }
        };
        let mut place = (f64::INFINITY, 0.5, 0.5);
        for i in 0..=grid {
            for j in 0..=grid {
                let (u, v) = (i as f64 / grid as f64, j as f64 / grid as f64);
                let d = value(u, v);
                if d < place.0 {
                    place = (d, u, v);
                }
            }
        }
        let mut step = 2.0 / grid as f64;
        while place.0 < f64::INFINITY && step > 1e-9 {
            let mut better = false;
            for _ in 0..40 {
                let u = (place.1 + dice.between(-step, step)).clamp(0.0, 1.0);
                let v = (place.2 + dice.between(-step, step)).clamp(0.0, 1.0);
                let d = value(u, v);
                if d < place.0 {
                    place = (d, u, v);
                    better = true;
                }
            }
            if !better {
                step *= 0.75;
            }
        }
        best = best.min(place.0);
    }
    best
}
