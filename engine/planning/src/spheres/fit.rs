//! Covers forms by spheres.

use std::{collections::BTreeMap, sync::Arc};

use nalgebra::{Isometry3, Point3, Vector3};
use tatu_geometry::{Form, Mesh};

/// A sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// Centre, m.
    pub center: Point3<f64>,
    /// Radius, m.
    pub radius: f64,
}

/// By how much spheres exceed what they cover, to make up for rounding, m.
const ROUNDING: f64 = 1e-9;
/// How far the spheres of a capsule or a long cylinder may exceed its radius: their distance follows from this.
const EXCESS: f64 = 1.12;
/// Steps that move the centre of a sphere to where the radius is small.
const CENTRING_STEPS: usize = 24;

/// Returns spheres that cover a form, about `count` at most: every point of a solid, and of the surface of a mesh that
/// is not convex. A plane has none.
///
/// ```
/// use nalgebra::Vector3;
/// use tatu_geometry::Form;
/// use tatu_planning::spheres::cover;
///
/// let spheres = cover(&Form::Box { half: Vector3::new(0.5, 0.1, 0.1) }, 16);
/// assert!(spheres.len() == 5 && spheres.iter().all(|s| s.radius < 0.174));
/// ```
pub fn cover(form: &Form, count: usize) -> Vec<Sphere> {
    let count = count.max(1);
    let spheres = match form {
        Form::Plane => Vec::new(),
        Form::Sphere { radius } => vec![Sphere { center: Point3::origin(), radius: *radius }],
        Form::Box { half } => boxes(half, count, |_, _| true),
        Form::Capsule { radius, half_length } => row(*radius, *half_length, false, count),
        Form::Cylinder { radius, half_length } if half_length >= radius => row(*radius, *half_length, true, count),
        Form::Cylinder { radius, half_length } => {
            let beside = |low: &Vector3<f64>, high: &Vector3<f64>| {
                let nearest = |a: f64, b: f64| if a > 0.0 { a } else { b.min(0.0) };
                libm::hypot(nearest(low.x, high.x), nearest(low.y, high.y)) <= *radius
            };
            boxes(&Vector3::new(*radius, *radius, *half_length), count, beside)
        }
        Form::Mesh { mesh, convex } => pieces(mesh, *convex, count),
    };
    let usable = |s: &Sphere| s.radius.is_finite() && s.center.coords.iter().all(|x| x.is_finite());
    let larger = |s: Sphere| Sphere { radius: s.radius * (1.0 + ROUNDING) + ROUNDING, ..s };
    spheres.into_iter().filter(usable).map(larger).collect()
}

/// Returns spheres for the cells of a box that are of nearly equal edges.
fn boxes(half: &Vector3<f64>, count: usize, wanted: impl Fn(&Vector3<f64>, &Vector3<f64>) -> bool) -> Vec<Sphere> {
    let cells = |edge: f64| half.map(|h| libm::ceil(2.0 * h / edge - 1e-9).max(1.0));
    let mut edge = 2.0 * half.min().max(half.max() / 64.0);
    while cells(edge).product() > count as f64 {
        edge *= 1.1;
    }
    let n = cells(edge);
    let size = half.component_mul(&n.map(|n| 2.0 / n));
    let mut spheres = Vec::new();
    for i in 0..n.x as usize {
        for j in 0..n.y as usize {
            for k in 0..n.z as usize {
                let low = Vector3::new(i as f64, j as f64, k as f64).component_mul(&size) - half;
                if wanted(&low, &(low + size)) {
                    spheres.push(Sphere { center: Point3::from(low + 0.5 * size), radius: 0.5 * size.norm() });
                }
            }
        }
    }
    spheres
}

/// Returns spheres along z for a capsule, or for a cylinder, which is `flat` at its ends.
fn row(radius: f64, half_length: f64, flat: bool, count: usize) -> Vec<Sphere> {
    let apart = 2.0 * radius * libm::sqrt(EXCESS * EXCESS - 1.0);
    let gaps = if half_length > 0.0 { libm::ceil(2.0 * half_length / apart).clamp(1.0, 1e3) } else { 0.0 };
    let gaps = gaps.min((count.max(2) - 1) as f64);
    if flat {
        // Each sphere covers a slice.
        let slices = gaps.max(1.0);
        let thick = 2.0 * half_length / slices;
        let sphere = |i| Sphere {
            center: Point3::new(0.0, 0.0, (f64::from(i) + 0.5) * thick - half_length),
            radius: libm::hypot(radius, 0.5 * thick),
        };
        return (0..slices as i32).map(sphere).collect();
    }
    let apart = if gaps > 0.0 { 2.0 * half_length / gaps } else { 0.0 };
    let center = |i| Point3::new(0.0, 0.0, f64::from(i) * apart - half_length);
    let reach = libm::hypot(radius, 0.5 * apart);
    (0..=gaps as i32).map(|i| Sphere { center: center(i), radius: reach }).collect()
}

