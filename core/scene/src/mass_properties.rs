//! Mass, centre of mass and inertia of shapes that do not state them: those of their form at uniform density.
//!
//! Primitives have closed forms. A mesh is the sum of the tetrahedra between its triangles and a point if it is closed,
//! and its convex hull otherwise. A compound is the sum of its parts.

use nalgebra::{Matrix3, Vector3};
use tatu_geometry::{Mesh, steiner};
use tatu_physics::hull;

use super::{
    Primitive, Shape,
    object::{LumpForm, MassDistribution, MassLump},
};

/// Density of shapes without a given mass, kg/m^3: that of water.
const DEFAULT_DENSITY: f64 = 1000.0;

/// Returns the mass of a shape, kg: its own, or that at the default density, at least 1e-6 kg.
pub fn mass(shape: &Shape) -> f64 {
    shape.mass.unwrap_or_else(|| {
        mass_distribution(shape).lumps.iter().map(|l| l.volume * DEFAULT_DENSITY).sum::<f64>().max(1e-6)
    })
}

/// Returns the centre of mass of a shape in its frame, m: its own, or the centroid of its form.
pub fn centre_of_mass(shape: &Shape) -> Vector3<f64> {
    shape.com.unwrap_or_else(|| mass_distribution(shape).centre)
}

/// Returns the inertia of a shape about its centre of mass, kg m^2: its own, or that of its form at uniform density.
pub fn inertia(shape: &Shape) -> Matrix3<f64> {
    shape.inertia.map_or_else(|| uniform_inertia(shape, mass(shape)), |i| Matrix3::from_row_slice(&i))
}

/// Returns the inertia of a shape with a given mass and uniform density, about its centre of mass, kg m^2. If an axis
/// has no inertia, returns a small multiple of the identity instead, which the engine can invert.
pub fn uniform_inertia(shape: &Shape, mass: f64) -> Matrix3<f64> {
    let MassDistribution { lumps, .. } = mass_distribution(shape);
    let com = centre_of_mass(shape);
    let (measures, total) = measures(lumps);
    let mut sum = Matrix3::zeros();
    for (lump, measure) in lumps.iter().zip(measures) {
        let m = mass * measure / total;
        let r = lump.pose.rotation.to_rotation_matrix();
        let own = r.matrix() * lump.solid.inertia(m) * r.matrix().transpose();
        sum += own + m * steiner(&(lump.centre() - com));
    }
    if sum.diagonal().min() > 0.0 { sum } else { Matrix3::identity() * (mass * 1e-3) }
}

/// Returns the number of open edges of the meshes of a shape that are replaced by their convex hulls because they are
/// not closed; 0 if the shape states its mass, centre of mass and inertia, or has no such meshes.
pub(crate) fn open_edges(shape: &Shape) -> usize {
    let stated = shape.mass.is_some() && shape.com.is_some() && shape.inertia.is_some();
    if stated { 0 } else { mass_distribution(shape).lumps.iter().map(|l| l.open).sum() }
}

fn mass_distribution(shape: &Shape) -> &MassDistribution {
    shape.derived.mass_distribution.get_or_init(|| {
        let lumps: Vec<MassLump> = match shape.primitive {
            Primitive::Compound => shape
                .parts
                .iter()
                .map(|p| MassLump { pose: p.pose, ..mass_lump(p.primitive, p.size, (p.mesh.as_deref(), p.convex)) })
                .collect(),
            own => vec![mass_lump(own, shape.size, (shape.mesh.as_deref(), shape.convex))],
        };
        let (measures, total) = measures(&lumps);
        let centre: Vector3<f64> =
            lumps.iter().zip(measures).map(|(l, m)| l.centre() * m).sum::<Vector3<f64>>() / total;
        // Rounding errors of a symmetric compound are removed.
        let reach = lumps.iter().map(|l| l.centre().amax()).fold(0.0, f64::max);
        let centre = centre.map(|x| if x.abs() <= 1e-12 * reach { 0.0 } else { x });
        MassDistribution { lumps, centre }
    })
}

