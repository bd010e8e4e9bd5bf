//! Tests of beams cast as a group against the same beams cast alone.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use tatu_geometry::Form;

use super::{
    super::{Beam, BeamScene, BeamTarget, Volume, candidates},
    TestRng,
    scenes::cast,
    target,
};

/// Returns a floor and many robots, each a box and two wheels.
fn crowd(dice: &mut TestRng, robots: u64) -> Vec<BeamTarget> {
    let mut targets = vec![target(0, Isometry3::identity(), Form::Plane)];
    for robot in 1..=robots {
        let place = Translation3::new(dice.between(-8.0, 8.0), dice.between(-8.0, 8.0), 0.2);
        let base = Isometry3::from_parts(place, UnitQuaternion::new(Vector3::z() * dice.between(-3.0, 3.0)));
        let own = |form, at: Isometry3<f64>| BeamTarget { group: robot as u32, ..target(robot, base * at, form) };
        targets.push(own(Form::Box { half: Vector3::new(0.2, 0.15, 0.1) }, Isometry3::identity()));
        for y in [-0.2, 0.2] {
            let wheel = Form::Cylinder { radius: 0.1, half_length: 0.02 };
            targets.push(own(wheel, Isometry3::translation(0.0, y, -0.1)));
        }
    }
    targets
}

/// Returns `each` beams around each robot.
fn rings(dice: &mut TestRng, targets: &[BeamTarget], each: usize) -> Vec<Beam> {
    let bases = targets.iter().filter(|t| matches!(t.form, Form::Box { .. }));
    let bases: Vec<_> = bases.map(|t| (t.world_from_target, t.group)).collect();
    let mut beams = Vec::new();
    for (base, group) in bases {
        for k in 0..each {
            let turn = UnitQuaternion::new(Vector3::z() * k as f64) * UnitQuaternion::new(Vector3::y() * 1.57);
            let mut beam = dice.cone(base * Isometry3::from_parts(Translation3::new(0.1, 0.0, 0.0), turn), 0.6);
            beam.far = dice.between(0.5, 1.5);
            beam.skip_group = Some(group);
            if dice.chance(0.2) {
                beam.volume = Volume::Ray;
            }
            beams.push(beam);
        }
    }
    beams
}

#[test]
fn grouped_beams_hit_the_same_as_single_beams() {
    let mut dice = TestRng(21);
    let mut seen = BTreeSet::new();
    // In the last scene, more targets are near than a group can hold.
    for robots in [1, 30, 200, 4000] {
        let targets = crowd(&mut dice, robots);
        let mut scene = BeamScene::default();
        scene.set(targets.clone());
        for each in [1, 3, 16] {
            let mut beams = rings(&mut dice, &targets[..targets.len().min(300)], each);
            beams.iter_mut().step_by(7).for_each(|b| b.only_object = Some(5));
            let alone: Vec<_> = beams.iter().map(|beam| scene.cast_one(beam)).collect();
            assert_eq!(cast(&scene, &beams), alone);
            seen.extend(alone.iter().map(|hit| hit.object));
        }
    }
    assert!(seen.len() > 100, "{}", seen.len());
}

#[test]
fn groups_contain_only_near_beams_with_equal_filters() {
    let ring = |at: f64, n: usize| vec![Beam::cone(Isometry3::translation(at, 0.0, 0.0), 0.3, 1.0); n];
    let size = |beams: &[Beam]| candidates::leading_group(beams).map(|(n, _)| n);
    assert_eq!(size(&[]), None);
    assert_eq!(size(&ring(0.0, 3)), None);
    assert_eq!(size(&ring(0.0, 16)), Some(16));
    assert_eq!(size(&[ring(0.0, 16), ring(5.0, 16)].concat()), Some(16));
    let mut beams = ring(0.0, 16);
    beams[7].skip_group = Some(1);
    assert_eq!(size(&beams), Some(7));
    // A group ends before a beam whose `far` is not a finite distance, or whose pose is invalid.
    for strange in [
        Beam { volume: Volume::Cylinder { radius_near: 0.1, radius_far: 0.1 }, ..beams[0] },
        Beam { far: f64::INFINITY, ..beams[0] },
        Beam { far: f64::NAN, ..beams[0] },
        Beam::cone(Isometry3::translation(f64::NAN, 0.0, 0.0), 0.3, 1.0),
    ] {
        let mut beams = ring(0.0, 16);
        beams[5] = strange;
        assert_eq!(size(&beams), Some(5));
        beams[0] = strange;
        assert_eq!(size(&beams), None);
    }
}
