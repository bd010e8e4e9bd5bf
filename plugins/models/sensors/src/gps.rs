//! The model GPS: V-REP's script, which adds errors to the position of a reference.

use tatu_plugin_api::safe::{Builder, Model, Param, Params, Result};

use crate::parts::{self, Devices, Piece};

/// Half widths of the errors along x, y and z, m; from V-REP's model in `GPS-Compass`.
const NOISE: [f64; 3] = [0.1, 0.1, 0.05];
const SHIFT: [f64; 3] = [1.0, 1.0, 0.5];

const WHITE: [f64; 3] = [0.88, 0.87, 0.80];
const GREEN: [f64; 3] = [0.10, 0.35, 0.16];

/// A patch antenna on a board; the reference is the centre of the antenna.
const BODY: [Piece; 2] =
    [("box", [0.044, 0.044, 0.004], [0.0, 0.0, -0.005], GREEN), ("box", [0.026, 0.026, 0.006], [0.0, 0.0, 0.0], WHITE)];

/// The model "gps".
pub struct Gps;

impl Model for Gps {
    type Plugin = Devices;
    const CATEGORY: &'static str = "sensors";
    const ID: &'static str = "gps";
    const TEXT: &'static str = "GPS as in V-REP: the position of its reference with an error at each reading and one that stays \
                                for the run; its script tells it by a tube and by signals.";

    fn params() -> Vec<Param> {
        vec![
            Param::floats("noise", 3)
                .unit("m")
                .range(0.0, 100.0)
                .default(NOISE)
                .text("Uniform error of each reading along x, y and z, from -noise to noise; 0: exact."),
            Param::floats("shift", 3)
                .unit("m")
                .range(0.0, 100.0)
                .default(SHIFT)
                .text("Uniform error along x, y and z that is the same for all readings of a run."),
        ]
    }

    fn build(builder: &Builder<'_>, params: &Params<'_>) -> Result {
        let base = parts::body(builder, None, "GPS", &BODY)?.set("object.model_base", true)?;
        builder.object("dummy", Some(base), "GPS_reference")?;
        let (noise, shift) = (params.array::<3>("noise")?, params.array::<3>("shift")?);
        let named =
            |what: &str, x: [f64; 3]| ["x", "y", "z"].map(|axis| format!("{axis}{what}Amplitude")).into_iter().zip(x);
        let all: Vec<_> = named("Noise", noise).chain(named("Shift", shift)).collect();
        let parameters: Vec<_> = all.iter().map(|(key, x)| (key.as_str(), x.to_string())).collect();
        parts::script(base, "gps.lua", include_str!("lua/gps.lua"), &parameters)?;
        Ok(())
    }
}
