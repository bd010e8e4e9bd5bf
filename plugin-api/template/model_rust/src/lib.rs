//! my_plugin: a robot model in Rust. A body on two driven wheels and a caster ball; it stands on z = 0 and heads along
//! +x.
//!
//! Parameter: `wheel_radius`, 0.06 to 0.2 m. The axle is below the centre of the body, so `tatu.drive` moves this
//! centre.
//!
//! Build: `tatu plugin build`. Run the demo: `tatu plugin run`. The manual: `cargo doc -p tatu-plugin-api --open`.
#![forbid(unsafe_code)]

use std::f64::consts::FRAC_PI_2;

use tatu_plugin_api::{safe::*, tatu_plugin};

/// The plugin, which has no data.
struct ThisPlugin;

impl Plugin for ThisPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(ThisPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.model::<Cart>();
    }
}

/// Distance between the centres of the wheels, m.
const TRACK: f64 = 0.36;

struct Cart;

/// Converts three numbers to the value of a property.
fn three(numbers: [f64; 3]) -> Value {
    Value::Floats(numbers.to_vec())
}

/// Sets the properties that all dynamic shapes have in common. With this mask, parts of the robot do not collide with
/// each other (low byte 0), but with everything else (high byte).
fn solid(shape: Node<'_>, mass: f64) -> Result {
    let shape = shape.set("mass", mass)?.set("dynamic", true)?.set("respondable", true)?;
    shape.set("respondable_mask", 0xFF00)?;
    Ok(())
}

/// Adds a motor and its wheel. A joint rotates about its z axis, which is rotated by -90 degrees about x to point along
/// +y, so that a positive velocity drives forward. The wheel collides as a sphere, which has a single point of contact.
fn wheel(builder: &Builder<'_>, base: Node<'_>, radius: f64, y: f64, side: &str) -> Result {
    let joint = builder.object("joint", Some(base), &format!("{side}_motor"))?;
    let joint = joint.set("position", three([0.0, y, 0.0]))?.set("orientation", three([-FRAC_PI_2, 0.0, 0.0]))?;
    let joint = joint.set("control", "velocity")?.set("max_force", 5.0)?;
    let shape = builder.object("shape", Some(joint), &format!("{side}_wheel"))?;
    let shape = shape.set("primitive", "cylinder")?.set("size", three([2.0 * radius, 2.0 * radius, 0.04]))?;
    let shape = shape.set("collide_as", "sphere")?.set("collide_size", three([2.0 * radius; 3]))?;
    solid(shape.set("color", three([0.1; 3]))?, 0.5)
}

impl Model for Cart {
    type Plugin = ThisPlugin;

    const ID: &'static str = "my_plugin";
    const TEXT: &'static str = "A body on two driven wheels and a caster ball.";
    const CATEGORY: &'static str = "mobile robots";

    fn params() -> Vec<Param> {
        vec![Param::float("wheel_radius").unit("m").range(0.06, 0.2).default(0.1).text("Radius of the driven wheels.")]
    }

    fn build(builder: &Builder<'_>, params: &Params<'_>) -> Result {
        let r = params.f64("wheel_radius")?;

        // The body: its origin is on the axle. The centre of mass is slightly behind it, so that the caster carries
        // weight.
        let base = builder.object("shape", None, "my_plugin")?;
        let base = base.set("primitive", "box")?.set("size", three([0.4, 0.3, 0.1]))?;
        let base = base.set("position", three([0.0, 0.0, r]))?.set("color", three([0.9, 0.6, 0.1]))?;
        let base = base.set("com", three([-0.05, 0.0, -0.02]))?.set("model_base", true)?;
        solid(base, 6.0)?;

        wheel(builder, base, r, TRACK / 2.0, "left")?;
        wheel(builder, base, r, -TRACK / 2.0, "right")?;

        // The caster: a ball that rotates freely in all directions.
        let socket = builder.object("joint", Some(base), "caster_socket")?;
        let socket = socket.set("type", "spherical")?.set("position", three([-0.15, 0.0, -r / 2.0]))?;
        let caster = builder.object("shape", Some(socket), "caster")?;
        solid(caster.set("primitive", "sphere")?.set("size", three([r; 3]))?, 0.2)?;

        // The kinematics of the drive, for commands such as `tatu.drive`: the keys of `drive` in a scene, without
        // units.
        let motors = vec![Value::text(":/left_motor"), Value::text(":/right_motor")];
        base.set(
            "drive",
            Value::Map(vec![
                ("type".into(), "differential".into()),
                ("joints".into(), Value::List(motors)),
                ("radius".into(), r.into()),
                ("track".into(), TRACK.into()),
            ]),
        )?;
        Ok(())
    }
}

tatu_plugin! {
    plugin: ThisPlugin, id: "org.example.my_plugin", name: "my_plugin", version: "0.1.0", licence: "MIT",
}
