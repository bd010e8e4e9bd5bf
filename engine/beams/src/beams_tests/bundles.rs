//! Tests of bundles of rays against the same rays cast one by one.

use std::sync::Arc;

use fearless_simd::Level;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use tatu_geometry::{Form, Mesh};

use super::{
    super::{Beam, BeamScene, BeamTarget, BundleCast, BundleHits, Faces, Hit, RayBundle, simd},
    TestRng, target,
};

/// All results of a bundle's rays.
#[derive(Debug, Clone, PartialEq)]
struct BundleResults {
    distance: Vec<f64>,
    object: Vec<u64>,
    primitive: Vec<u32>,
    point: Vec<[f64; 3]>,
    normal: Vec<[f64; 3]>,
}

fn cast_at(level: Level, scene: &BeamScene, cast: &BundleCast<'_>) -> BundleResults {
    let n = cast.bundle.len();
    let mut a = BundleResults {
        distance: vec![-1.0; n],
        object: vec![99; n],
        primitive: vec![99; n],
        point: vec![[9.0; 3]; n],
        normal: vec![[9.0; 3]; n],
    };
    let hits = BundleHits {
        distance: &mut a.distance,
        object: &mut a.object,
        primitive: &mut a.primitive,
        point: &mut a.point,
        normal: &mut a.normal,
    };
    scene.cast_bundle_at(level, cast, hits);
    a
}

/// Casts the rays of a bundle one by one; returns each with its hit.
fn one_by_one(scene: &BeamScene, cast: &BundleCast<'_>) -> Vec<(Beam, Hit)> {
    let turn = |d: &Vector3<f64>| {
        UnitQuaternion::rotation_between(&Vector3::z(), d)
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI))
    };
    let beams = cast.bundle.directions().iter().map(|d| Beam {
        near: cast.near,
        max_incidence: cast.max_incidence,
        faces: cast.faces,
        skip_group: cast.skip_group,
        only_object: cast.only_object,
        ..Beam::ray(cast.world_from_sensor * turn(d), cast.far)
    });
    beams.map(|beam| (beam, scene.cast_one(&beam))).collect()
}

/// Returns the number of rays whose distances differ between the bundle and single casts, and the number of those that
/// also differ from 60 slightly displaced rays, which excludes silhouettes as the cause.
fn compare(scene: &BeamScene, cast: &BundleCast<'_>, dice: &mut TestRng) -> (usize, usize) {
    let found = cast_at(simd::level(), scene, cast);
    let (mut edges, mut wrong) = (0, 0);
    for (i, (beam, hit)) in one_by_one(scene, cast).into_iter().enumerate() {
        let close = |hit: &Hit| hit.distance == found.distance[i] || (hit.distance - found.distance[i]).abs() < 1e-4;
        if !close(&hit) {
            // The bundle computes with 32 bits. If that changes the hit at a silhouette or a limit, a ray that is
            // displaced by a similar amount must hit what the bundle hit.
            let size = 2e-4 + 3e-6 * hit.distance.min(beam.far);
            let moved = (0..60).any(|_| {
                let turn = UnitQuaternion::from_scaled_axis(dice.vector(1e-5));
                let moved = Translation3::from(dice.vector(size));
                let limits = (dice.between(-1e-4, 1e-4), dice.between(-1e-4, 1e-4), dice.between(-1e-3, 1e-3));
                let beside = Beam {
                    world_from_beam: moved * beam.world_from_beam * turn,
                    near: beam.near + limits.0,
                    far: beam.far + limits.1,
                    max_incidence: beam.max_incidence + limits.2,
                    ..beam
                };
                let hit = scene.cast_one(&beside);
                hit.distance == found.distance[i] || (hit.distance - found.distance[i]).abs() < 0.02
            });
            edges += 1;
            if !moved {
                wrong += 1;
                println!("ray {i}: {hit:?}, bundle {} of {}: {beam:?}", found.distance[i], found.object[i]);
            }
            continue;
        }
        if hit.is_some() {
            let d = cast.bundle.directions()[i];
            assert!((Vector3::from(found.point[i]) - d * found.distance[i]).norm() < 1e-9);
            let normal = Vector3::from(found.normal[i]);
            assert!((normal.norm() - 1.0).abs() < 1e-9 && normal.dot(&d) <= 1e-9, "{normal:?} {d:?}");
            if found.object[i] == hit.object && found.primitive[i] == hit.primitive {
                let turn = cast.world_from_sensor.rotation.inverse() * beam.world_from_beam.rotation;
                let aside = (normal - turn * hit.normal).norm();
                assert!(aside < 1e-2, "{normal:?} {:?} {:?} {aside}", turn * hit.normal, found.object[i]);
            }
        }
    }
    (edges, wrong)
}

fn random_form(dice: &mut TestRng, i: usize) -> Form {
    let (a, b, c) = (dice.between(0.05, 0.6), dice.between(0.05, 0.6), dice.between(0.05, 0.6));
    match i % 6 {
        0 => Form::Sphere { radius: a },
        1 => Form::Cylinder { radius: a, half_length: b },
        2 => Form::Capsule { radius: a, half_length: b },
        3 => terrain(dice),
        _ => Form::Box { half: Vector3::new(a, b, c) },
    }
}

