//! The moving and colliding parts, which beams also hit.

use std::f64::consts::FRAC_1_SQRT_2;

use tatu_plugin_api::safe::{Builder, Node, Result, Value, keys};

use crate::{look, numbers::*};

/// Collision masks: the low byte applies within the car, where the body (bits 4 to 7) and the wheels (bits 0 to 3) do
/// not collide; the high byte applies to all other objects.
const BODY_MASK: i64 = 0xFFF0;
const WHEEL_MASK: i64 = 0xFF0F;

/// A quarter turn about x, x y z w, which takes z to the left.
const Z_TO_LEFT: [f64; 4] = [-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2];

const BLACK: [f64; 3] = [0.08, 0.08, 0.09];
const GLASS: [f64; 3] = [0.35, 0.45, 0.5];

/// Alias of the mount for other devices.
pub const SLOT: &str = "Manta_connection";

/// Number of segments, to each side, of the curve from the steering angle to the angle of a front wheel. Their ends are
/// on the true curve, and their middles deviate from it by less than 0.0002 rad.
const PIECES: i32 = 24;

fn cuboid(size: [f64; 3], at: [f64; 3], color: [f64; 3]) -> Value {
    keys([
        ("primitive", Value::text("box")),
        ("size", Value::Floats(size.to_vec())),
        ("position", Value::Floats(at.to_vec())),
        ("color", Value::Floats(color.to_vec())),
    ])
}

/// Builds the body. Its frame is that of the rear axle.
pub fn base<'a>(builder: &Builder<'a>, color: [f64; 3]) -> Result<Node<'a>> {
    let middle = WHEELBASE / 2.0;
    let boxes = vec![
        cuboid([0.56, 0.22, 0.07], [middle, 0.0, 0.01], color),
        cuboid([0.16, 0.16, 0.05], [WHEELBASE + 0.06, 0.0, 0.0], color),
        cuboid([0.16, 0.26, 0.05], [-0.06, 0.0, 0.02], color),
        cuboid([0.22, 0.18, 0.06], [middle - 0.04, 0.0, 0.075], GLASS),
        cuboid([0.04, 0.34, 0.02], [-0.12, 0.0, 0.105], BLACK),
    ];
    let wheels = keys([
        ("type", Value::text("ackermann")),
        ("joints", Value::List(vec![Value::text(":/motor_joint")])),
        ("steering", Value::List(vec![Value::text(":/steer_joint")])),
        ("radius", Value::Float(RADIUS)),
        ("track", Value::Float(TRACK)),
        ("wheelbase", Value::Float(WHEELBASE)),
    ]);
    builder
        .object("shape", None, "Manta")?
        .set("object.model_base", true)?
        .set("object.drive", wheels)?
        .set("object.position", [0.0, 0.0, RADIUS])?
        .set("shape.primitive", "compound")?
        .set("shape.parts", Value::List(boxes))?
        .set("shape.color", color)?
        .set("object.visible", false)?
        .set("shape.dynamic", true)?
        .set("shape.respondable", true)?
        .set("shape.respondable_mask", BODY_MASK)?
        .set("shape.mass", BODY_MASS)?
        .set("shape.inertia", BODY_INERTIA)?
        .set("shape.com", BODY_COM)
}

/// Builds a small part between two joints.
fn link<'a>(builder: &Builder<'a>, joint: Node<'a>, alias: &str, length: f64) -> Result<Node<'a>> {
    // Inside the hull or a wheel, so images do not show it.
    builder
        .object("shape", Some(joint), alias)?
        .set("shape.primitive", "cylinder")?
        .set("shape.size", [0.02, 0.02, length])?
        .set("shape.color", BLACK)?
        .set("object.visible", false)?
        .set("shape.dynamic", true)?
        .set("shape.mass", LINK_MASS)?
        .set("shape.inertia", LINK_INERTIA)
}

