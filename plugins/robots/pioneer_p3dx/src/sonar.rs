//! The sonar ring: position and beam of each sensor.

use tatu_plugin_api::safe::{Builder, Node, Result};

use crate::presets::Robot;

/// The beam of a sonar, in m and rad.
pub struct Beam {
    pub range: f64,
    pub angle: f64,
    pub max_incidence: f64,
    pub min_range: f64,
}

/// Returns the orientation of a sensor that looks horizontally to `heading` degrees: z ahead, y up; x y z w.
pub fn looking(heading: f64) -> [f64; 4] {
    let (s, c) = libm::sincos(heading.to_radians() / 2.0);
    // The rotation that takes z to x, x to y and y to z, followed by the rotation by the heading.
    [(c - s) / 2.0, (c + s) / 2.0, (c + s) / 2.0, (c - s) / 2.0]
}

/// Adds the sixteen sensors as children of the visible body, whose frame is that of the base.
pub fn ring(builder: &Builder<'_>, body: Node<'_>, robot: &Robot, beam: &Beam) -> Result {
    for (i, [x, y, heading]) in robot.sonars.into_iter().enumerate() {
        let alias = format!("Pioneer_p3dx_ultrasonicSensor{}", i + 1);
        builder
            .object("sensor", Some(body), &alias)?
            .set("object.position", [x, y, robot.sonar_z - robot.height])?
            .set("object.quaternion", looking(heading))?
            .device("proximity")?
            .set("proximity.volume", "cone")?
            .set("proximity.range", beam.range)?
            .set("proximity.near", robot.sonar_tip)?
            .set("proximity.min_range", beam.min_range)?
            .set("proximity.angle", beam.angle)?
            .set("proximity.max_incidence", beam.max_incidence)?
            // No part of the robot is in the cones (a test checks that). Skipping them made a step of 100 robots twice
            // as fast.
            .set("proximity.skip_own_model", true)?;
    }
    Ok(())
}
