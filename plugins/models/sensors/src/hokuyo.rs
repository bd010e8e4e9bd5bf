//! The model Hokuyo_URG_04LX_UG01 of V-REP; its ray turns like the mirror of the device.

use tatu_plugin_api::safe::{Builder, Model, Param, Params, Result};

use crate::parts::{self, Devices, Piece};

/// Range in m, from V-REP's model in `rover` and `ackermannControlExample`: a ray of 0.022 + 5.578 m.
const NEAR: f64 = 0.022;
const RANGE: f64 = 5.6;
/// Extents of the device, m, from the same model and the maker's data sheet.
const SIZE: [f64; 3] = [0.05, 0.05, 0.07];
/// Height of the ray above the centre of the device, m; from the same model.
const RAY: f64 = 0.028;

const BLACK: [f64; 3] = [0.07, 0.07, 0.08];
const GLASS: [f64; 3] = [0.16, 0.10, 0.09];
const GREY: [f64; 3] = [0.22, 0.22, 0.24];

/// A black box with a round dark window, and a lid.
pub const BODY: [Piece; 4] = [
    ("box", [0.05, 0.05, 0.038], [0.0, 0.0, -0.016], BLACK),
    ("cylinder", [0.046, 0.046, 0.009], [0.0, 0.0, 0.0075], GREY),
    ("cylinder", [0.038, 0.038, 0.018], [0.0, 0.0, 0.021], GLASS),
    ("cylinder", [0.042, 0.042, 0.005], [0.0, 0.0, 0.0325], BLACK),
];

/// The model "hokuyo".
pub struct Hokuyo;

impl Model for Hokuyo {
    type Plugin = Devices;
    const CATEGORY: &'static str = "sensors";
    const ID: &'static str = "hokuyo";
    const TEXT: &'static str = "Hokuyo_URG_04LX_UG01 as in V-REP: one ray turned by a joint, 684 directions over 240 degrees, \
                                10 turns a second, with noise; its script tells points by signals. Looks along +x.";

    fn params() -> Vec<Param> {
        vec![
            Param::float("noise")
                .unit("m")
                .range(0.0, 1.0)
                .default(0.01)
                .text("Uniform error of distances, from -noise to noise; 0: exact."),
            Param::float("rate")
                .unit("Hz")
                .range(0.1, 1000.0)
                .default(10.0)
                .text("Turns per second; each step scans as much as it has time for."),
            Param::float("range").unit("m").range(0.1, 1000.0).default(RANGE).text("How far the ray sees."),
        ]
    }

    fn build(builder: &Builder<'_>, params: &Params<'_>) -> Result {
        let base = parts::base(builder, "Hokuyo_URG_04LX_UG01", SIZE, SIZE[2] / 2.0)?;
        let name = |part: &str| format!("Hokuyo_URG_04LX_UG01_{part}");
        parts::body(builder, Some(base), &name("body"), &BODY)?;
        let joint = parts::joint(builder, base, &name("joint"), [0.0, 0.0, RAY])?;
        parts::ray(builder, joint, &name("laser"), NEAR, params.f64("range")?)?;
        let parameters = ["noise", "rate"].map(|key| params.f64(key).map(|x| (key, x.to_string())));
        let [noise, rate] = parameters;
        parts::script(base, "hokuyo.lua", include_str!("lua/hokuyo.lua"), &[noise?, rate?])?;
        Ok(())
    }
}
