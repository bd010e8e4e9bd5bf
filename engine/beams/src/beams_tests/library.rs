//! Tests of rays against parry, the collision library of the physics engine, which implements ray casts independently.

use nalgebra::{Isometry3, Point3, Vector3};
use rapier3d::{
    math::{Pose, Rotation, Vector},
    parry::{query::Ray, shape::SharedShape},
};
use tatu_geometry::Form;

use super::{
    super::{Beam, BeamScene, BeamTarget, Hit},
    TestRng, mesh, target,
};

const RAYS_PER_SCENE: usize = 30_000;
const DISTANCE_TOLERANCE_M: f64 = 1e-4;

/// Returns targets of all kinds of forms; the mesh is a bumpy ball.
fn forms(dice: &mut TestRng, count: u64) -> Vec<BeamTarget> {
    let ball = {
        let (rings, sectors) = (9_u32, 14_u32);
        let at = |i: u32, j: u32| {
            let (u, v) = (f64::from(i) / 9.0 * 3.1, f64::from(j) / 14.0 * std::f64::consts::TAU);
            let r = 0.3 + 0.05 * (3.0 * u).sin() * (2.0 * v).cos();
            Point3::new(r * u.sin() * v.cos(), r * u.sin() * v.sin(), r * u.cos())
        };
        let vertices = (0..=rings).flat_map(|i| (0..sectors).map(move |j| at(i, j))).collect();
        let place = |i: u32, j: u32| i * sectors + j % sectors;
        let squares = (0..rings).flat_map(|i| (0..sectors).map(move |j| (i, j)));
        let triangles = squares.flat_map(|(i, j)| {
            let [a, b, c, d] = [place(i, j), place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)];
            [[a, b, c], [a, c, d]]
        });
        mesh(vertices, triangles.collect())
    };
    (0..count)
        .map(|i| {
            let (a, b) = (dice.between(0.05, 0.4), dice.between(0.05, 0.4));
            let form = match i % 5 {
                0 => ball.clone(),
                1 => Form::Sphere { radius: a },
                2 => Form::Cylinder { radius: a, half_length: b },
                3 => Form::Capsule { radius: a, half_length: b },
                _ => Form::Box { half: Vector3::new(a, b, 0.2) },
            };
            target(i + 1, dice.pose(3.0), form)
        })
        .collect()
}

fn vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn pose(p: &Isometry3<f64>) -> Pose {
    let q = &p.rotation.coords;
    Pose { translation: vector(&p.translation.vector), rotation: Rotation::from_xyzw(q.x, q.y, q.z, q.w) }
}

/// Returns parry's shape for a form, and its rotation: parry's cylinders are along y, those of a form along z.
fn shape(form: &Form) -> (SharedShape, Pose) {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let y_to_z = Pose { translation: Vector::ZERO, rotation: Rotation::from_xyzw(half, 0.0, 0.0, half) };
    let shape = match form {
        Form::Plane => SharedShape::halfspace(Vector::Z),
        Form::Box { half } => SharedShape::cuboid(half.x, half.y, half.z),
        Form::Sphere { radius } => SharedShape::ball(*radius),
        Form::Cylinder { radius, half_length } => return (SharedShape::cylinder(*half_length, *radius), y_to_z),
        Form::Capsule { radius, half_length } => SharedShape::capsule_z(*half_length, *radius),
        Form::Mesh { mesh, .. } => {
            let points = mesh.vertices.iter().map(|v| vector(&v.coords)).collect();
            SharedShape::trimesh(points, mesh.triangles.clone()).expect("a mesh of triangles")
        }
    };
    (shape, Pose::IDENTITY)
}

/// Returns the distance to the nearest surface according to parry, from inside and outside, or infinity if there is
/// none.
fn by_parry(shapes: &[(SharedShape, Pose)], beam: &Isometry3<f64>, far: f64) -> f64 {
    let ray = Ray::new(vector(&beam.translation.vector), vector(&(beam.rotation * Vector3::z())));
    let hits = shapes.iter().filter_map(|(shape, pose)| shape.cast_ray(pose, &ray, far, false));
    hits.fold(f64::INFINITY, f64::min)
}

#[test]
fn ray_hits_match_parry() {
    let mut dice = TestRng(77);
    for count in [5, 40, 400] {
        let targets = forms(&mut dice, count);
        let shapes: Vec<_> = targets
            .iter()
            .map(|t| {
                let (shape, turn) = shape(&t.form);
                (shape, pose(&t.world_from_target) * turn)
            })
            .collect();
        let mut scene = BeamScene::default();
        scene.set(targets);
        let beams: Vec<Beam> = (0..RAYS_PER_SCENE).map(|_| Beam::ray(dice.pose(4.0), 12.0)).collect();
        let mut hits = vec![Hit::NONE; beams.len()];
        scene.cast(&beams, &mut hits);
        let (mut met, mut silhouettes) = (0, 0);
        for (beam, hit) in beams.iter().zip(&hits) {
            let at = &beam.world_from_beam;
            let theirs = by_parry(&shapes, at, 12.0);
            met += usize::from(hit.is_some());
            if hit.distance == theirs || (hit.distance - theirs).abs() < DISTANCE_TOLERANCE_M {
                continue;
            }
            // The two may disagree at a silhouette: then, for one of the slightly displaced rays, one of them must
            // return the other's original distance.
            let beside = (0..8).any(|k| {
                let turn = f64::from(k) * std::f64::consts::FRAC_PI_4;
                let shift = Vector3::new(turn.cos(), turn.sin(), 0.0) * 1e-5;
                let moved = at * nalgebra::Translation3::from(shift);
                let (a, b) = (scene.cast_one(&Beam::ray(moved, 12.0)).distance, by_parry(&shapes, &moved, 12.0));
                (a - theirs).abs() < DISTANCE_TOLERANCE_M
                    || a == theirs
                    || (b - hit.distance).abs() < DISTANCE_TOLERANCE_M
                    || b == hit.distance
            });
            assert!(beside, "{count} forms: {hit:?}, parry {theirs}: {beam:?}");
            silhouettes += 1;
        }
        println!("{count} forms: {met} rays of {RAYS_PER_SCENE} meet one, {silhouettes} differ at silhouettes");
        assert!(met >= 50);
        assert!(silhouettes * 1000 <= RAYS_PER_SCENE, "{silhouettes} rays of {RAYS_PER_SCENE} differ at silhouettes");
    }
}
