//! Mechanisms that sleep while their motors stand still.

use nalgebra::{Isometry3, Vector3};
use tatu_geometry::Form;

use super::*;
use crate::{JointDesc, JointDrive, JointForm, JointId, JointKind, PassiveForces};

/// A block on the floor with a wheel and a turret that touch nothing, each on a vertical axis.
struct ParkedCart {
    engine: Rapier,
    block: BodyId,
    wheel: JointId,
    turret: JointId,
}

const STOP_DRIVE: JointDrive = JointDrive::Velocity { target: 0.0, max_force: 10.0, slip: 0.0 };
const TURN_DRIVE: JointDrive = JointDrive::Velocity { target: 1.0, max_force: 10.0, slip: 0.0 };

fn cart(form: JointForm) -> ParkedCart {
    let mut engine = engine(0.005);
    floor(&mut engine);
    let cube = part(Form::Box { half: Vector3::repeat(0.1) });
    let block = engine.add_body(&body(at(0.0, 0.0, 0.1), mass(5.0, [0.03; 3]), cube));
    let mut attached = |x: f64| {
        let small = part(Form::Sphere { radius: 0.05 });
        let wheel = engine.add_body(&body(at(x, 0.0, 0.3), mass(0.5, [0.001; 3]), small));
        let desc = JointDesc {
            a: block,
            b: wheel,
            frame_in_a: at(x, 0.0, 0.2),
            frame_in_b: Isometry3::identity(),
            kind: JointKind::Revolute,
            limits: None,
            position: 0.0,
            form,
            passive: PassiveForces::default(),
            geared: false,
        };
        engine.add_joint(&desc).unwrap()
    };
    let (wheel, turret) = (attached(-0.06), attached(0.06));
    engine.drive(wheel, STOP_DRIVE);
    engine.advance(800);
    ParkedCart { engine, block, wheel, turret }
}

impl ParkedCart {
    fn sleeps(&self) -> bool {
        let handle = self.engine.state.bodies.record(self.block).unwrap().handle;
        self.engine.state.bodies.world.bodies[handle].is_sleeping()
    }
}

#[test]
fn parked_mechanism_sleeps_and_wakes_for_any_of_its_drives() {
    for form in [JointForm::Impulse, JointForm::Reduced] {
        for turret_turns in [false, true] {
            let mut cart = cart(form);
            assert!(cart.sleeps());
            // The turret had no drive when the mechanism fell asleep.
            let joint = if turret_turns { cart.turret } else { cart.wheel };
            cart.engine.drive(joint, TURN_DRIVE);
            cart.engine.advance(400);
            let speed = cart.engine.joint_state(joint).velocity;
            assert!(!cart.sleeps() && (speed - 1.0).abs() < 1e-3, "{speed}");
            cart.engine.drive(joint, STOP_DRIVE);
            cart.engine.advance(800);
            assert!(cart.sleeps());
        }
    }
}

#[test]
fn parked_mechanism_wakes_when_it_is_pushed_hit_or_measured() {
    let mut pushed = cart(JointForm::Impulse);
    let block = pushed.block;
    pushed.engine.push(block, Vector3::new(100.0, 0.0, 0.0), Vector3::zeros());
    pushed.engine.advance(20);
    assert!(pushed.engine.pose(block).translation.x > 1e-3);
    let mut hit = cart(JointForm::Impulse);
    let ball = body(at(-0.3, 0.0, 0.1), mass(2.0, [0.002; 3]), sphere(0.05));
    let velocity = Vector3::new(3.0, 0.0, 0.0);
    hit.engine.add_body(&BodyDesc {
        linear_velocity: velocity,
        collision_mask: CollisionMask { mask: 0xffff, tree: 9 },
        ..ball
    });
    hit.engine.advance(100);
    assert!(hit.engine.pose(hit.block).translation.x > 1e-3);
    let mut measured = cart(JointForm::Impulse);
    measured.engine.measure(measured.turret);
    measured.engine.advance(800);
    assert!(!measured.sleeps());
}

#[test]
fn parked_mechanism_continues_from_a_snapshot() {
    let ParkedCart { engine: mut one, turret, .. } = cart(JointForm::Impulse);
    let mut two = engine(0.02);
    two.restore(&one.snapshot()).unwrap();
    for engine in [&mut one, &mut two] {
        engine.drive(turret, TURN_DRIVE);
        engine.advance(50);
    }
    assert!(one.snapshot() == two.snapshot());
}
