//! Volume, centroid and second moments of solids and of surfaces, at uniform density.

use std::collections::HashMap;

use nalgebra::{Matrix3, Point3, Vector3};

use crate::Mesh;

/// The moments of a solid of density 1, or of a surface of density 1 per unit of area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    /// Volume, m^3, or area, m^2.
    pub measure: f64,
    /// Centroid, m.
    pub centre: Point3<f64>,
    /// Inertia about the centroid, m^5 or m^4.
    pub inertia: Matrix3<f64>,
}

/// Returns the inertia of a point of mass 1 at `d` about the origin, m^2; Steiner's theorem adds it, times the mass.
pub fn steiner(d: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * d.norm_squared() - d * d.transpose()
}

/// Sums of the moments about a reference point.
#[derive(Default)]
struct MomentSums {
    measure: f64,
    first: Vector3<f64>,
    second: Matrix3<f64>,
}

impl MomentSums {
    /// Adds a simplex of the given volume or area. `last` is the number of its corners, which determines the weight of
    /// its second moments: its integral of x x' is measure / (n (n + 1)) * (sum of v v' + (sum of v) (sum of v)').
    fn add(&mut self, measure: f64, corners: [Vector3<f64>; 3], number: f64) {
        let sum: Vector3<f64> = corners.iter().sum();
        let squares: Matrix3<f64> = corners.iter().map(|v| v * v.transpose()).sum();
        self.measure += measure;
        self.first += sum * (measure / number);
        self.second += (squares + sum * sum.transpose()) * (measure / (number * (number + 1.0)));
    }

    fn about(self, reference: Vector3<f64>) -> Option<Moments> {
        // A mesh whose triangles wind inwards has a negative volume.
        let (measure, sign) = (self.measure.abs(), self.measure.signum());
        let off = self.first / self.measure;
        let spread = self.second * sign - off * off.transpose() * measure;
        let inertia = Matrix3::identity() * spread.trace() - spread;
        let finite = measure > 0.0 && inertia.iter().chain(off.iter()).all(|x| x.is_finite());
        finite.then_some(Moments { measure, centre: Point3::from(reference + off), inertia })
    }
}

impl Mesh {
    /// Returns the number of open edges, after points at the same position have been merged. An edge is open unless
    /// equally many triangles traverse it in each direction. A mesh without open edges encloses a volume.
    pub fn open_edges(&self) -> usize {
        let mut known: HashMap<[u64; 3], u32> = HashMap::new();
        // Adding 0 turns -0 into 0, which has other bits.
        let number = |p: &Point3<f64>| {
            let next = known.len() as u32;
            *known.entry([p.x, p.y, p.z].map(|x| (x + 0.0).to_bits())).or_insert(next)
        };
        let merged: Vec<u32> = self.vertices.iter().map(number).collect();
        let mut balance: HashMap<(u32, u32), i64> = HashMap::new();
        for triangle in &self.triangles {
            let corners = triangle.map(|i| merged.get(i as usize).copied().unwrap_or(u32::MAX));
            for (a, b) in [(0, 1), (1, 2), (2, 0)].map(|(a, b)| (corners[a], corners[b])) {
                if a != b {
                    *balance.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
                }
            }
        }
        // The order of a hash map does not affect a count.
        balance.values().filter(|sum| **sum != 0).count()
    }

    /// Returns the moments of the volume that the mesh encloses, as the sum of the signed tetrahedra between its
    /// triangles and a common point, or `None` if it encloses none. The mesh must be closed; see
    /// [`open_edges`](Mesh::open_edges).
    pub fn moments(&self) -> Option<Moments> {
        let (reference, size) = self.middle()?;
        let mut sums = MomentSums::default();
        for corners in self.corners(reference) {
            sums.add(corners[0].dot(&corners[1].cross(&corners[2])) / 6.0, corners, 4.0);
        }
        // The computed volume of a flat mesh consists of rounding errors only.
        sums.about(reference).filter(|m| m.measure > 1e-12 * size.powi(3))
    }

    /// Returns the moments of the mesh's surface, or `None` if it has no area.
    pub fn surface_moments(&self) -> Option<Moments> {
        let (reference, _) = self.middle()?;
        let mut sums = MomentSums::default();
        for corners in self.corners(reference) {
            let [a, b, c] = corners;
            sums.add((b - a).cross(&(c - a)).norm() / 2.0, corners, 3.0);
        }
        sums.about(reference)
    }

    /// Returns the centre and the diagonal of the bounding box. Moments are summed about this centre, because distant
    /// reference points increase rounding errors.
    fn middle(&self) -> Option<(Vector3<f64>, f64)> {
        let first = self.vertices.first()?;
        let (low, high) = self.vertices.iter().fold((*first, *first), |(l, h), p| (l.inf(p), h.sup(p)));
        Some(((low.coords + high.coords) / 2.0, (high - low).norm()))
    }

