//! Builds the propellers of flying robots, which their files describe as plugins that drive joints.

use nalgebra::{Isometry3, Vector3};
use tatu_importers_robots::{BuiltRobot, Element, FindingKind, Findings, Robot, alias, set_object_pose};
use tatu_plugin_api::safe::{Builder, Result};

use crate::shapes::turn_z_to;

/// The name of the plugins.
pub const PLUGIN: &str = "MulticopterMotorModel";

/// Builds the propeller that a plugin describes. It pushes the link that carries its joint, along the joint's axis.
pub fn propeller<'b>(
    builder: &Builder<'b>,
    tag: &Element,
    robot: &Robot,
    built: &BuiltRobot<'b>,
    findings: &Findings,
) -> Result {
    let name = tag.text_of("jointName").unwrap_or_default();
    let joint = robot.joints.iter().find(|joint| joint.name == name);
    let carrier = joint.and_then(|joint| robot.links.iter().position(|link| link.name == joint.parent));
    let (Some(joint), Some(carrier)) = (joint, carrier) else {
        findings.warn(FindingKind::Plugin, tag.line, format!("a propeller is left out: there is no joint `{name}`"));
        return Ok(());
    };
    let number = |name: &str, default: f64| tag.finite(name).map(|x| x.unwrap_or(default).clamp(0.0, 1e6));
    let axis = Vector3::from(joint.axis).try_normalize(1e-9).unwrap_or_else(Vector3::z);
    let mount = &built.links[carrier];
    let node =
        builder.object("actuator", Some(mount.node), &alias(&format!("{name}_propeller")))?.device("propeller")?;
    let at: Isometry3<f64> = mount.pose * joint.pose * turn_z_to(&axis);
    let speed = number("maxRotVelocity", 838.0)?.clamp(1e-3, 1e5);
    let clockwise = tag.text_of("turningDirection") == Some("cw");
    set_object_pose(node, &at)?
        .set("propeller.max_speed", speed)?
        .set("propeller.max_thrust", (number("motorConstant", 8.54858e-6)? * speed * speed).min(1e6))?
        .set("propeller.torque_per_thrust", number("momentConstant", 0.016)?)?
        .set("propeller.turns", if clockwise { "clockwise" } else { "counter-clockwise" })?
        .set("propeller.time_constant", number("timeConstantUp", 1.0 / 80.0)?)?
        .set("propeller.time_constant_down", number("timeConstantDown", 1.0 / 40.0)?)?
        .set("propeller.rotor_drag", number("rotorDragCoefficient", 1e-4)?)?
        .set("propeller.rolling_moment", number("rollingMomentCoefficient", 1e-6)?)?;
    Ok(())
}
