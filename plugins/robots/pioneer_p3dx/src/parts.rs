//! The moving and colliding parts: base, motors, wheels, caster, and mounts for other devices. None of them is visible.

use std::f64::consts::FRAC_1_SQRT_2;

use tatu_plugin_api::safe::{Builder, Node, Result, Value, keys};

use crate::{
    look,
    presets::{Mass, Robot, Wheel},
};

/// Collision masks, as in V-REP's model: the low byte applies within the robot, where the base (bits 4 to 7) and the
/// wheels (bits 0 to 3) do not collide; the high byte applies to all other objects.
const BASE_MASK: i64 = 0xFFF0;
const WHEEL_MASK: i64 = 0xFF0F;

/// A quarter turn about x that takes z to y (left), x y z w.
const Z_TO_LEFT: [f64; 4] = [-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2];
/// A half turn about z.
const ABOUT_FACE: [f64; 4] = [0.0, 0.0, 1.0, 0.0];

/// Aliases of [`slots`].
pub const SLOTS: &[&str] = &[
    "Pioneer_p3dx_connection1",
    "Pioneer_p3dx_connection2",
    "Pioneer_p3dx_connection3",
    "Pioneer_p3dx_connection4",
    "Pioneer_p3dx_connection5",
    "Pioneer_p3dx_connection6",
    "Pioneer_p3dx_connection7",
    "Pioneer_p3dx_connection8",
    "Pioneer_p3dx_connection9",
    "Pioneer_p3dx_connection10",
    "Pioneer_p3dx_connection11",
];

/// Positions of the slots, and their headings in degrees: ten on the deck, the last one low in front.
#[rustfmt::skip]
const SLOT_POSES: [[f64; 4]; 11] = [
    [0.0445, 0.0, 0.0983, 0.0], [0.0445, 0.13, 0.0983, 90.0], [0.1364, 0.0919, 0.0983, 45.0],
    [0.1645, 0.0, 0.0983, 0.0], [0.1364, -0.0919, 0.0983, -45.0], [0.0445, -0.13, 0.0983, -90.0],
    [-0.0455, 0.0, 0.0983, 180.0], [-0.1374, -0.105, 0.0983, -150.0], [-0.1655, 0.0, 0.0983, 180.0],
    [-0.1374, 0.105, 0.0983, 150.0], [0.2195, 0.0, -0.0711, 0.0],
];

/// Makes a shape hidden and dynamic.
fn moving<'a>(node: Node<'a>, m: &Mass) -> Result<Node<'a>> {
    node.set("shape.dynamic", true)?
        .set("shape.mass", m.mass)?
        .set("shape.inertia", m.inertia)?
        .set("shape.com", m.com)?
        .set("shape.detectable", false)?
        .set("object.visible", false)
}

/// Builds the base, standing on the floor: boxes inside the outlines of shell and deck.
pub fn base<'a>(builder: &Builder<'a>, robot: &Robot) -> Result<Node<'a>> {
    let mut boxes = look::boxes(&robot.shell, [robot.shell_z[0], robot.deck_z[0]], robot.height);
    boxes.extend(look::boxes(&robot.deck, robot.deck_z, robot.height));
    let motors = ["left", "right"].map(|side| Value::text(format!(":/Pioneer_p3dx_{side}Motor")));
    let wheels = keys([
        ("type", Value::text("differential")),
        ("joints", Value::List(motors.to_vec())),
        ("radius", Value::Float(robot.wheel.diameter / 2.0)),
        ("track", Value::Float(robot.track)),
        ("axle", Value::Float(robot.axle_x)),
    ]);
    let base = builder
        .object("shape", None, "Pioneer_p3dx")?
        .set("object.model_base", true)?
        .set("object.drive", wheels)?
        .set("object.position", [0.0, 0.0, robot.height])?
        .set("shape.primitive", "compound")?
        .set("shape.parts", Value::List(boxes))?
        .set("shape.respondable", true)?
        .set("shape.respondable_mask", BASE_MASK)?;
    moving(base, &robot.body)
}

