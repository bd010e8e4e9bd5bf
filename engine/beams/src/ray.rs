//! Intersection of rays with every form, in closed form.

use nalgebra::Vector3;
use tatu_geometry::Form;

use super::{
    planar::quadratic,
    sight::{FormHit, SightLine},
    solid::unit,
};

/// Returns the first admissible crossing of a form other than a mesh; the sight is in the form's frame.
pub(super) fn cast(sight: &SightLine, form: &Form) -> Option<FormHit> {
    let mut best = None;
    match form {
        Form::Plane => offer(&mut best, sight, -sight.origin.z / sight.axis.z, Vector3::z(), 0),
        Form::Box { half } => cuboid(sight, half, &mut best),
        Form::Sphere { radius } => ball(sight, 0.0, *radius, |_| Some(0), &mut best),
        Form::Cylinder { radius, half_length } => {
            side(sight, *radius, *half_length, &mut best);
            for (primitive, sign) in [(1, 1.0), (2, -1.0)] {
                let t = (sign * half_length - sight.origin.z) / sight.axis.z;
                let point = sight.origin + sight.axis * t;
                if point.x * point.x + point.y * point.y <= radius * radius {
                    offer(&mut best, sight, t, Vector3::new(0.0, 0.0, sign), primitive);
                }
            }
        }
        Form::Capsule { radius, half_length } => {
            side(sight, *radius, *half_length, &mut best);
            ball(sight, *half_length, *radius, |z| (z >= 0.0).then_some(1), &mut best);
            ball(sight, -half_length, *radius, |z| (z <= 0.0).then_some(2), &mut best);
        }
        Form::Mesh { .. } => {}
    }
    best
}

/// Returns the distance at which a ray from the origin crosses a triangle.
///
/// Neighbouring triangles compute the sign for a shared edge from the same values, so no ray can pass between them.
pub(super) fn triangle(axis: &Vector3<f64>, corners: &[Vector3<f64>; 3], normal: &Vector3<f64>) -> Option<f64> {
    let [a, b, c] = corners;
    let sides = [axis.dot(&a.cross(b)), axis.dot(&b.cross(c)), axis.dot(&c.cross(a))];
    let crossed = sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0);
    crossed.then(|| normal.dot(a) / normal.dot(axis))
}

/// Stores a crossing at distance `t` in `best`, if it is admissible and nearer than the current one.
pub(super) fn offer(best: &mut Option<FormHit>, sight: &SightLine, t: f64, normal: Vector3<f64>, primitive: u32) {
    let slope = normal.dot(&sight.axis);
    if t >= sight.near && t <= sight.far && sight.sees_side(slope) && slope.abs() >= sight.cos_incidence {
        *best = FormHit::nearer(*best, Some(FormHit { distance: t, point: sight.axis * t, normal, primitive }));
    }
}

fn cuboid(sight: &SightLine, half: &Vector3<f64>, best: &mut Option<FormHit>) {
    // The ray is inside while it is between all three pairs of planes.
    let (mut enter, mut leave) = ((f64::NEG_INFINITY, 0), (f64::INFINITY, 0));
    for axis in 0..3 {
        let (x, slope) = (sight.origin[axis], sight.axis[axis]);
        if slope == 0.0 {
            if x.abs() > half[axis] {
                return;
            }
            continue;
        }
        let (low, high) = ((-half[axis] - x) / slope, (half[axis] - x) / slope);
        let (first, last) = if slope > 0.0 { (low, high) } else { (high, low) };
        if first > enter.0 {
            enter = (first, 2 * axis + usize::from(slope < 0.0));
        }
        if last < leave.0 {
            leave = (last, 2 * axis + usize::from(slope > 0.0));
        }
    }
    if enter.0 > leave.0 {
        return;
    }
    for (t, face) in [enter, leave] {
        let mut normal = Vector3::zeros();
        normal[face / 2] = if face % 2 == 1 { 1.0 } else { -1.0 };
        offer(best, sight, t, normal, face as u32);
    }
}

/// Intersects the ray with the ball around (0, 0, `z`). `primitive` maps the z component of the normal to the part of
/// the surface, or to `None` if that part does not belong to the form.
fn ball(sight: &SightLine, z: f64, radius: f64, primitive: impl Fn(f64) -> Option<u32>, best: &mut Option<FormHit>) {
    let from_centre = sight.origin.coords - Vector3::new(0.0, 0.0, z);
    let middle = -from_centre.dot(&sight.axis);
    let miss = (from_centre + sight.axis * middle).norm_squared();
    let depth = (radius * radius - miss).sqrt();
    for t in [middle - depth, middle + depth] {
        let normal = unit(&(from_centre + sight.axis * t));
        if let Some(primitive) = primitive(normal.z) {
            offer(best, sight, t, normal, primitive);
        }
    }
}

fn side(sight: &SightLine, radius: f64, half_length: f64, best: &mut Option<FormHit>) {
    let (origin, axis) = (sight.origin.xy().coords, sight.axis.xy());
    let roots = quadratic(axis.norm_squared(), 2.0 * origin.dot(&axis), origin.norm_squared() - radius * radius);
    for t in roots.into_iter().flatten() {
        let point = sight.origin + sight.axis * t;
        if point.z.abs() <= half_length {
            offer(best, sight, t, unit(&Vector3::new(point.x, point.y, 0.0)), 0);
        }
    }
}