/// A part of a mesh within a cell: polygons, and for a solid also the corners of the cell that are inside.
struct Piece {
    polygons: Vec<Vec<Point3<f64>>>,
    low: Vector3<f64>,
    high: Vector3<f64>,
    corners: Vec<Point3<f64>>,
    sphere: Sphere,
}

/// Returns spheres for the parts of a mesh: the part with the largest sphere is divided again and again.
fn pieces(mesh: &Mesh, solid: bool, count: usize) -> Vec<Sphere> {
    let vertex = |i: &u32| mesh.vertices.get(*i as usize).copied();
    let triangles: Vec<Vec<Point3<f64>>> =
        mesh.triangles.iter().filter_map(|t| t.iter().map(vertex).collect()).collect();
    let mut all: Vec<Piece> = Piece::new(triangles, mesh, solid).into_iter().collect();
    while all.len() < count {
        let order = |a: &(usize, &Piece), b: &(usize, &Piece)| a.1.sphere.radius.total_cmp(&b.1.sphere.radius);
        let Some((largest, _)) = all.iter().enumerate().max_by(order) else { break };
        let halves = all[largest].halves(mesh, solid);
        // The largest part is a point.
        if halves.is_empty() {
            break;
        }
        all.swap_remove(largest);
        all.extend(halves);
    }
    all.into_iter().map(|p| p.sphere).collect()
}

impl Piece {
    fn new(polygons: Vec<Vec<Point3<f64>>>, mesh: &Mesh, solid: bool) -> Option<Self> {
        let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        for p in polygons.iter().flatten() {
            (low, high) = (low.inf(&p.coords), high.sup(&p.coords));
        }
        Self::within(polygons, low, high, mesh, solid)
    }

    fn within(
        polygons: Vec<Vec<Point3<f64>>>,
        low: Vector3<f64>,
        high: Vector3<f64>,
        mesh: &Mesh,
        solid: bool,
    ) -> Option<Self> {
        let corner = |i: usize| {
            Point3::from(Vector3::from_fn(|axis, _| if i >> axis & 1 == 1 { high[axis] } else { low[axis] }))
        };
        let corners = if solid { (0..8).map(corner).filter(|p| is_inside(mesh, p)).collect() } else { Vec::new() };
        let points: Vec<Point3<f64>> = polygons.iter().flatten().chain(&corners).copied().collect();
        let sphere = enclosing(&points)?;
        Some(Piece { polygons, low, high, corners, sphere })
    }

    /// Divides the cell in the middle of what it contains, across the longest extent.
    fn halves(&self, mesh: &Mesh, solid: bool) -> Vec<Piece> {
        let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        for p in self.polygons.iter().flatten().chain(&self.corners) {
            (low, high) = (low.inf(&p.coords), high.sup(&p.coords));
        }
        let axis = (high - low).imax();
        let middle = 0.5 * (low[axis] + high[axis]);
        if !(middle > low[axis] && middle < high[axis]) {
            return Vec::new();
        }
        let side = |sign: f64| {
            let clipped = self.polygons.iter().map(|p| clip(p, axis, middle, sign)).filter(|p| !p.is_empty()).collect();
            let (mut low, mut high) = (self.low, self.high);
            if sign > 0.0 {
                low[axis] = middle
            } else {
                high[axis] = middle
            };
            Piece::within(clipped, low, high, mesh, solid)
        };
        [side(-1.0), side(1.0)].into_iter().flatten().collect()
    }
}

/// Returns the part of a polygon on one side of a plane.
fn clip(polygon: &[Point3<f64>], axis: usize, at: f64, sign: f64) -> Vec<Point3<f64>> {
    let height = |p: &Point3<f64>| sign * (p[axis] - at);
    let mut out = Vec::with_capacity(polygon.len() + 1);
    for (i, p) in polygon.iter().enumerate() {
        let next = &polygon[(i + 1) % polygon.len()];
        let (a, b) = (height(p), height(next));
        if a >= 0.0 {
            out.push(*p);
        }
        if (a > 0.0 && b < 0.0) || (a < 0.0 && b > 0.0) {
            out.push(p + (next - p) * (a / (a - b)));
        }
    }
    out
}

