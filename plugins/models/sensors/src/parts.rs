//! Parts shared by the devices: hidden bases, coloured bodies, joints, rays, script parameters.

use std::f64::consts::FRAC_1_SQRT_2;

use tatu_plugin_api::safe::{Builder, Node, Result, Value, keys};

/// The plugin; it has no state.
pub struct Devices;

/// A quarter turn about y, x y z w, which takes z to x: sensors look along their z axis.
pub const Z_AHEAD: [f64; 4] = [0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2];

/// The version that the scripts are written for. It is the last one in which scripts use tubes and are called in
/// V-REP's order, so adding a device does not change the dialect or the order of the scene's other scripts.
const DIALECT: &str = "4.1";

/// A layer that images do not show; V-REP uses it for collision-only shapes.
const HIDDEN: i64 = 256;

/// A part of a body: form, full extents, centre in the body's frame, m, and its color.
pub type Piece = (&'static str, [f64; 3], [f64; 3], [f64; 3]);

/// Builds the base of a model, `lift` above the surface that the device stands on: a hidden box, whose frame contains
/// the device's other objects.
pub fn base<'a>(builder: &Builder<'a>, alias: &str, size: [f64; 3], lift: f64) -> Result<Node<'a>> {
    builder
        .object("shape", None, alias)?
        .set("object.model_base", true)?
        .set("object.position", [0.0, 0.0, lift])?
        .set("object.layer", HIDDEN)?
        .set("shape.primitive", "box")?
        .set("shape.size", size)?
        .set("shape.detectable", false)
}

/// Builds the visible body. Beams ignore it: the device's own ray begins inside, and a sonar next to it must not detect
/// it.
pub fn body<'a>(builder: &Builder<'a>, parent: Option<Node<'a>>, alias: &str, pieces: &[Piece]) -> Result<Node<'a>> {
    let part = |(form, size, at, color): &Piece| {
        keys([
            ("primitive", Value::text(*form)),
            ("size", Value::Floats(size.to_vec())),
            ("position", Value::Floats(at.to_vec())),
            ("color", Value::Floats(color.to_vec())),
        ])
    };
    builder
        .object("shape", parent, alias)?
        .set("shape.primitive", "compound")?
        .set("shape.parts", Value::List(pieces.iter().map(part).collect()))?
        .set("shape.detectable", false)
}

/// Builds a joint about the z axis, which scripts turn.
pub fn joint<'a>(builder: &Builder<'a>, parent: Node<'a>, alias: &str, at: [f64; 3]) -> Result<Node<'a>> {
    builder
        .object("joint", Some(parent), alias)?
        .set("object.position", at)?
        .set("joint.type", "revolute")?
        .set("joint.mode", "kinematic")
}

/// Builds a ray along the x axis of its parent, which is measured only on request. Anything nearer than `near` is
/// ignored, and nothing beyond `range` is detected, m.
pub fn ray<'a>(builder: &Builder<'a>, parent: Node<'a>, alias: &str, near: f64, range: f64) -> Result<Node<'a>> {
    builder
        .object("sensor", Some(parent), alias)?
        .set("object.quaternion", Z_AHEAD)?
        .device("proximity")?
        .set("proximity.volume", "ray")?
        .set("proximity.near", near)?
        .set("proximity.range", range)?
        .set("sensor.explicit", true)
}

/// Builds a camera of depths and colours.
pub fn camera<'a>(builder: &Builder<'a>, parent: Node<'a>, alias: &str) -> Result<Node<'a>> {
    builder.object("sensor", Some(parent), alias)?.device("depth_camera")
}

/// Attaches a script to an object, with parameters that it reads by `sim.getScriptSimulationParameter`.
pub fn script<'a>(node: Node<'a>, name: &str, text: &str, parameters: &[(&str, String)]) -> Result<Node<'a>> {
    let map =
        parameters.iter().map(|(k, v)| (Value::text(format!("parameter.{k}")), Value::text(v.as_str()))).collect();
    node.set("object.data", Value::Map(map))?.script("lua", DIALECT, "child", name, text.as_bytes())
}
