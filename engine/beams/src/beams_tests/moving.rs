//! Tests of targets that move one by one, or have invalid poses: the updated tree must give the same results as a new
//! scene.

use nalgebra::{Isometry3, Vector3};
use tatu_geometry::Form;

use super::{
    super::{Beam, BeamScene, BeamTarget, BundleCast, BundleHits, RayBundle},
    TestRng, target,
};

fn distances(scene: &BeamScene, bundle: &RayBundle, from: Isometry3<f64>) -> Vec<u64> {
    let mut distance = vec![0.0; bundle.len()];
    let hits = BundleHits { distance: &mut distance, ..Default::default() };
    scene.cast_bundle(&BundleCast::new(bundle, from, 50.0), hits);
    let one = scene.cast_one(&Beam::cone(from, 0.5, 50.0)).distance;
    distance.into_iter().chain([one]).map(f64::to_bits).collect()
}

fn random_rays(dice: &mut TestRng) -> RayBundle {
    let directions: Vec<[f64; 3]> = (0..200).map(|_| dice.vector(1.0).into()).collect();
    RayBundle::new(&directions)
}

fn random_crowd(dice: &mut TestRng, n: usize, size: f64) -> Vec<BeamTarget> {
    let form = |i: usize| match i % 3 {
        0 => Form::Sphere { radius: 0.3 },
        1 => Form::Cylinder { radius: 0.2, half_length: 0.4 },
        _ => Form::Box { half: Vector3::new(0.2, 0.3, 0.4) },
    };
    (0..n).map(|i| target(i as u64 + 1, dice.pose(size), form(i))).collect()
}

#[test]
fn single_moved_target_matches_a_new_scene() {
    let mut dice = TestRng(41);
    let bundle = random_rays(&mut dice);
    let mut scene = BeamScene::default();
    scene.set(random_crowd(&mut dice, 300, 6.0));
    for round in 0..200 {
        let index = (dice.unit() * 300.0) as usize;
        // Some targets are far away, or at an invalid position.
        let mut pose = dice.pose(if round % 10 == 0 { 30.0 } else { 6.0 });
        if round % 17 == 3 {
            pose.translation.vector.x = f64::NAN;
        }
        if round % 2 == 0 {
            scene.update_pose(index, pose)
        } else {
            scene.update_poses(&[(index, pose)])
        }
        let mut fresh = BeamScene::default();
        fresh.set(scene.targets().to_vec());
        let from = dice.pose(5.0);
        assert_eq!(distances(&scene, &bundle, from), distances(&fresh, &bundle, from), "round {round}");
    }
}

#[test]
fn bundle_matches_single_rays_among_ten_thousand_targets() {
    let mut dice = TestRng(42);
    let bundle = random_rays(&mut dice);
    let mut scene = BeamScene::default();
    scene.set(random_crowd(&mut dice, 10_000, 20.0));
    let mut distance = vec![0.0; bundle.len()];
    let mut edges = 0;
    for _ in 0..5 {
        let from = dice.pose(15.0);
        let cast = BundleCast::new(&bundle, from, 30.0);
        scene.cast_bundle(&cast, BundleHits { distance: &mut distance, ..Default::default() });
        for (d, found) in bundle.directions().iter().zip(&distance) {
            let Some(turn) = nalgebra::UnitQuaternion::rotation_between(&Vector3::z(), d) else { continue };
            let one = scene.cast_one(&Beam::ray(from * turn, 30.0)).distance;
            edges += usize::from(one != *found && (one - found).abs() > 1e-4);
        }
    }
    assert!(edges < 3, "{edges} of 1000 rays differ");
}

