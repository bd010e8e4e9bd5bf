//! Tests of joints with limits beyond half a turn.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Vector3};

use super::*;
use crate::{JointDesc, JointDrive, JointForm, JointId, JointKind, PassiveForces};

/// A joint at half a turn remains at that angle if its limits include it, although rapier's angle wraps there.
#[test]
fn joint_stays_within_limits_beyond_half_a_turn() {
    for form in [JointForm::Reduced, JointForm::Impulse] {
        let mut engine = engine(0.005);
        let (low, high) = (47.0_f64.to_radians(), 313.0_f64.to_radians());
        let joint = hinge(&mut engine, form, (low, high), PI);
        engine.advance(5);
        assert!((engine.joint_state(joint).position - PI).abs() < 1e-3, "{form:?}: {:?}", engine.joint_state(joint));
        for (target, end) in [(1.5 * PI, 1.5 * PI), (10.0, high), (0.0, low)] {
            engine.drive(joint, towards(target));
            engine.advance(600);
            let at = engine.joint_state(joint).position;
            assert!((at - end).abs() < 0.01, "{form:?}: {at} instead of {end}");
        }
    }
}

/// Between limits more than a turn apart, positions include whole turns.
#[test]
fn positions_between_wide_limits_include_whole_turns() {
    for form in [JointForm::Reduced, JointForm::Impulse] {
        let mut engine = engine(0.005);
        let joint = hinge(&mut engine, form, (-10.0, 13.0), 2.0 * PI + 0.5);
        assert!((engine.joint_state(joint).position - (2.0 * PI + 0.5)).abs() < 1e-9, "{form:?}");
        for (target, end) in [(12.0, 12.0), (20.0, 13.0), (-9.0, -9.0), (-20.0, -10.0)] {
            engine.drive(joint, towards(target));
            engine.advance(1500);
            let at = engine.joint_state(joint).position;
            assert!((at - end).abs() < 0.01, "{form:?}: {at} instead of {end}");
        }
    }
}

fn towards(target: f64) -> JointDrive {
    JointDrive::Position { target, max_force: 50.0, max_velocity: 5.0, tracking: None }
}

/// Adds a wheel of 1 kg on a fixed axle along z, at a given position.
fn hinge(engine: &mut Rapier, form: JointForm, limits: (f64, f64), position: f64) -> JointId {
    let base = engine.add_body(&fixed(Isometry3::identity(), vec![]));
    let wheel = engine.add_body(&body(turned(Vector3::zeros(), Vector3::z(), position), mass(1.0, [0.01; 3]), vec![]));
    let desc = JointDesc {
        a: base,
        b: wheel,
        frame_in_a: Isometry3::identity(),
        frame_in_b: Isometry3::identity(),
        kind: JointKind::Revolute,
        limits: Some(limits),
        position,
        form,
        passive: PassiveForces::default(),
        geared: false,
    };
    engine.add_joint(&desc).unwrap()
}