/// Returns whether a point is inside a convex mesh.
fn is_inside(mesh: &Mesh, p: &Point3<f64>) -> bool {
    mesh.triangles.iter().all(|t| {
        let [Some(a), Some(b), Some(c)] = t.map(|i| mesh.vertices.get(i as usize)) else { return true };
        (b - a).cross(&(c - a)).dot(&(p - a)) <= 0.0
    })
}

/// Returns a small sphere around points (M. Badoiu and K. Clarkson, "Smaller core-sets for balls", 2003).
fn enclosing(points: &[Point3<f64>]) -> Option<Sphere> {
    let first = points.first()?;
    let (low, high) =
        points.iter().fold((first.coords, first.coords), |(l, h), p| (l.inf(&p.coords), h.sup(&p.coords)));
    let mut center = Point3::from(0.5 * (low + high));
    let farthest = |center: &Point3<f64>| {
        let squares = points.iter().map(|p| (p - center).norm_squared());
        squares.enumerate().fold((0, 0.0), |best, (i, d)| if d > best.1 { (i, d) } else { best })
    };
    let mut best = Sphere { center, radius: libm::sqrt(farthest(&center).1) };
    for step in 1..=CENTRING_STEPS {
        let (i, _) = farthest(&center);
        center += (points[i] - center) / (step + 3) as f64;
        let radius = libm::sqrt(farthest(&center).1);
        if radius < best.radius {
            best = Sphere { center, radius };
        }
    }
    Some(best)
}

/// Returns a sphere around spheres, or `None` if there are none.
pub(super) fn around(spheres: &[Sphere]) -> Option<Sphere> {
    let centers: Vec<Point3<f64>> = spheres.iter().map(|s| s.center).collect();
    let center = enclosing(&centers)?.center;
    let radius = spheres.iter().map(|s| (s.center - center).norm() + s.radius).fold(0.0, f64::max);
    Some(Sphere { center, radius: radius * (1.0 + ROUNDING) })
}

/// Returns spheres in another frame.
pub(super) fn moved(spheres: &[Sphere], pose: &Isometry3<f64>) -> Vec<Sphere> {
    spheres.iter().map(|s| Sphere { center: pose * s.center, radius: s.radius }).collect()
}

/// The spheres of forms, computed once for each content.
#[derive(Debug, Clone, Default)]
pub struct SphereCache(BTreeMap<[u64; 2], Arc<[Sphere]>>);

/// Maximum number of forms of a cache; beyond it, the cache begins anew.
const MAX_FORMS: usize = 4096;

impl SphereCache {
    /// Returns the spheres of a form, as [`cover`] does.
    pub fn cover(&mut self, form: &Form, count: usize) -> Arc<[Sphere]> {
        let key = content(form, count);
        if let Some(known) = self.0.get(&key) {
            return known.clone();
        }
        if self.0.len() >= MAX_FORMS {
            self.0.clear();
        }
        let spheres: Arc<[Sphere]> = cover(form, count).into();
        self.0.insert(key, spheres.clone());
        spheres
    }