    fn corners(&self, reference: Vector3<f64>) -> impl Iterator<Item = [Vector3<f64>; 3]> + '_ {
        let point = move |i: u32| self.vertices.get(i as usize).map_or(Vector3::zeros(), |p| p.coords - reference);
        self.triangles.iter().map(move |t| t.map(point))
    }

    /// Returns an ellipsoid centred at the origin with the full extents `size`, m: a subdivided icosahedron of 642
    /// points on the ellipsoid, whose triangles are at most 0.5 % of the radius within it.
    pub fn ellipsoid(size: Vector3<f64>) -> Mesh {
        let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
        let mut points: Vec<Vector3<f64>> = Vec::new();
        for (a, b) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
            points.extend([Vector3::new(a, b, 0.0), Vector3::new(0.0, a, b), Vector3::new(b, 0.0, a)]);
        }
        points.iter_mut().for_each(|p| *p = p.normalize());
        // The faces of an icosahedron are the triples of mutual neighbours; 1.0514622 is the length of an edge.
        let near = |points: &[Vector3<f64>], i: usize, j: usize| (points[i] - points[j]).norm() < 1.1;
        let mut triangles: Vec<[usize; 3]> = Vec::new();
        for i in 0..12 {
            for j in i + 1..12 {
                for k in j + 1..12 {
                    if near(&points, i, j) && near(&points, j, k) && near(&points, i, k) {
                        let outward = points[i].dot(&points[j].cross(&points[k])) > 0.0;
                        triangles.push(if outward { [i, j, k] } else { [i, k, j] });
                    }
                }
            }
        }
        for _ in 0..3 {
            let mut halves: HashMap<(usize, usize), usize> = HashMap::new();
            let mut finer = Vec::with_capacity(4 * triangles.len());
            for [a, b, c] in triangles {
                let mut half = |i: usize, j: usize| {
                    *halves.entry((i.min(j), i.max(j))).or_insert_with(|| {
                        points.push((points[i] + points[j]).normalize());
                        points.len() - 1
                    })
                };
                let (ab, bc, ca) = (half(a, b), half(b, c), half(c, a));
                finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
            }
            triangles = finer;
        }
        Mesh {
            vertices: points.iter().map(|p| Point3::from(p.component_mul(&(size / 2.0)))).collect(),
            triangles: triangles.into_iter().map(|t| t.map(|i| i as u32)).collect(),
            coordinates: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// A cube of 1 m with one corner at the origin; the points of each face are separate, as in STL files.
    fn cube() -> Mesh {
        let faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
        let corner = |i: u32| Point3::new(f64::from(i >> 2), f64::from(i >> 1 & 1), f64::from(i & 1));
        let vertices = faces.iter().flatten().map(|i| corner(*i)).collect();
        let triangles = (0..6).flat_map(|f| [[4 * f, 4 * f + 1, 4 * f + 2], [4 * f, 4 * f + 2, 4 * f + 3]]).collect();
        Mesh { vertices, triangles, coordinates: Vec::new() }
    }

    #[test]
    fn cube_moments_equal_closed_form_wherever_its_origin_is() {
        for shift in [Vector3::zeros(), Vector3::new(1e3, -2e3, 0.5)] {
            let mut mesh = cube();
            mesh.vertices.iter_mut().for_each(|p| *p += shift);
            let m = mesh.moments().unwrap();
            assert!((m.measure - 1.0).abs() < 1e-12);
            assert!((m.centre.coords - shift - Vector3::repeat(0.5)).norm() < 1e-12);
            // m (b^2 + c^2) / 12
            assert!((m.inertia - Matrix3::identity() / 6.0).norm() < 1e-12, "{}", m.inertia);
        }
    }

    #[test]
    fn triangles_that_wind_inwards_enclose_the_same_solid() {
        let mut mesh = cube();
        mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        assert_eq!(mesh.open_edges(), 0);
        let m = mesh.moments().unwrap();
        assert!((m.measure - 1.0).abs() < 1e-12 && (m.inertia - Matrix3::identity() / 6.0).norm() < 1e-12);
    }

    #[test]
    fn missing_and_turned_triangles_leave_open_edges() {
        let mut mesh = cube();
        assert_eq!(mesh.open_edges(), 0);
        mesh.triangles[3].swap(0, 1);
        assert_eq!(mesh.open_edges(), 3);
        mesh.triangles.remove(3);
        assert_eq!(mesh.open_edges(), 3);
    }

    #[test]
    fn flat_mesh_has_surface_moments_only() {
        let plate = Mesh {
            vertices: [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]].map(|[x, y]| Point3::new(x, y, 3.0)).into(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [0, 2, 1], [0, 3, 2]],
            coordinates: Vec::new(),
        };
        assert_eq!((plate.open_edges(), plate.moments()), (0, None));
        let m = plate.surface_moments().unwrap();
        // Both sides of a plate of 2 m x 1 m: m b^2 / 12, m a^2 / 12, m (a^2 + b^2) / 12
        assert!((m.measure - 4.0).abs() < 1e-12 && (m.centre - Point3::new(1.0, 0.5, 3.0)).norm() < 1e-12);
        let expected = Matrix3::from_diagonal(&Vector3::new(4.0 / 12.0, 16.0 / 12.0, 20.0 / 12.0));
        assert!((m.inertia - expected).norm() < 1e-12);
        assert_eq!(Mesh::default().moments(), None);
    }

    #[test]
    fn ellipsoid_hull_is_closed_and_within_a_percent_of_the_ellipsoid() {
        let mesh = Mesh::ellipsoid(Vector3::new(0.2, 0.4, 0.6));
        assert_eq!((mesh.vertices.len(), mesh.triangles.len(), mesh.open_edges()), (642, 1280, 0));
        let on = mesh.vertices.iter().map(|p| (p.x / 0.1).powi(2) + (p.y / 0.2).powi(2) + (p.z / 0.3).powi(2));
        assert!(on.into_iter().all(|x| (x - 1.0).abs() < 1e-12));
        let volume = 4.0 / 3.0 * PI * 0.1 * 0.2 * 0.3;
        let m = mesh.moments().unwrap();
        assert!(m.measure < volume && m.measure > 0.99 * volume, "{}", m.measure / volume);
    }
}
