//! Builds the sensors that `<gazebo>` elements attach to links.

use nalgebra::Isometry3;
use tatu_importers_robots::{
    BuiltLink, BuiltRobot, DEFAULT_FIELD, Element, FindingKind, Findings, Robot, SensorBuilder, pose,
};
use tatu_plugin_api::safe::{Builder, Result};

/// Builds sensors, each with the name of its link. What cannot be built is left out.
pub fn build_sensors<'b>(
    builder: &Builder<'b>,
    robot: &Robot,
    built: &BuiltRobot<'b>,
    sensors: &[(String, Element)],
    findings: &Findings,
) {
    let maker = SensorBuilder { builder, findings, field: DEFAULT_FIELD };
    for (link, tag) in sensors {
        let found = robot.links.iter().position(|l| l.name == *link).and_then(|number| built.links.get(number));
        let Some(BuiltLink { node, pose, .. }) = found else {
            let text = format!("the sensor `{}` is left out: there is no link `{link}`", tag.label());
            findings.warn(FindingKind::Sensor, tag.line, text);
            continue;
        };
        if let Err(e) = own_pose(tag).and_then(|own| maker.sensor(tag, *node, &(pose * own))) {
            let line = e.place().map_or(tag.line, |(_, line)| line);
            let text = format!("the sensor `{}` is left out: {}", tag.label(), e.text());
            findings.warn(FindingKind::Sensor, line, text);
        }
    }
}

/// Returns the pose of a sensor in the frame of its link.
fn own_pose(tag: &Element) -> Result<Isometry3<f64>> {
    let [x, y, z, roll, pitch, yaw] = tag.numbers("pose")?.unwrap_or_default();
    pose([x, y, z], [roll, pitch, yaw], "<pose>", tag.line)
}