/// Returns a measure for each lump to which its mass is proportional, and the sum of these measures: the volumes or, if
/// no lump has a volume, the areas or, if none has an area, 1 each.
fn measures(lumps: &[MassLump]) -> (Vec<f64>, f64) {
    let area = |l: &MassLump| if let LumpForm::Mesh(m) = &l.solid { m.measure } else { 0.0 };
    let ways: [&dyn Fn(&MassLump) -> f64; 3] = [&|l| l.volume, &area, &|_| 1.0];
    let all = ways.map(|measure| lumps.iter().map(measure).collect::<Vec<f64>>());
    let with_sum = |m: Vec<f64>| (m.iter().sum(), m);
    let found = all.into_iter().map(with_sum).find(|(sum, _)| *sum > 0.0);
    found.map_or((Vec::new(), 1.0), |(sum, m)| (m, sum))
}

fn mass_lump(primitive: Primitive, size: Vector3<f64>, (mesh, convex): (Option<&Mesh>, bool)) -> MassLump {
    let of = |solid, volume, open| MassLump { pose: nalgebra::Isometry3::identity(), solid, volume, open };
    let Some(mesh) = mesh.filter(|_| primitive == Primitive::Mesh) else {
        return of(LumpForm::Primitive(primitive, size), volume(primitive, size), 0);
    };
    let open = if convex { 0 } else { mesh.open_edges() };
    let whole = if convex || open > 0 { hull(mesh).and_then(|h| h.moments()) } else { mesh.moments() };
    match whole {
        Some(m) => of(LumpForm::Mesh(m), m.measure, open),
        // A flat mesh is a plate.
        None => match mesh.surface_moments() {
            Some(m) => of(LumpForm::Mesh(m), 0.0, 0),
            None => of(LumpForm::Primitive(Primitive::Mesh, size), 0.0, 0),
        },
    }
}

fn volume(primitive: Primitive, size: Vector3<f64>) -> f64 {
    use std::f64::consts::PI;
    let radius = size.x / 2.0;
    match primitive {
        Primitive::Box => size.x * size.y * size.z,
        Primitive::Sphere if size.x == size.y && size.y == size.z => 4.0 / 3.0 * PI * radius.powi(3),
        Primitive::Sphere => PI / 6.0 * size.x * size.y * size.z,
        Primitive::Cylinder => PI * radius * radius * size.z,
        Primitive::Capsule => PI * radius * radius * straight_length(size) + 4.0 / 3.0 * PI * radius.powi(3),
        Primitive::Plane | Primitive::Mesh | Primitive::Compound => 0.0,
    }
}

/// Returns the length of the straight part of a capsule, m.
fn straight_length(size: Vector3<f64>) -> f64 {
    (size.z - size.x).max(0.0)
}

impl MassLump {
    /// Returns the centroid in the shape's frame, m.
    fn centre(&self) -> Vector3<f64> {
        match &self.solid {
            LumpForm::Primitive(..) => self.pose.translation.vector,
            LumpForm::Mesh(m) => (self.pose * m.centre).coords,
        }
    }
}