    /// Returns the number of forms.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns whether there are no forms.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Returns two hashes of the content of a form (FNV-1a with different starts, by words).
fn content(form: &Form, count: usize) -> [u64; 2] {
    let mut hashes = [0xcbf2_9ce4_8422_2325_u64, 0x9e37_79b9_7f4a_7c15];
    let mut add = |word: u64| {
        for hash in &mut hashes {
            *hash = (*hash ^ word).wrapping_mul(0x0000_0100_0000_01b3);
            *hash ^= *hash >> 29;
        }
    };
    add(count as u64);
    let mut numbers = |kind: u64, all: &[f64]| {
        add(kind);
        all.iter().for_each(|x| add(x.to_bits()));
    };
    match form {
        Form::Plane => numbers(1, &[]),
        Form::Box { half } => numbers(2, half.as_slice()),
        Form::Sphere { radius } => numbers(3, &[*radius]),
        Form::Cylinder { radius, half_length } => numbers(4, &[*radius, *half_length]),
        Form::Capsule { radius, half_length } => numbers(5, &[*radius, *half_length]),
        Form::Mesh { mesh, convex } => {
            numbers(6 + u64::from(*convex), &[]);
            mesh.vertices.iter().for_each(|v| numbers(8, v.coords.as_slice()));
            mesh.triangles.iter().flatten().for_each(|i| add(u64::from(*i)));
        }
    }
    hashes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// A closed prism over a regular polygon.
    fn prism(sides: u32, radius: f64, height: f64) -> Mesh {
        let mut mesh = Mesh::default();
        for z in [-0.5 * height, 0.5 * height] {
            for i in 0..sides {
                let angle = std::f64::consts::TAU * f64::from(i) / f64::from(sides);
                mesh.vertices.push(Point3::new(radius * angle.cos(), radius * angle.sin(), z));
            }
        }
        for i in 0..sides {
            let next = (i + 1) % sides;
            mesh.triangles.extend([[i, next, sides + i], [next, sides + next, sides + i]]);
            if i > 0 && i + 1 < sides {
                mesh.triangles.extend([[0, i + 1, i], [sides, sides + i, sides + i + 1]]);
            }
        }
        mesh
    }

    fn contains(form: &Form, p: &Point3<f64>) -> bool {
        match form {
            Form::Plane => false,
            Form::Sphere { radius } => p.coords.norm() <= *radius,
            Form::Box { half } => (0..3).all(|i| p[i].abs() <= half[i]),
            Form::Cylinder { radius, half_length } => p.x.hypot(p.y) <= *radius && p.z.abs() <= *half_length,
            Form::Capsule { radius, half_length } => {
                p.x.hypot(p.y).hypot(p.z - p.z.clamp(-half_length, *half_length)) <= *radius
            }
            Form::Mesh { mesh, .. } => is_inside(mesh, p),
        }
    }

    #[test]
    fn every_point_of_a_solid_is_covered() {
        let mut random = Random::new(8);
        let forms = [
            Form::Sphere { radius: 0.4 },
            Form::Box { half: Vector3::new(0.9, 0.3, 0.05) },
            Form::Cylinder { radius: 0.1, half_length: 0.9 },
            Form::Cylinder { radius: 0.8, half_length: 0.05 },
            Form::Capsule { radius: 0.2, half_length: 0.6 },
            Form::Capsule { radius: 0.2, half_length: 0.0 },
            Form::Mesh { mesh: Arc::new(prism(9, 0.7, 0.9)), convex: true },
        ];
        for form in forms {
            for count in [1, 2, 10, 40, 200] {
                let spheres = cover(&form, count);
                assert!(!spheres.is_empty() && spheres.len() <= count.max(2), "{form:?} {count}: {}", spheres.len());
                for _ in 0..3000 {
                    let p = Point3::from(Vector3::from_fn(|_, _| random.between(-1.0, 1.0)));
                    let covered = spheres.iter().any(|s| (p - s.center).norm() <= s.radius);
                    assert!(covered || !contains(&form, &p), "{form:?} {count} {p}");
                }
            }
        }
    }

    #[test]
    fn surfaces_are_covered_by_many_small_spheres() {
        let mesh = prism(24, 0.5, 1.0);
        let form = Form::Mesh { mesh: Arc::new(mesh.clone()), convex: false };
        let spheres = cover(&form, 60);
        let largest = spheres.iter().map(|s| s.radius).fold(0.0, f64::max);
        assert!(spheres.len() == 60 && largest < 0.3, "{} {largest}", spheres.len());
        let mut random = Random::new(2);
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.vertices[i as usize]);
            for _ in 0..50 {
                let (u, v) = (random.unit(), random.unit());
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                let p = a + (b - a) * u + (c - a) * v;
                assert!(spheres.iter().any(|s| (p - s.center).norm() <= s.radius));
            }
        }
    }

    #[test]
    fn equal_forms_are_covered_once() {
        let mut cache = SphereCache::default();
        let of = |mesh: Mesh| Form::Mesh { mesh: Arc::new(mesh), convex: true };
        let first = cache.cover(&of(prism(9, 0.7, 0.9)), 20);
        assert!(Arc::ptr_eq(&first, &cache.cover(&of(prism(9, 0.7, 0.9)), 20)));
        cache.cover(&of(prism(9, 0.7, 0.8)), 20);
        assert_eq!(cache.len(), 2);
    }

    #[test]
    fn broken_triangles_have_no_spheres() {
        let broken = Mesh {
            vertices: vec![Point3::origin(), Point3::new(f64::NAN, 0.0, 0.0)],
            triangles: vec![[0, 1, 7], [0, 0, 0]],
            coordinates: Vec::new(),
        };
        assert!(cover(&Form::Mesh { mesh: Arc::new(broken), convex: true }, 10).len() <= 1);
        assert!(cover(&Form::Mesh { mesh: Arc::new(Mesh::default()), convex: false }, 10).is_empty());
        assert!(cover(&Form::Box { half: Vector3::new(f64::NAN, 1.0, 1.0) }, 10).is_empty());
    }
}