/// Builds a wheel that collides as a sphere: a cylinder touches the floor along a line, which slows the car's turning.
fn wheel<'a>(builder: &Builder<'a>, joint: Node<'a>, alias: &str) -> Result<Node<'a>> {
    let d = 2.0 * RADIUS;
    let wheel = builder
        .object("shape", Some(joint), alias)?
        .set("shape.primitive", "cylinder")?
        .set("shape.size", [d, d, WIDTH])?
        .set("shape.color", BLACK)?
        .set("shape.collide_as", "sphere")?
        .set("shape.collide_size", [d, d, d])?
        .set("shape.dynamic", true)?
        .set("shape.respondable", true)?
        .set("shape.respondable_mask", WHEEL_MASK)?
        .set("shape.mass", WHEEL_MASS)?
        .set("shape.inertia", WHEEL_INERTIA)?;
    look::rim(builder, wheel, alias)?;
    Ok(wheel)
}

fn joint<'a>(builder: &Builder<'a>, parent: Node<'a>, alias: &str, at: [f64; 3]) -> Result<Node<'a>> {
    builder.object("joint", Some(parent), alias)?.set("object.position", at)?.set("joint.type", "revolute")
}

/// Builds the joint that scripts steer, and the front wheels, which follow it.
pub fn steering<'a>(builder: &Builder<'a>, base: Node<'a>) -> Result {
    let steer = joint(builder, base, "steer_joint", [WHEELBASE, 0.0, 0.06])?
        .set("joint.control", "position")?
        .set("joint.limits", vec![-STEER_LIMIT, STEER_LIMIT])?
        .set("joint.max_velocity", STEER_SPEED)?
        .set("joint.max_force", STEER_TORQUE)?;
    link(builder, steer, "steer_column", 0.06)?;
    for (side, y) in [("l", TRACK / 2.0), ("r", -TRACK / 2.0)] {
        let curve: Vec<f64> = (-PIECES..=PIECES)
            .map(|i| STEER_LIMIT * f64::from(i) / f64::from(PIECES))
            .flat_map(|s| [s, ackermann(s, y)])
            .collect();
        let pivot = joint(builder, base, &format!("f{side}_steer_joint"), [WHEELBASE, y, 0.0])?
            .set("joint.control", "position")?
            // The inner wheel must turn farther than the steering in the same time.
            .set("joint.max_velocity", 2.0 * STEER_SPEED)?
            .set("joint.max_force", STEER_TORQUE)?
            .set("joint.follows", ":/steer_joint")?
            .set("joint.follow_curve", curve)?;
        let knuckle = link(builder, pivot, &format!("f{side}_knuckle"), 0.06)?;
        let axle = joint(builder, knuckle, &format!("f{side}_brake_joint"), [0.0; 3])?
            .set("object.quaternion", Z_TO_LEFT)?
            .set("joint.control", "velocity")?
            .set("joint.max_force", 0.0)?;
        wheel(builder, axle, &format!("f{side}_wheel"))?;
    }
    Ok(())
}

/// Builds the motor's shaft, and the rear wheels, which follow its speed.
pub fn drive<'a>(builder: &Builder<'a>, base: Node<'a>, torque: f64) -> Result {
    let motor = joint(builder, base, "motor_joint", [0.1, 0.0, 0.0])?
        .set("object.quaternion", Z_TO_LEFT)?
        .set("joint.control", "velocity")?
        .set("joint.max_force", torque)?;
    link(builder, motor, "motor_shaft", 0.1)?;
    for (side, y) in [("l", TRACK / 2.0), ("r", -TRACK / 2.0)] {
        let axle = joint(builder, base, &format!("b{side}_axle_joint"), [0.0, y, 0.0])?
            .set("object.quaternion", Z_TO_LEFT)?
            .set("joint.control", "velocity")?
            .set("joint.max_force", torque / 2.0)?
            .set("joint.slip", SLIP)?
            .set("joint.follows", ":/motor_joint")?;
        wheel(builder, axle, &format!("b{side}_wheel"))?;
        joint(builder, base, &format!("b{side}_brake_joint"), [0.0, y, 0.0])?
            .set("object.quaternion", Z_TO_LEFT)?
            .set("joint.mode", "kinematic")?
            .set("joint.follows", format!(":/b{side}_axle_joint").as_str())?;
    }
    Ok(())
}

/// Builds a mount for lasers and cameras, on the roof.
pub fn slot<'a>(builder: &Builder<'a>, base: Node<'a>) -> Result {
    builder.object("force_sensor", Some(base), SLOT)?.set("object.position", [WHEELBASE / 2.0, 0.0, 0.105])?;
    Ok(())
}