#[test]
fn invalid_targets_are_neither_hit_nor_occlude_others() {
    let mut dice = TestRng(43);
    let bundle = random_rays(&mut dice);
    let good = random_crowd(&mut dice, 60, 4.0);
    let mut scene = BeamScene::default();
    scene.set(good.clone());
    let nan = f64::NAN;
    let here = Isometry3::identity();
    let lost = Isometry3::translation(nan, 0.0, 0.0);
    let mut turned = here;
    turned.rotation = nalgebra::Unit::new_unchecked(nalgebra::Quaternion::new(nan, 0.0, 0.0, 1.0));
    let mut bad = vec![
        target(900, here, Form::Sphere { radius: nan }),
        target(901, here, Form::Sphere { radius: -1.0 }),
        target(902, here, Form::Box { half: Vector3::new(1.0, -1.0, 1.0) }),
        target(903, here, Form::Cylinder { radius: f64::INFINITY, half_length: 1.0 }),
        target(904, here, Form::Capsule { radius: 0.3, half_length: nan }),
        target(905, lost, Form::Plane),
    ];
    for pose in [lost, turned] {
        bad.extend(random_crowd(&mut dice, 6, 1.0).into_iter().map(|t| BeamTarget { world_from_target: pose, ..t }));
    }
    let mut mixed = BeamScene::default();
    mixed.set(bad.into_iter().chain(good));
    for _ in 0..50 {
        let from = dice.pose(3.0);
        assert_eq!(distances(&scene, &bundle, from), distances(&mixed, &bundle, from));
    }
    // A sensor with an invalid pose detects nothing.
    assert!(distances(&scene, &bundle, lost).iter().all(|d| f64::from_bits(*d) == f64::INFINITY));
    assert!(distances(&scene, &bundle, turned).iter().all(|d| f64::from_bits(*d) == f64::INFINITY));
}

#[test]
fn flat_box_is_hit_only_on_its_faces() {
    let flat = Form::Box { half: Vector3::new(1.0, 1.0, 0.0) };
    let nothing = Form::Sphere { radius: 0.0 };
    let mut scene = BeamScene::default();
    let ahead = Isometry3::translation(0.0, 0.0, 2.0);
    scene.set([target(1, ahead, flat), target(2, Isometry3::translation(0.0, 0.0, 1.0), nothing)]);
    let bundle =
        RayBundle::new(&[[0.0, 0.0, 1.0], [0.0, 1e-3, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [f64::NAN, 0.0, 1.0]]);
    let mut distance = vec![0.0; 5];
    let cast = BundleCast::new(&bundle, Isometry3::identity(), 5.0);
    scene.cast_bundle(&cast, BundleHits { distance: &mut distance, ..Default::default() });
    assert!((distance[1] - 2.0).abs() < 1e-4);
    assert!(distance[2..].iter().all(|d| *d == f64::INFINITY), "{distance:?}");
}

#[test]
fn bundle_hits_are_identical_for_all_thread_counts() {
    let mut dice = TestRng(44);
    let mut scene = BeamScene::default();
    scene.set(random_crowd(&mut dice, 200, 8.0));
    let large: Vec<[f64; 3]> = (0..5000).map(|_| dice.vector(1.0).into()).collect();
    let bundles =
        [random_rays(&mut dice), RayBundle::new(&large), RayBundle::new(&[[0.0, 0.0, 1.0]]), RayBundle::new(&[])];
    let poses: Vec<Isometry3<f64>> = (0..40).map(|_| dice.pose(6.0)).collect();
    let cast = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut out: Vec<Vec<f64>> = (0..poses.len()).map(|i| vec![0.0; bundles[i % 4].len()]).collect();
        let jobs = out.iter_mut().zip(&poses).enumerate().map(|(i, (distance, pose))| {
            (BundleCast::new(&bundles[i % 4], *pose, 30.0), BundleHits { distance, ..Default::default() })
        });
        let jobs: Vec<_> = jobs.collect();
        pool.install(|| scene.cast_bundles(jobs));
        out
    };
    let one = cast(1);
    assert_eq!(one, cast(2));
    assert_eq!(one, cast(3));
    // The same bundle, cast alone.
    let mut alone = vec![0.0; 5000];
    let question = BundleCast::new(&bundles[1], poses[1], 30.0);
    scene.cast_bundle(&question, BundleHits { distance: &mut alone, ..Default::default() });
    assert_eq!(alone, one[1]);
}
