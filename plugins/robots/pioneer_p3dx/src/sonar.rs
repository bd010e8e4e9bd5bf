//! The ring of sonars: where each one is, and what it sends out.

use tatu_plugin_api::safe::{Builder, Node, Result};

use crate::presets::Robot;

/// x, y in the base frame, m; heading, degrees, left positive.
pub type Pose = [f64; 3];

/// V-REP's model, sensors 1 to 16. Numbers 2 and 3 are not quite the mirror of 7 and 6; they are kept so.
#[rustfmt::skip]
pub const AS_VREP: [Pose; 16] = [
    [ 0.1064,  0.1382,   90.0], [ 0.1554,  0.1250,   50.0], [ 0.1906,  0.0831,   30.0], [ 0.2092,  0.0273,   10.0],
    [ 0.2092, -0.0273,  -10.0], [ 0.1905, -0.0785,  -30.0], [ 0.1555, -0.1202,  -50.0], [ 0.1064, -0.1381,  -90.0],
    [-0.1103, -0.1382,  -90.0], [-0.1596, -0.1202, -130.0], [-0.1946, -0.0785, -150.0], [-0.2132, -0.0273, -170.0],
    [-0.2132,  0.0273,  170.0], [-0.1946,  0.0785,  150.0], [-0.1596,  0.1203,  130.0], [-0.1103,  0.1382,   90.0],
];

/// ARIA's `SonarUnit` 0 to 15 of the P3-DX: mm from the middle of the axle, degrees.
#[rustfmt::skip]
const ARIA: [Pose; 16] = [
    [  69.0,  136.0,   90.0], [ 114.0,  119.0,   50.0], [ 148.0,   78.0,   30.0], [ 166.0,   27.0,   10.0],
    [ 166.0,  -27.0,  -10.0], [ 148.0,  -78.0,  -30.0], [ 114.0, -119.0,  -50.0], [  69.0, -136.0,  -90.0],
    [-157.0, -136.0,  -90.0], [-203.0, -119.0, -130.0], [-237.0,  -78.0, -150.0], [-255.0,  -27.0, -170.0],
    [-255.0,   27.0,  170.0], [-237.0,   78.0,  150.0], [-203.0,  119.0,  130.0], [-157.0,  136.0,   90.0],
];

/// ARIA's table in the base frame, whose origin is `axle_x` behind the axle.
pub fn aria(axle_x: f64) -> [Pose; 16] {
    ARIA.map(|[x, y, heading]| [x / 1000.0 + axle_x, y / 1000.0, heading])
}

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
