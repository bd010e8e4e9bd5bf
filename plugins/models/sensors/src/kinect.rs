//! The Kinect of V-REP's library, in two versions.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use tatu_plugin_api::safe::{Builder, Fail, Model, Node, Param, Params, Result};

use crate::parts::{self, Devices, Piece};

/// Positions in the parents' frames, m, from V-REP's model in `kinect-color-point-cloud` and `grab-kinect`. The device
/// looks along +y of its base.
const FOOT: f64 = 0.020_611;
const TILT: f64 = 0.009_389;
const BAR: f64 = 0.023_221;
const GLASS: [f64; 3] = [0.0235, 0.029_504, -0.000_069];
const EYE: [f64; 3] = [-0.0141, 0.029_248, -0.000_221];

/// Orientation of the tilt joint: its z axis, along the bar's long axis, is the base's x axis. The body is attached
/// with the inverse orientation, `BACK`.
const Z_RIGHT: [f64; 4] = [0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2];
const BACK: [f64; 4] = [0.0, -FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2];
/// Orientation of a camera: it looks along its z axis, with y up, ahead of the bar.
const LOOK: [f64; 4] = [0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0];

const BLACK: [f64; 3] = [0.05, 0.05, 0.06];
const GREY: [f64; 3] = [0.20, 0.20, 0.22];
const LENS: [f64; 3] = [0.02, 0.03, 0.08];
const SILVER: [f64; 3] = [0.62, 0.63, 0.65];

/// A flat foot and the neck below the tilt joint.
const STAND: [Piece; 3] = [
    ("box", [0.083, 0.073, 0.010], [0.0, 0.0, -0.0156], BLACK),
    ("box", [0.060, 0.050, 0.008], [0.0, 0.0, -0.0066], GREY),
    ("cylinder", [0.028, 0.028, 0.024], [0.0, 0.0, 0.0086], BLACK),
];

/// The bar, with a narrow silver line at its bottom.
const HOUSING: [Piece; 3] = [
    ("box", [0.280, 0.056, 0.036], [0.0, -0.0015, 0.001], BLACK),
    ("box", [0.268, 0.059, 0.003], [0.0, 0.0, -0.0175], SILVER),
    ("box", [0.264, 0.004, 0.030], [0.0, 0.0275, 0.001], GREY),
];

/// Projector and two cameras behind the glass.
const FRONT: [Piece; 4] = [
    ("box", [0.093, 0.0006, 0.018], [0.0, 0.0, 0.0], LENS),
    ("sphere", [0.012, 0.012, 0.012], [-0.0376, -0.0016, 0.0], BLACK),
    ("sphere", [0.012, 0.012, 0.012], [-0.0125, -0.0016, 0.0], BLACK),
    ("sphere", [0.014, 0.014, 0.014], [0.0375, -0.0016, 0.0], BLACK),
];

const NEW: &str = "depth_rgb";
const OLD: &str = "vision_sensor";

/// The model "kinect".
pub struct Kinect;

impl Model for Kinect {
    type Plugin = Devices;
    const CATEGORY: &'static str = "sensors";
    const ID: &'static str = "kinect";
    const TEXT: &'static str = "Kinect as in V-REP: a bar on a tilting foot with a depth and a colour camera, 640 x 480 pixels, \
                                57 degrees, to 3.5 m, without noise. Stands on z = 0, looks along +y.";

    fn params() -> Vec<Param> {
        vec![
            Param::string("sensors").choices(&[NEW, OLD]).default(NEW).text(
                "Its sensors: `kinect_depth` and `kinect_rgb`, or, as in older releases, a single \
                 `kinect_visionSensor`.",
            ),
            Param::int("columns").range(1.0, 4096.0).default(640).text("Pixels per row."),
            Param::int("rows").range(1.0, 4096.0).default(480).text("Number of rows."),
            Param::float("angle")
                .unit("rad")
                .range(0.01, 3.1)
                .default(57f64.to_radians())
                .text("Angle between the edges of the image along its longer side."),
            Param::float("near").unit("m").range(0.0001, 1000.0).default(0.01).text("Nearest distance that is seen."),
            Param::float("far").unit("m").range(0.001, 1000.0).default(3.5).text("Farthest distance that is seen."),
            Param::float("tilt").unit("rad").range(-PI, PI).default(0.0).text("Angle by which the bar is tilted up."),
            Param::bool("explicit").default(false).text("Whether the cameras measure only on request."),
        ]
    }

    fn build(builder: &Builder<'_>, params: &Params<'_>) -> Result {
        let base = parts::body(builder, None, "kinect", &STAND)?
            .set("object.model_base", true)?
            .set("object.position", [0.0, 0.0, FOOT])?;
        let joint = parts::joint(builder, base, "kinect_joint", [0.0, 0.0, TILT])?
            .set("object.quaternion", Z_RIGHT)?
            .set("joint.position", params.f64("tilt")?)?;
        let body = parts::body(builder, Some(joint), "kinect_body", &HOUSING)?
            .set("object.position", [-BAR, 0.0, 0.0])?
            .set("object.quaternion", BACK)?;
        parts::body(builder, Some(body), "kinect_glass", &FRONT)?.set("object.position", GLASS)?;
        let names: &[&str] = match params.string("sensors")?.as_str() {
            NEW => &["kinect_depth", "kinect_rgb"],
            OLD => &["kinect_visionSensor"],
            other => return Err(Fail::argument(format!("`sensors` is `{other}`; expected `{NEW}` or `{OLD}`"))),
        };
        names.iter().try_for_each(|name| camera(builder, body, name, params))
    }
}

fn camera(builder: &Builder<'_>, body: Node<'_>, name: &str, params: &Params<'_>) -> Result {
    parts::camera(builder, body, name)?
        .set("object.position", EYE)?
        .set("object.quaternion", LOOK)?
        .set("depth_camera.columns", params.i64("columns")?)?
        .set("depth_camera.rows", params.i64("rows")?)?
        .set("depth_camera.perspective_angle", params.f64("angle")?)?
        .set("depth_camera.near", params.f64("near")?)?
        .set("depth_camera.far", params.f64("far")?)?
        .set("sensor.explicit", params.bool("explicit")?)?;
    Ok(())
}
