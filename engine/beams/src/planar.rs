//! The nearest point of flat faces in a cone, in closed form.
//!
//! The nearest point of a convex polygon inside the cone is one of a few candidates:
//!
//! - the foot of the perpendicular;
//! - the nearest point of the conic in which the cone cuts the plane;
//! - on each edge, its nearest point, its ends and its crossings with the cone;
//! - a point on the circle at which the near limit cuts the plane, if that is inside the polygon.
//!
//! For any cone, these include every local minimum of the distance.

use nalgebra::Vector3;

use super::sight::BeamCone;

/// The nearest candidate so far, relative to the apex.
#[derive(Debug, Clone, Copy)]
pub(super) struct NearestPoint {
    pub distance: f64,
    pub point: Vector3<f64>,
    pub near: f64,
    pub reach: f64,
}

impl NearestPoint {
    pub fn new(near: f64, reach: f64) -> Self {
        Self { distance: f64::INFINITY, point: Vector3::zeros(), near, reach }
    }

    /// Considers a point on the face and in the cone, which becomes the best candidate if it is nearer than the current
    /// one and within the distance limits.
    pub fn offer(&mut self, point: Vector3<f64>) {
        self.offer_at(point.norm(), point);
    }

    /// Considers a point like [`offer`](Self::offer), but with its exact distance given by the caller.
    pub fn offer_at(&mut self, distance: f64, point: Vector3<f64>) {
        if distance >= self.near && distance <= self.reach && distance < self.distance {
            self.distance = distance;
            self.point = point;
        }
    }

    pub fn distance_and_point(self) -> Option<(f64, Vector3<f64>)> {
        (self.distance < f64::INFINITY).then_some((self.distance, self.point))
    }
}

/// Returns the nearest admissible point of a convex polygon; the corners are relative to the apex, counter-clockwise
/// around `normal`.
pub(super) fn polygon<const N: usize>(
    cone: &BeamCone,
    corners: &[Vector3<f64>; N],
    normal: &Vector3<f64>,
) -> Option<(f64, Vector3<f64>)> {
    let inside = |p: &Vector3<f64>| {
        (0..N).all(|i| (corners[(i + 1) % N] - corners[i]).cross(&(p - corners[i])).dot(normal) >= 0.0)
    };
    let mut best = match nearest_interior_point(cone, normal.dot(&corners[0]), normal, inside) {
        InteriorResult::Nothing => return None,
        InteriorResult::Nearest(nearest) => return nearest.distance_and_point(),
        InteriorResult::Maybe(nearest) => nearest,
    };
    for i in 0..N {
        edge(cone, &corners[i], &corners[(i + 1) % N], &mut best);
    }
    best.distance_and_point()
}

/// Returns the nearest admissible point of an infinite plane; `h` is its height above the apex along `normal`.
pub(super) fn plane(cone: &BeamCone, h: f64, normal: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
    match nearest_interior_point(cone, h, normal, |_| true) {
        InteriorResult::Nothing => None,
        InteriorResult::Nearest(nearest) | InteriorResult::Maybe(nearest) => nearest.distance_and_point(),
    }
}

/// Result for the interior of a flat face, before its boundary is considered.
pub(super) enum InteriorResult {
    /// No point of the face is admissible.
    Nothing,
    /// This is the nearest point of the whole face.
    Nearest(NearestPoint),
    /// The best point of the interior; the boundary may be nearer.
    Maybe(NearestPoint),
}

/// Returns the best candidate that is not on the boundary of a flat face.
pub(super) fn nearest_interior_point(
    cone: &BeamCone,
    h: f64,
    normal: &Vector3<f64>,
    inside: impl Fn(&Vector3<f64>) -> bool,
) -> InteriorResult {
    let sight = &cone.sight;
    let height = h.abs();
    let reach = sight.reach(height);
    // `sees_side` is false for a NaN height.
    if height > reach || !sight.sees_side(h) {
        return InteriorResult::Nothing;
    }
    let mut best = NearestPoint::new(sight.near, reach);
    let toward = if h < 0.0 { -normal } else { *normal };

    // The foot of the perpendicular is the nearest point of the plane.
    let foot = toward * height;
    let foot_in_cone = cone.contains(&foot);
    if foot_in_cone && height >= sight.near && inside(&foot) {
        best.offer_at(height, foot);
        return InteriorResult::Nearest(best);
    }

    // The nearest point of the conic: on the axis turned towards the perpendicular by the half angle.
    let axis_rise = toward.dot(&sight.axis);
    let across = toward - sight.axis * axis_rise;
    let turn = across.try_normalize(1e-300).unwrap_or_else(|| any_perpendicular(&sight.axis));
    if cone.is_wide() {
        for side in [1.0, -1.0] {
            let along = sight.axis * cone.cos + turn * (side * cone.sin);
            let rise = along.dot(&toward);
            if rise > 0.0 {
                let point = along * (height / rise);
                if inside(&point) {
                    best.offer_at(height / rise, point);
                }
            }
        }
    } else if !foot_in_cone {
        let along = sight.axis * cone.cos + turn * cone.sin;
        let rise = along.dot(&toward);
        // In a convex cone no point of the plane is nearer than this one.
        if rise <= 0.0 || height / rise > reach {
            return InteriorResult::Nothing;
        }
        let point = along * (height / rise);
        if height / rise >= sight.near && inside(&point) {
            best.offer_at(height / rise, point);
            return InteriorResult::Nearest(best);
        }
    }

    if sight.near > height && sight.near <= reach {
        near_circle(cone, height, &toward, inside, &mut best);
    }
    InteriorResult::Maybe(best)
}

