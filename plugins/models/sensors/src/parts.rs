//! What the devices share: hidden bases, coloured bodies, joints, rays, parameters of scripts.

use std::f64::consts::FRAC_1_SQRT_2;

use tatu_plugin_api::safe::{Builder, Node, Result, Value, keys};

/// The plugin; it keeps nothing.
pub struct Devices;

/// A quarter turn about y, x y z w, which brings z ahead: sensors look along their z axis.
pub const Z_AHEAD: [f64; 4] = [0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2];

/// The version the scripts are written for: the last whose scripts report by tubes and are called as V-REP's were, so
/// that a device changes neither manners nor order of the scripts beside it.
const DIALECT: &str = "4.1";

/// A layer that pictures do not show; V-REP keeps what only collides there.
const HIDDEN: i64 = 256;

/// One part of a body: form, full extents, middle in the body's frame, m, and its color.
pub type Piece = (&'static str, [f64; 3], [f64; 3], [f64; 3]);

/// The base of a model: a box that pictures do not show, in whose frame the device's other objects lie, `lift` above
/// what it is placed on.
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

/// What one sees of it. No beam meets it: its own ray begins inside, and a sonar beside it is not to see it.
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

/// A joint that scripts turn, about the z axis.
pub fn joint<'a>(builder: &Builder<'a>, parent: Node<'a>, alias: &str, at: [f64; 3]) -> Result<Node<'a>> {
    builder
        .object("joint", Some(parent), alias)?
        .set("object.position", at)?
        .set("joint.type", "revolute")?
        .set("joint.mode", "kinematic")
}

/// A ray along the x axis of its parent, which measures only on request: what is nearer than `near` is looked
/// through, and nothing is seen beyond `range`, m.
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

/// A camera of depths and colours.
pub fn camera<'a>(builder: &Builder<'a>, parent: Node<'a>, alias: &str) -> Result<Node<'a>> {
    builder.object("sensor", Some(parent), alias)?.device("depth_camera")
}

/// Gives an object its script, and parameters that it reads with `sim.getScriptSimulationParameter`.
pub fn script<'a>(node: Node<'a>, name: &str, text: &str, parameters: &[(&str, String)]) -> Result<Node<'a>> {
    let map =
        parameters.iter().map(|(k, v)| (Value::text(format!("parameter.{k}")), Value::text(v.as_str()))).collect();
    node.set("object.data", Value::Map(map))?.script("lua", DIALECT, "child", name, text.as_bytes())
}
