//! The model LaserScanner_2D: the SICK scanner of V-REP's library, which the course also uses.

use std::f64::consts::{FRAC_PI_2, PI};

use tatu_plugin_api::safe::{Builder, Model, Param, Params, Result, Value, keys};

use crate::parts::{self, Devices, Piece};

/// Range from the centre of the device, m; anything nearer is ignored. From V-REP's model in `World-Sick180-Log`: a ray
/// of 0.055 + 19.945 m.
const NEAR: f64 = 0.055;
const RANGE: f64 = 20.0;

/// Full extents, m, from the same model, upright.
const SIZE: [f64; 3] = [0.11, 0.11, 0.1];

const BLUE: [f64; 3] = [0.05, 0.24, 0.58];
const BLACK: [f64; 3] = [0.06, 0.06, 0.07];

/// A blue box with a dark window all around its front, like the LMS series.
const BODY: [Piece; 4] = [
    ("box", [0.11, 0.11, 0.04], [0.0, 0.0, -0.03], BLUE),
    ("cylinder", [0.098, 0.098, 0.028], [0.0, 0.0, 0.004], BLACK),
    ("box", [0.11, 0.11, 0.032], [0.0, 0.0, 0.034], BLUE),
    ("box", [0.04, 0.11, 0.028], [-0.035, 0.0, 0.004], BLUE),
];

const TEXT: &str = "LaserScanner_2D, V-REP's SICK: one ray turned by a joint; its script tells what it sees by a tube, a \
                    signal and a graph. Stands on z = 0, looks along +x.";

/// The model "laser_scanner_2d".
pub struct LaserScanner2d;

/// The model [`LaserScanner2d`] under the name of its manufacturer.
pub struct Sick;

impl Model for LaserScanner2d {
    type Plugin = Devices;
    const CATEGORY: &'static str = "sensors";
    const ID: &'static str = "laser_scanner_2d";
    const TEXT: &'static str = TEXT;

    fn params() -> Vec<Param> {
        params()
    }
    fn build(builder: &Builder<'_>, params: &Params<'_>) -> Result {
        build(builder, params)
    }
}

impl Model for Sick {
    type Plugin = Devices;
    const CATEGORY: &'static str = "sensors";
    const ID: &'static str = "sick";
    const TEXT: &'static str = TEXT;

    fn params() -> Vec<Param> {
        params()
    }
    fn build(builder: &Builder<'_>, params: &Params<'_>) -> Result {
        build(builder, params)
    }
}

fn params() -> Vec<Param> {
    vec![
        Param::float("scanning_angle")
            .unit("rad")
            .range(5f64.to_radians(), PI)
            .default(PI)
            .text("Angle that the script scans, half of it to each side."),
        Param::float("scanning_density")
            .range(0.1, 5.0)
            .default(2.0)
            .text("Points per degree: 2 gives 361 points over 180 degrees."),
        Param::float("range").unit("m").range(0.1, 1000.0).default(RANGE).text("How far the ray sees."),
        Param::string("log").default("").text("A file into which the script writes each scan; empty: none."),
    ]
}

fn build(builder: &Builder<'_>, params: &Params<'_>) -> Result {
    let base = parts::base(builder, "LaserScanner_2D", SIZE, SIZE[2] / 2.0)?;
    parts::body(builder, Some(base), "LaserScannerBody_2D", &BODY)?;
    let joint = parts::joint(builder, base, "LaserScannerJoint_2D", [0.0; 3])?
        .set("joint.limits", vec![-FRAC_PI_2, FRAC_PI_2])?;
    parts::ray(builder, joint, "LaserScannerLaser_2D", NEAR, params.f64("range")?)?;
    let stream = |name: &str| keys([("name", Value::text(name)), ("unit", Value::text("m"))]);
    let curve = keys([
        ("name", Value::text("scan")),
        ("x", Value::text("x")),
        ("y", Value::text("y")),
        ("unit", Value::text("m")),
    ]);
    builder
        .object("graph", Some(base), "LaserScannerGraph_2D")?
        .set("graph.explicit", true)?
        .set("graph.streams", Value::List(vec![stream("x"), stream("y")]))?
        .set("graph.curves", Value::List(vec![curve]))?;
    let parameters = [
        ("scanningAngle", params.f64("scanning_angle")?.to_degrees().to_string()),
        ("scanningDensity", params.f64("scanning_density")?.to_string()),
        ("log", params.string("log")?),
    ];
    parts::script(base, "laser_scanner_2d.lua", include_str!("lua/laser_scanner_2d.lua"), &parameters)?;
    Ok(())
}