/// Builds a wheel that collides as a sphere: a cylinder touches the floor along a line, which slows the robot's
/// turning.
fn wheel<'a>(node: Node<'a>, wheel: &Wheel, friction: f64) -> Result<Node<'a>> {
    let d = wheel.diameter;
    let node = node
        .set("shape.primitive", "cylinder")?
        .set("shape.size", [d, d, wheel.width])?
        .set("shape.collide_as", "sphere")?
        .set("shape.collide_size", [d, d, d])?
        .set("shape.friction", friction)?
        .set("shape.respondable", true)?
        .set("shape.respondable_mask", WHEEL_MASK)?;
    moving(node, &wheel.mass)
}

/// Builds motors and wheels. The motors' axes point left, so that a positive velocity drives ahead.
pub fn drive<'a>(builder: &Builder<'a>, base: Node<'a>, robot: &Robot) -> Result {
    let z = robot.wheel.diameter / 2.0 - robot.height;
    for (side, y) in [("right", -robot.track / 2.0), ("left", robot.track / 2.0)] {
        let motor = builder
            .object("joint", Some(base), &format!("Pioneer_p3dx_{side}Motor"))?
            .set("object.position", [robot.axle_x, y, z])?
            .set("object.quaternion", Z_TO_LEFT)?
            .set("joint.type", "revolute")?
            .set("joint.mode", "dynamic")?
            .set("joint.cyclic", true)?
            .set("joint.control", "velocity")?
            .set("joint.max_force", robot.max_force)?
            .set("joint.target_velocity", 0.0)?;
        let alias = format!("Pioneer_p3dx_{side}Wheel");
        let node = builder.object("shape", Some(motor), &alias)?;
        wheel(node, &robot.wheel, 1.0)?;
        look::wheel(builder, node, &robot.wheel, &format!("{alias}_visible"))?;
    }
    Ok(())
}

/// Builds the caster. It trails from the start; in V-REP's file it begins ahead of its swivel, and swings round.
pub fn caster<'a>(builder: &Builder<'a>, base: Node<'a>, robot: &Robot) -> Result {
    let c = &robot.caster;
    let free = |parent, alias| {
        builder
            .object("joint", Some(parent), alias)?
            .set("joint.type", "revolute")?
            .set("joint.mode", "dynamic")?
            .set("joint.cyclic", true)?
            .set("joint.control", "free")
    };
    let swivel =
        free(base, "Pioneer_p3dx_caster_freeJoint1")?.set("object.position", [c.x, 0.0, c.z - robot.height])?;
    let link = builder
        .object("shape", Some(swivel), "Pioneer_p3dx_caster_link")?
        .set("object.quaternion", ABOUT_FACE)?
        .set("shape.primitive", "cylinder")?
        .set("shape.size", [0.0353, 0.0353, 0.003])?;
    let link = moving(link, &c.link)?;
    look::fork(builder, link, c)?;
    let axle = free(link, "Pioneer_p3dx_caster_freeJoint2")?
        .set("object.position", [c.trail, 0.0, c.wheel.diameter / 2.0 - c.z])?
        .set("object.quaternion", look::Z_TO_RIGHT)?
        // Without any friction, as in V-REP, the engine accelerates the wheel without bound within an hour of turning.
        // Estimate: 1 mN m at 1 rad/s, the drag of a greased sleeve bearing; the wheel slides on the floor, so this
        // affects nothing else.
        .set("joint.damping", 0.001)?;
    let node = builder.object("shape", Some(axle), "Pioneer_p3dx_caster_wheel")?;
    wheel(node, &c.wheel, 0.0)?;
    look::caster_wheel(builder, node, c)
}

/// Builds mounts for lasers, cameras and grippers; V-REP's file has force sensors at the same positions.
pub fn slots<'a>(builder: &Builder<'a>, base: Node<'a>) -> Result {
    for (alias, [x, y, z, heading]) in SLOTS.iter().zip(SLOT_POSES) {
        let (s, c) = libm::sincos(heading.to_radians() / 2.0);
        builder
            .object("force_sensor", Some(base), alias)?
            .set("object.position", [x, y, z])?
            .set("object.quaternion", [0.0, 0.0, s, c])?;
    }
    Ok(())
}
