//! The model fastHokuyo: V-REP's scanner made of two cameras with one row of pixels each.

use std::f64::consts::FRAC_PI_3;

use tatu_plugin_api::safe::{Builder, Model, Param, Params, Result};

use crate::{
    hokuyo,
    parts::{self, Devices},
};

/// From V-REP's model in `pioneer_empty_world`: each camera sees 120 degrees in 256 pixels, from 0.04 to 5 m.
const PIXELS: i64 = 256;
const OPENING: f64 = 2.0 * FRAC_PI_3;
const NEAR: f64 = 0.04;
const FAR: f64 = 5.0;
/// Extents of the device, and height of the cameras above its centre, m; from the same model.
const SIZE: [f64; 3] = [0.05, 0.05, 0.07];
const EYE: f64 = 0.028;

/// Orientation of a camera, which looks along its z axis with y up: along the joint's x axis.
const LOOK: [f64; 4] = [0.5, 0.5, 0.5, 0.5];

/// The model "fast_hokuyo".
pub struct FastHokuyo;

impl Model for FastHokuyo {
    type Plugin = Devices;
    const CATEGORY: &'static str = "sensors";
    const ID: &'static str = "fast_hokuyo";
    const TEXT: &'static str = "fastHokuyo as in V-REP: two cameras of 256 x 1 pixels see 240 degrees to 5 m in each step, exactly; \
                                its script tells points by a signal. Looks along +x.";

    fn params() -> Vec<Param> {
        vec![
            Param::float("scan_angle")
                .unit("rad")
                .range(0.0175, 2.0 * OPENING)
                .default(2.0 * OPENING)
                .text("Angle that the script reports, half of it to each side."),
            Param::float("max_scan_distance")
                .unit("m")
                .range(NEAR, 1000.0)
                .default(FAR)
                .text("How far the cameras see."),
        ]
    }

    fn build(builder: &Builder<'_>, params: &Params<'_>) -> Result {
        let far = params.f64("max_scan_distance")?;
        let base = parts::base(builder, "fastHokuyo", SIZE, SIZE[2] / 2.0)?;
        let body = parts::body(builder, Some(base), "fastHokuyo_body", &hokuyo::BODY)?;
        for (i, heading) in [(1, -FRAC_PI_3), (2, FRAC_PI_3)] {
            let joint = parts::joint(builder, body, &format!("fastHokuyo_joint{i}"), [0.0, 0.0, EYE])?
                .set("joint.position", heading)?;
            parts::camera(builder, joint, &format!("fastHokuyo_sensor{i}"))?
                .set("object.quaternion", LOOK)?
                .set("depth_camera.columns", PIXELS)?
                .set("depth_camera.rows", 1_i64)?
                .set("depth_camera.perspective_angle", OPENING)?
                .set("depth_camera.near", NEAR)?
                .set("depth_camera.far", far)?
                .set("sensor.explicit", true)?;
        }
        builder.object("dummy", Some(base), "fastHokuyo_ref")?.set("object.position", [0.0, 0.0, -SIZE[2] / 2.0])?;
        let parameters =
            [("scanAngle", params.f64("scan_angle")?.to_degrees().to_string()), ("maxScanDistance", far.to_string())];
        parts::script(base, "fast_hokuyo.lua", include_str!("lua/fast_hokuyo.lua"), &parameters)?;
        Ok(())
    }
}