impl LumpForm {
    /// Returns the inertia about the centroid for a mass, in the part's frame, kg m^2.
    fn inertia(&self, m: f64) -> Matrix3<f64> {
        let diagonal = |x: f64, y: f64, z: f64| Matrix3::from_diagonal(&Vector3::new(x, y, z));
        let (form, size) = match self {
            LumpForm::Mesh(moments) => return moments.inertia * (m / moments.measure),
            LumpForm::Primitive(form, size) => (form, size),
        };
        let (square, radius) = (size.component_mul(size), size.x / 2.0);
        let r2 = radius * radius;
        match form {
            Primitive::Box => diagonal(
                m * (square.y + square.z) / 12.0,
                m * (square.x + square.z) / 12.0,
                m * (square.x + square.y) / 12.0,
            ),
            Primitive::Sphere if size.x == size.y && size.y == size.z => Matrix3::identity() * (0.4 * m * r2),
            Primitive::Sphere => diagonal(
                m * (square.y + square.z) / 20.0,
                m * (square.x + square.z) / 20.0,
                m * (square.x + square.y) / 20.0,
            ),
            Primitive::Cylinder => {
                let side = m * (3.0 * r2 + square.z) / 12.0;
                diagonal(side, side, m * r2 / 2.0)
            }
            Primitive::Capsule => {
                let l = straight_length(*size);
                // Shares of the straight part and of the two hemispheres, whose volumes relate as l to 4/3 radius.
                let (rod, ball) = (m * l / (l + 4.0 / 3.0 * radius), m * radius / (0.75 * l + radius));
                let side = rod * (3.0 * r2 + l * l) / 12.0 + ball * (0.4 * r2 + l * l / 4.0 + 0.375 * l * radius);
                diagonal(side, side, rod * r2 / 2.0 + ball * 0.4 * r2)
            }
            Primitive::Plane | Primitive::Mesh | Primitive::Compound => Matrix3::zeros(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::{f64::consts::PI, sync::Arc};

    use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion};

    use super::*;
    use crate::ShapePart;

    fn part(primitive: Primitive, size: [f64; 3], pose: Isometry3<f64>) -> ShapePart {
        ShapePart {
            primitive,
            size: size.into(),
            pose,
            color: None,
            opacity: None,
            friction: None,
            texture: None,
            mesh_number: 0,
            mesh: None,
            convex: false,
        }
    }

    fn compound(parts: Vec<ShapePart>) -> Shape {
        Shape { primitive: Primitive::Compound, parts, ..Default::default() }
    }

    fn near(a: &Matrix3<f64>, b: &Matrix3<f64>) -> bool {
        (a - b).norm() <= 1e-9 * b.norm()
    }

    #[test]
    fn box_of_water_has_mass_and_inertia_of_closed_form() {
        let shape = Shape { size: Vector3::new(1.0, 0.5, 0.2), ..Default::default() };
        assert!((mass(&shape) - 100.0).abs() < 1e-9);
        assert!((inertia(&shape)[(2, 2)] - 100.0 * (1.0 + 0.25) / 12.0).abs() < 1e-9);
    }

    #[test]
    fn two_half_boxes_equal_one_box() {
        let half = |x: f64| part(Primitive::Box, [0.5, 0.5, 0.2], Isometry3::translation(x, 0.0, 0.0));
        let halves = compound(vec![half(-0.25), half(0.25)]);
        let whole = Shape { size: Vector3::new(1.0, 0.5, 0.2), ..Default::default() };
        assert!((mass(&halves) - mass(&whole)).abs() < 1e-9);
        assert_eq!(centre_of_mass(&halves), Vector3::zeros());
        assert!(near(&inertia(&halves), &inertia(&whole)));
    }

    #[test]
    fn compound_of_three_boxes_has_centre_and_inertia_of_closed_form() {
        let cube = |x: f64, y: f64| part(Primitive::Box, [1.0; 3], Isometry3::translation(x, y, 0.5));
        let bracket = compound(vec![cube(0.5, 0.5), cube(1.5, 0.5), cube(0.5, 1.5)]);
        assert!((centre_of_mass(&bracket) - Vector3::new(5.0 / 6.0, 5.0 / 6.0, 0.5)).norm() < 1e-12);
        // m / 6 for each, and m times the squares and products of the distances (-1/3 -1/3), (2/3 -1/3), (-1/3 2/3)
        // from the common centre: the squares add up to 2/3 along each axis, the products to -1/3.
        let (across, up, mixed) = (500.0 + 2000.0 / 3.0, 500.0 + 4000.0 / 3.0, 1000.0 / 3.0);
        let expected = Matrix3::new(across, mixed, 0.0, mixed, across, 0.0, 0.0, 0.0, up);
        assert!(near(&inertia(&bracket), &expected), "{}", inertia(&bracket));
    }

    #[test]
    fn capsule_inertia_equals_closed_form() {
        let shape = Shape { primitive: Primitive::Capsule, size: Vector3::new(0.2, 0.2, 0.6), ..Default::default() };
        let (r, l) = (0.1_f64, 0.4);
        let (rod, ball) = (1000.0 * PI * r * r * l, 1000.0 * 4.0 / 3.0 * PI * r.powi(3));
        let about = rod * r * r / 2.0 + ball * 0.4 * r * r;
        let across = rod * (l * l / 12.0 + r * r / 4.0) + ball * (0.4 * r * r + l * l / 4.0 + 0.375 * l * r);
        assert!((mass(&shape) - rod - ball).abs() < 1e-9);
        assert!(near(&inertia(&shape), &Matrix3::from_diagonal(&Vector3::new(across, across, about))));
        // Without a straight part, a capsule is a ball.
        let ball = Shape { size: Vector3::repeat(0.2), ..shape };
        let ball = Shape { derived: Default::default(), ..ball };
        assert!(near(&inertia(&ball), &(Matrix3::identity() * (0.4 * mass(&ball) * 0.01))));
    }

    #[test]
    fn ellipsoid_has_mass_and_inertia_of_closed_form() {
        let shape = Shape { primitive: Primitive::Sphere, size: Vector3::new(0.2, 0.4, 0.6), ..Default::default() };
        let (a, b, c) = (0.1, 0.2, 0.3);
        let m = 1000.0 * 4.0 / 3.0 * PI * a * b * c;
        let expected = Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b) * (m / 5.0);
        assert!((mass(&shape) - m).abs() < 1e-9);
        assert!(near(&inertia(&shape), &Matrix3::from_diagonal(&expected)));
    }

    /// A tetrahedron with corners at the origin and at 1 m on each axis; its centroid is at 1/4 each, and its inertia
    /// about this is m 3/40 on the diagonal and m 1/80 off it.
    fn corner() -> Mesh {
        Mesh {
            vertices: [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Point3::from).into(),
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
            coordinates: Vec::new(),
        }
    }

    fn mesh_shape(mesh: Mesh, convex: bool) -> Shape {
        Shape { primitive: Primitive::Mesh, mesh: Some(Arc::new(mesh)), convex, ..Default::default() }
    }

    #[test]
    fn closed_open_and_convex_meshes_have_moments_of_closed_form() {
        let mut open = corner();
        open.triangles.pop();
        for (shape, edges) in
            [(mesh_shape(corner(), false), 0), (mesh_shape(corner(), true), 0), (mesh_shape(open, false), 3)]
        {
            assert_eq!(open_edges(&shape), edges);
            assert!((mass(&shape) - 1000.0 / 6.0).abs() < 1e-9);
            assert!((centre_of_mass(&shape) - Vector3::repeat(0.25)).norm() < 1e-12);
            let (own, off) = (3.0 / 40.0, 1.0 / 80.0);
            let expected = Matrix3::new(own, off, off, off, own, off, off, off, own) * (1000.0 / 6.0);
            assert!(near(&inertia(&shape), &expected), "{}", inertia(&shape));
        }
    }

    #[test]
    fn rotated_mesh_in_a_compound_has_rotated_moments() {
        let turn = UnitQuaternion::from_euler_angles(0.3, -0.5, 0.7);
        let pose = Isometry3::from_parts(Translation3::new(1.0, 2.0, 3.0), turn);
        let mut mesh = part(Primitive::Mesh, [0.1; 3], pose);
        mesh.mesh = Some(Arc::new(corner()));
        let (alone, shape) = (mesh_shape(corner(), false), compound(vec![mesh]));
        assert!((centre_of_mass(&shape) - (pose * Point3::new(0.25, 0.25, 0.25)).coords).norm() < 1e-12);
        let r = turn.to_rotation_matrix();
        assert!(near(&inertia(&shape), &(r.matrix() * inertia(&alone) * r.matrix().transpose())));
    }

    #[test]
    fn stated_centre_of_mass_shifts_the_inertia_to_it() {
        let shape = Shape { com: Some(Vector3::new(0.0, 0.0, 0.1)), mass: Some(2.0), ..Default::default() };
        // m (2 a^2) / 12 + m d^2 across, and without the distance about z
        let (about, across) = (2.0 * 0.02 / 12.0, 2.0 * 0.02 / 12.0 + 2.0 * 0.01);
        assert!(near(&inertia(&shape), &Matrix3::from_diagonal(&Vector3::new(across, across, about))));
    }

    #[test]
    fn changing_the_form_changes_the_computed_values() {
        let mut scene = crate::Scene::default();
        let slot = scene.add(0, "s", Isometry3::identity(), crate::ObjectVariant::Shape(Box::default())).unwrap();
        let mass_of = |scene: &crate::Scene| mass(scene.get(slot).unwrap().shape().unwrap());
        assert!((mass_of(&scene) - 1.0).abs() < 1e-12);
        let size = tatu_plugin_api::safe::Value::Floats(vec![0.2, 0.1, 0.1]);
        crate::set(&mut scene, slot, crate::property_table::Property::SIZE, &size).unwrap();
        assert!((mass_of(&scene) - 2.0).abs() < 1e-12);
    }
}
