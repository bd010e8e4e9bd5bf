//! Tests with many targets: the tree against tests of every target; filters, ties and threads.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};
use tatu_geometry::Form;

use super::{
    super::{Beam, BeamScene, BeamTarget, Hit, Volume},
    TestRng, mesh, target,
};

fn random_targets(dice: &mut TestRng, count: u64) -> Vec<BeamTarget> {
    let shared = {
        let vertices = (0..60).map(|_| Point3::from(dice.vector(0.4))).collect();
        let index = |dice: &mut TestRng| (dice.unit() * 60.0) as u32;
        mesh(vertices, (0..40).map(|_| [0; 3].map(|_| index(dice))).collect())
    };
    (0..count)
        .map(|i| {
            let (a, b) = (dice.between(0.05, 0.4), dice.between(0.05, 0.4));
            let form = match i % 6 {
                0 => shared.clone(),
                1 => Form::Sphere { radius: a },
                2 => Form::Cylinder { radius: a, half_length: b },
                3 => Form::Capsule { radius: a, half_length: b },
                4 if i < 6 => Form::Plane,
                _ => Form::Box { half: Vector3::new(a, b, 0.2) },
            };
            BeamTarget { group: (i % 7) as u32, ..target(i, dice.pose(4.0), form) }
        })
        .collect()
}

fn random_beams(dice: &mut TestRng, count: usize) -> Vec<Beam> {
    (0..count)
        .map(|i| {
            let pose = dice.pose(4.0);
            let mut beam = dice.cone(pose, if i % 4 == 0 { 3.1 } else { 0.6 });
            if i % 3 == 0 {
                beam.volume = Volume::Ray;
            }
            beam.skip_group = (i % 5 == 0).then_some(3);
            beam.only_object = (i % 11 == 0).then_some(i as u64 % 50);
            beam
        })
        .collect()
}

pub(super) fn cast(scene: &BeamScene, beams: &[Beam]) -> Vec<Hit> {
    let mut hits = vec![Hit::NONE; beams.len()];
    scene.cast(beams, &mut hits);
    hits
}

#[test]
fn tree_hits_match_exhaustive_search() {
    let mut dice = TestRng(7);
    let mut seen = 0;
    for count in [1, 2, 30, 300] {
        let targets = random_targets(&mut dice, count);
        let beams = random_beams(&mut dice, 300);
        let mut scene = BeamScene::default();
        scene.set(targets.clone());
        let hits = cast(&scene, &beams);

        let mut expected = vec![Hit::NONE; beams.len()];
        for target in targets {
            let mut alone = BeamScene::default();
            alone.set([target]);
            for (hit, beam) in expected.iter_mut().zip(&beams) {
                let other = alone.cast_one(beam);
                if (other.distance, other.object) < (hit.distance, hit.object) {
                    *hit = other;
                }
            }
        }
        for ((hit, expected), beam) in hits.iter().zip(&expected).zip(&beams) {
            assert_eq!(hit, expected, "{beam:?}");
        }
        seen += hits.iter().filter(|hit| hit.is_some()).count();
    }
    assert!(seen > 150, "{seen}");
}

#[test]
fn moved_targets_match_a_new_scene_bit_for_bit() {
    let mut dice = TestRng(8);
    // Enough for more than one task of the thread pool.
    let mut targets = random_targets(&mut dice, 600);
    let beams = random_beams(&mut dice, 400);
    let mut moved = BeamScene::default();
    moved.set(targets.clone());
    for round in 0..6 {
        for target in &mut targets {
            let step = dice.pose(if round < 3 { 0.1 } else { 3.0 });
            target.world_from_target = step * target.world_from_target;
        }
        moved.update_poses(&targets.iter().map(|t| t.world_from_target).enumerate().collect::<Vec<_>>());
        let mut fresh = BeamScene::default();
        fresh.set(targets.clone());
        assert_eq!(cast(&moved, &beams), cast(&fresh, &beams), "round {round}");
    }
}

#[test]
fn hits_are_bit_identical_on_one_and_two_threads() {
    let mut dice = TestRng(9);
    let mut scene = BeamScene::default();
    scene.set(random_targets(&mut dice, 200));
    let beams = random_beams(&mut dice, 1000);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| cast(&scene, &beams))
    };
    assert_eq!(run(1), run(2));
}

#[test]
fn filters_and_ties_choose_the_target() {
    let place = Isometry3::translation(0.0, 0.0, 1.0);
    let block = Form::Box { half: Vector3::new(0.1, 0.1, 0.1) };
    let mut scene = BeamScene::default();
    scene.set([9, 4, 6].map(|object| BeamTarget { group: object as u32, ..target(object, place, block.clone()) }));
    for volume in [Volume::Ray, Volume::Cone { half_angle: 0.2 }] {
        let mut beam = Beam { volume, ..Beam::ray(Isometry3::identity(), 2.0) };
        let hit = scene.cast_one(&beam);
        assert_eq!((hit.object, hit.primitive, hit.normal), (4, 4, -Vector3::z()));
        assert!((hit.distance - 0.9).abs() < 1e-12);
        beam.skip_group = Some(4);
        assert_eq!(scene.cast_one(&beam).object, 6);
        beam.only_object = Some(9);
        assert_eq!(scene.cast_one(&beam).object, 9);
        beam.only_object = Some(4);
        assert!(!scene.cast_one(&beam).is_some());
    }
}

#[test]
fn meshes_share_one_tree_which_outlives_a_new_set() {
    let form = mesh(vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)], vec![[0, 1, 2]]);
    let mut scene = BeamScene::default();
    scene.set((0..3).map(|i| target(i, Isometry3::identity(), form.clone())));
    let tree = scene.trees[0].clone().unwrap();
    assert!(Arc::ptr_eq(&tree, scene.trees[2].as_ref().unwrap()));
    scene.set((0..2).map(|i| target(i, Isometry3::identity(), form.clone())));
    assert!(Arc::ptr_eq(&tree, scene.trees[1].as_ref().unwrap()));
    scene.set([]);
    assert!(scene.meshes.is_empty());
}
