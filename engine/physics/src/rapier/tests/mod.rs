//! Tests of the engine against closed-form solutions.

mod bodies;
mod calm;
mod collision_filter;
mod contact_refresh;
mod detection;
mod drives;
mod economy;
mod energy;
mod faces;
mod gears;
mod mechanisms;
mod park;
mod push;
mod rest;
mod separation;
mod state;
mod turns;
mod two_wheels;

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};
use tatu_geometry::{Form, SolidPart};

use super::Rapier;
use crate::{
    BodyDesc, BodyId, CollisionMask, Engine, EngineSettings, JointDesc, JointForm, JointKind, MassProps, MotionType,
    PassiveForces,
};

const G: f64 = 9.81;

fn engine(step: f64) -> Rapier {
    Rapier::new(EngineSettings { gravity: Vector3::new(0.0, 0.0, -G), step, ..EngineSettings::default() })
}

fn at(x: f64, y: f64, z: f64) -> Isometry3<f64> {
    Isometry3::translation(x, y, z)
}

fn turned(place: Vector3<f64>, axis: Vector3<f64>, angle: f64) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(place), UnitQuaternion::new(axis * angle))
}

fn mass(mass: f64, inertia: [f64; 3]) -> MassProps {
    MassProps { mass, com: Point3::origin(), inertia: Matrix3::from_diagonal(&Vector3::from(inertia)) }
}

fn part(form: Form) -> Vec<SolidPart> {
    vec![SolidPart::from(form)]
}

fn sphere(radius: f64) -> Vec<SolidPart> {
    part(Form::Sphere { radius })
}

/// Describes a free body in a separate tree that collides with everything.
fn body(pose: Isometry3<f64>, mass: MassProps, parts: Vec<SolidPart>) -> BodyDesc {
    BodyDesc { collision_mask: CollisionMask { mask: 0xffff, tree: 1 }, ..BodyDesc::dynamic(pose, mass, parts) }
}

fn fixed(pose: Isometry3<f64>, parts: Vec<SolidPart>) -> BodyDesc {
    BodyDesc::fixed(pose, parts)
}

fn floor(engine: &mut Rapier) -> BodyId {
    engine.add_body(&fixed(Isometry3::identity(), part(Form::Plane)))
}

/// Describes a joint of a tree without limits.
fn tree_joint(
    a: BodyId,
    b: BodyId,
    kind: JointKind,
    frame_in_a: Isometry3<f64>,
    frame_in_b: Isometry3<f64>,
) -> JointDesc {
    JointDesc {
        a,
        b,
        frame_in_a,
        frame_in_b,
        kind,
        limits: None,
        position: 0.0,
        form: JointForm::Tree,
        passive: PassiveForces::default(),
        geared: false,
    }
}

/// Adds a block of 2 kg that a fixed joint makes a tree with a block of 1 kg on top. Returns the lower block.
fn tower(engine: &mut Rapier, pose: Isometry3<f64>, tree: u32) -> BodyId {
    let collision_mask = CollisionMask { mask: 0xff00, tree };
    let [low, top] = [(0.1, 2.0), (0.3, 1.0)].map(|(z, m)| {
        let block = part(Form::Box { half: Vector3::repeat(0.1) });
        let desc = body(pose * at(0.0, 0.0, z), mass(m, [m / 150.0; 3]), block);
        engine.add_body(&BodyDesc { collision_mask, ..desc })
    });
    engine.add_joint(&tree_joint(low, top, JointKind::Fixed, at(0.0, 0.0, 0.1), at(0.0, 0.0, -0.1)));
    low
}
