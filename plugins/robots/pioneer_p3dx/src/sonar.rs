//! The ring of sonars: where each one is, and what it sends out.

use tatu_plugin_api::safe::{Builder, Node, Result};

use crate::presets::Robot;

/// What a sonar sends out: m and rad.
pub struct Beam {
    pub range: f64,
    pub angle: f64,
    pub max_incidence: f64,
    pub min_range: f64,
}

/// Orientation of a sensor that looks horizontally to `heading` degrees: z ahead, y up; x y z w.
pub fn looking(heading: f64) -> [f64; 4] {
    let (s, c) = libm::sincos(heading.to_radians() / 2.0);
    // A turn by the heading after the one that brings z to x, x to y and y to z.
    [(c - s) / 2.0, (c + s) / 2.0, (c + s) / 2.0, (c - s) / 2.0]
}

/// Adds the sixteen sensors below the visible body, whose frame is the base's.
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
            // No part of the robot is in the cones (a test looks); not to ask made a step of 100 robots twice as fast.
            .set("proximity.skip_own_model", true)?;
    }
    Ok(())
}
