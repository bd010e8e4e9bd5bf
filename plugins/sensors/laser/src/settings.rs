//! The parameters of a scanner, and quantities derived from them.

use std::f64::consts::{FRAC_PI_2, PI};

use tatu_plugin_api::safe::{Fail, Param, Params, Result};

/// The checked parameters of a scanner; lengths in m, angles in rad, times in s.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LaserSettings {
    pub start_angle: f64,
    pub end_angle: f64,
    /// Number of beams of each layer.
    pub beams: usize,
    /// Elevation of each layer, in the order in which layers are reported.
    pub elevations: Vec<f64>,
    pub near: f64,
    pub min_range: f64,
    pub range: f64,
    pub none_as_max: bool,
    pub full_intensity: f64,
    pub scan_time: f64,
    pub skip_own_model: bool,
}

/// Maximum number of beams of one sensor, which is also the host's limit.
const MAX_BEAMS: i64 = 1 << 24;

/// Declares the parameters of the sensor kind.
pub(crate) fn params() -> Vec<Param> {
    [
        Param::float("start_angle")
            .unit("rad")
            .range(-PI, PI)
            .default(-FRAC_PI_2)
            .text("Azimuth of the first beam, from straight ahead; to the left is positive."),
        Param::float("end_angle")
            .unit("rad")
            .range(-PI, PI)
            .default(FRAC_PI_2)
            .text("Azimuth of the last beam; greater than `start_angle`. Both ends are measured."),
        Param::int("rays").range(1.0, MAX_BEAMS as f64).default(181i64).text(
            "Beams of one layer, evenly spread from `start_angle` to `end_angle`; a single beam points along \
                   `start_angle`.",
        ),
        Param::int("layers").range(1.0, 4096.0).default(1i64).text("Number of layers, one above the other."),
        Param::float("vertical_field")
            .unit("rad")
            .range(0.0, PI)
            .default(0.0)
            .text("Angle between the lowest and the highest layer; half of it is below the horizontal."),
        Param::floats("elevations", 0).unit("rad").range(-FRAC_PI_2, FRAC_PI_2).default(Vec::<f64>::new()).text(
            "Elevation of each layer, upwards positive, in the order in which they are reported; takes the place of \
             `layers` and `vertical_field`.",
        ),
        Param::float("range")
            .unit("m")
            .range(0.0, f64::INFINITY)
            .default(10.0)
            .text("Maximum distance that is measured."),
        Param::float("min_range").unit("m").range(0.0, f64::INFINITY).default(0.0).text(
            "Minimum distance that is measured; a closer surface is not detected, but occludes surfaces behind it.",
        ),
        Param::float("near")
            .unit("m")
            .range(0.0, f64::INFINITY)
            .default(0.0)
            .text("Start of the beams: closer surfaces are ignored."),
        Param::bool("none_as_max")
            .default(false)
            .text("Whether a beam without a hit reports `range`, as some devices do, instead of infinity."),
        Param::float("full_intensity").unit("m").range(0.0, f64::INFINITY).default(1.0).text(
            "Distance up to which a white surface hit perpendicularly yields the full intensity of 1; beyond it, the \
             intensity decreases with the square of the distance.",
        ),
        Param::float("scan_time").unit("s").range(0.0, 10.0).default(0.0).text(
            "Time from the first to the last beam of a layer: on a moving mount, each beam starts where the mount was \
             when the beam was sent; 0: all beams at once.",
        ),
        Param::bool("skip_own_model").default(false).text("Whether objects of the sensor's own model are ignored."),
    ]
    .map(Param::rebuilds)
    .into()
}

impl LaserSettings {
    pub fn read(p: &Params<'_>) -> Result<Self> {
        let refuse = |text: String| Err(Fail::argument(text));
        let listed = p.get("elevations")?.numbers().unwrap_or_default();
        let (layers, field) = (p.i64("layers")?, p.f64("vertical_field")?);
        let elevations = match (listed.is_empty(), layers) {
            (false, _) => listed,
            (true, ..=0) => return refuse(format!("`layers` is {layers}; expected at least 1")),
            (true, 1) => vec![0.0],
            (true, n) => (0..n).map(|i| field * (i as f64 / (n - 1) as f64 - 0.5)).collect(),
        };
        let beams = p.i64("rays")?;
        if beams < 1 || beams.saturating_mul(elevations.len() as i64) > MAX_BEAMS {
            return refuse(format!(
                "`rays` is {beams}, in each of {} layers; expected 1 to {MAX_BEAMS} rays in total",
                elevations.len()
            ));
        }
        let s = LaserSettings {
            start_angle: p.f64("start_angle")?,
            end_angle: p.f64("end_angle")?,
            beams: beams as usize,
            elevations,
            near: p.f64("near")?,
            min_range: p.f64("min_range")?,
            range: p.f64("range")?,
            none_as_max: p.bool("none_as_max")?,
            full_intensity: p.f64("full_intensity")?,
            scan_time: p.f64("scan_time")?,
            skip_own_model: p.bool("skip_own_model")?,
        };
        let numbers = [s.start_angle, s.end_angle, s.near, s.min_range, s.range, s.full_intensity, s.scan_time];
        if numbers.iter().chain(&s.elevations).any(|x| !x.is_finite()) {
            return refuse("a laser scanner's parameters must be finite numbers".into());
        }
        if s.beams > 1 && s.end_angle <= s.start_angle {
            return refuse(format!(
                "`end_angle` ({} rad) must be greater than `start_angle` ({} rad): beams run from right to left",
                s.end_angle, s.start_angle
            ));
        }
        if let Some(e) = s.elevations.iter().find(|e| e.abs() > FRAC_PI_2) {
            return refuse(format!("the elevation of a layer is {e} rad; expected -pi/2 to pi/2"));
        }
        if s.near < 0.0 || s.min_range < 0.0 || s.range <= s.near || s.range <= s.min_range {
            return refuse(format!(
                "`range` ({} m) must be greater than `near` ({} m) and `min_range` ({} m), which must be at least 0",
                s.range, s.near, s.min_range
            ));
        }
        if s.full_intensity <= 0.0 {
            return refuse(format!("`full_intensity` is {} m; expected more than 0", s.full_intensity));
        }
        if s.scan_time < 0.0 {
            return refuse(format!("`scan_time` is {} s; expected 0 or more", s.scan_time));
        }
        Ok(s)
    }

    /// Returns the age of each beam when the last beam of its layer is sent, s.
    pub fn ages(&self) -> impl Iterator<Item = f64> + '_ {
        let last = self.beams.saturating_sub(1);
        let step = self.scan_time / last.max(1) as f64;
        self.elevations.iter().flat_map(move |_| (0..self.beams).map(move |i| step * (last - i) as f64))
    }

    /// Returns the azimuth of each beam of a layer.
    pub fn azimuths(&self) -> impl Iterator<Item = f64> + '_ {
        let step = (self.end_angle - self.start_angle) / self.beams.saturating_sub(1).max(1) as f64;
        (0..self.beams).map(move |i| self.start_angle + step * i as f64)
    }

    /// Returns azimuth and elevation of every beam, layer by layer, each from right to left.
    pub fn angles(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.elevations.iter().flat_map(|e| self.azimuths().map(move |a| (a, *e)))
    }
}

/// Returns the direction of a beam in the sensor's frame: +z ahead, +x to the left, +y up.
pub(crate) fn direction((azimuth, elevation): (f64, f64)) -> [f64; 3] {
    let ((sa, ca), (se, ce)) = (libm::sincos(azimuth), libm::sincos(elevation));
    [sa * ce, se, ca * ce]
}