/// Returns a bumpy square of 2 m.
fn terrain(dice: &mut TestRng) -> Form {
    let n = 12;
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..=n {
        for j in 0..=n {
            let at = |k: u32| 2.0 * f64::from(k) / f64::from(n) - 1.0;
            vertices.push(Point3::new(at(i), at(j), dice.between(-0.1, 0.1)));
        }
    }
    for i in 0..n {
        for j in 0..n {
            let a = i * (n + 1) + j;
            triangles.extend([[a, a + n + 1, a + n + 2], [a, a + n + 2, a + 1]]);
        }
    }
    Form::Mesh { mesh: Arc::new(Mesh { vertices, triangles, ..Default::default() }), convex: false }
}

fn random_scene(dice: &mut TestRng, targets: usize, size: f64) -> BeamScene {
    let mut scene = BeamScene::default();
    let mut all: Vec<BeamTarget> = (0..targets)
        .map(|i| BeamTarget { group: (i % 5) as u32, ..target(i as u64 + 1, dice.pose(size), random_form(dice, i)) })
        .collect();
    if dice.chance(0.5) {
        let below = Isometry3::translation(0.0, 0.0, -size);
        all.push(target(1000, below, Form::Plane));
    }
    scene.set(all);
    scene
}

/// Returns a random bundle: a fan, several layers, rays in all directions, or a single ray.
fn random_bundle(dice: &mut TestRng) -> RayBundle {
    let n = (dice.between(1.0, 300.0)) as usize;
    let open = dice.between(0.1, 6.2);
    let kind = (dice.unit() * 4.0) as usize;
    let directions: Vec<[f64; 3]> = (0..n)
        .map(|i| {
            let a = open * (i as f64 / n as f64 - 0.5);
            match kind {
                0 => [a.cos(), a.sin(), 0.0],
                1 => {
                    let up = ((i % 16) as f64 - 7.5) * 0.035;
                    [a.cos() * up.cos(), a.sin() * up.cos(), up.sin()]
                }
                2 => dice.vector(1.0).into(),
                _ => [0.0, 0.0, 1.0],
            }
        })
        .collect();
    RayBundle::new(&directions)
}

fn random_cast<'a>(dice: &mut TestRng, bundle: &'a RayBundle, size: f64) -> BundleCast<'a> {
    let mut cast = BundleCast::new(bundle, dice.pose(size), dice.between(1.0, 4.0 * size));
    if dice.chance(0.3) {
        cast.near = dice.between(0.0, 1.5);
    }
    if dice.chance(0.3) {
        cast.max_incidence = dice.between(0.2, 1.5);
    }
    if dice.chance(0.3) {
        cast.faces = if dice.chance(0.5) { Faces::FRONT } else { Faces::BACK };
    }
    if dice.chance(0.2) {
        cast.skip_group = Some(2);
    }
    if dice.chance(0.1) {
        cast.only_object = Some(5);
    }
    cast
}

#[test]
fn bundle_hits_match_single_rays() {
    let mut dice = TestRng(21);
    let (mut rays, mut edges, mut wrong) = (0, 0, 0);
    while rays < 30_000 {
        let size = dice.between(0.5, 12.0);
        let targets = dice.between(1.0, 60.0) as usize;
        let scene = random_scene(&mut dice, targets, size);
        let bundle = random_bundle(&mut dice);
        let cast = random_cast(&mut dice, &bundle, size);
        let (e, w) = compare(&scene, &cast, &mut dice);
        (rays, edges, wrong) = (rays + bundle.len(), edges + e, wrong + w);
    }
    println!("{rays} rays, {edges} beside edges, {wrong} wrong");
    assert_eq!(wrong, 0);
    assert!(edges * 1000 < rays, "{edges} of {rays} rays pass an edge closely");
}

#[test]
fn bundle_hits_are_bit_identical_at_all_simd_levels() {
    let mut dice = TestRng(22);
    let mut levels = vec![Level::baseline()];
    #[cfg(target_arch = "x86_64")]
    {
        levels.extend(Level::new().as_avx2().map(Level::Avx2));
        levels.extend(Level::new().as_avx512().map(Level::Avx512));
    }
    levels.push(Level::new());
    for _ in 0..150 {
        let size = dice.between(0.5, 12.0);
        let scene = random_scene(&mut dice, 40, size);
        let bundle = random_bundle(&mut dice);
        let cast = random_cast(&mut dice, &bundle, size);
        let first = cast_at(levels[0], &scene, &cast);
        for level in &levels[1..] {
            let bits = |a: &BundleResults| -> Vec<u64> {
                let points = a.point.iter().chain(&a.normal).flatten();
                a.distance.iter().chain(points).map(|x| x.to_bits()).collect()
            };
            let other = cast_at(*level, &scene, &cast);
            assert_eq!(bits(&first), bits(&other), "{level:?}");
            assert_eq!((&first.object, &first.primitive), (&other.object, &other.primitive), "{level:?}");
        }
    }
}