/// Offers points of the plane exactly at the near limit that are not on the boundary of the face.
///
/// The points at the near limit form a circle around the foot of the perpendicular. Its admissible part either ends on
/// the cone (offered here) or on the boundary of the face (offered by [`edge`]), or is the whole circle, of which one
/// point suffices.
fn near_circle(
    cone: &BeamCone,
    height: f64,
    toward: &Vector3<f64>,
    inside: impl Fn(&Vector3<f64>) -> bool,
    best: &mut NearestPoint,
) {
    let near = cone.sight.near;
    let axis = &cone.sight.axis;
    let radius = (near * near - height * height).sqrt();
    let rise = axis.dot(toward);
    let flat = (axis - toward * rise).try_normalize(1e-300).unwrap_or_else(|| any_perpendicular(toward));
    let side = toward.cross(&flat);
    let point = |cos: f64, sin: f64| toward * height + (flat * cos + side * sin) * radius;

    // The point nearest to the axis.
    let first = point(1.0, 0.0);
    if cone.contains(&first) && inside(&first) {
        best.offer_at(near, first);
        return;
    }
    // The crossings with the cone: axis . p = cos(half angle) near.
    let cos = (cone.cos * near - rise * height) / (axis.dot(&flat) * radius);
    if cos.abs() <= 1.0 {
        let sin = (1.0 - cos * cos).sqrt();
        for sin in [sin, -sin] {
            let crossing = point(cos, sin);
            if inside(&crossing) {
                best.offer_at(near, crossing);
            }
        }
    }
}

/// Offers the candidates on the edge from `a` to `b`.
pub(super) fn edge(cone: &BeamCone, a: &Vector3<f64>, b: &Vector3<f64>, best: &mut NearestPoint) {
    let along = b - a;
    let length_squared = along.norm_squared();
    if length_squared <= 0.0 || length_squared.is_nan() {
        return;
    }
    let at = |t: f64| a + along * t;

    // If the nearest point of the edge is admissible, it is the best candidate. If it is too far away, so is the whole
    // edge.
    let closest = at((-a.dot(&along) / length_squared).clamp(0.0, 1.0));
    let least = closest.norm();
    if least > best.reach || least >= best.distance {
        return;
    }
    if least >= best.near && cone.contains(&closest) {
        best.offer_at(least, closest);
        return;
    }
    for end in [a, b] {
        if cone.contains(end) {
            best.offer(*end);
        }
    }

    // Crossings with the cone: sin^2 (axis part)^2 = cos^2 (perpendicular part)^2, then one Newton step on the
    // unsquared equation.
    let axis = &cone.sight.axis;
    let (a0, a1) = (axis.dot(a), axis.dot(&along));
    let (c0, c1) = (a - axis * a0, along - axis * a1);
    let (s2, k2) = (cone.sin * cone.sin, cone.cos * cone.cos);
    let roots = quadratic(
        s2 * a1 * a1 - k2 * c1.norm_squared(),
        2.0 * (s2 * a0 * a1 - k2 * c0.dot(&c1)),
        s2 * a0 * a0 - k2 * c0.norm_squared(),
    );
    let excess = |t: f64| cone.excess(a0 + a1 * t, (c0 + c1 * t).norm());
    for root in roots.into_iter().flatten() {
        // The mirror image of the cone also satisfies the squared equation.
        if (a0 + a1 * root) * cone.cos < 0.0 && cone.cos.abs() > 1e-12 {
            continue;
        }
        let across = c0 + c1 * root;
        let slope = cone.sin * a1 - cone.cos * across.dot(&c1) / across.norm();
        let better = root - excess(root) / slope;
        let t = if excess(better).abs() < excess(root).abs() { better } else { root };
        if (0.0..=1.0).contains(&t) {
            best.offer(at(t));
        }
    }

    // Crossings with the near limit.
    if least < best.near && best.near < best.distance {
        let roots = quadratic(length_squared, 2.0 * a.dot(&along), a.norm_squared() - best.near * best.near);
        for t in roots.into_iter().flatten() {
            let point = at(t);
            if (0.0..=1.0).contains(&t) && cone.contains(&point) {
                best.offer_at(best.near, point);
            }
        }
    }
}

/// Returns the real roots of `a x^2 + b x + c`. A discriminant that is negative only by rounding is treated as zero.
pub(super) fn quadratic(a: f64, b: f64, c: f64) -> [Option<f64>; 2] {
    let discriminant = b * b - 4.0 * a * c;
    let noise = 1e-13 * (b * b + (4.0 * a * c).abs());
    if discriminant < -noise || discriminant.is_nan() {
        return [None, None];
    }
    // This form avoids cancellation.
    let q = -0.5 * (b + discriminant.max(0.0).sqrt().copysign(b));
    let finite = |x: f64| x.is_finite().then_some(x);
    [finite(q / a), finite(c / q)]
}

/// Returns a unit vector perpendicular to `v`.
pub(super) fn any_perpendicular(v: &Vector3<f64>) -> Vector3<f64> {
    let other = if v.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    v.cross(&other).try_normalize(0.0).unwrap_or_else(Vector3::x)
}
