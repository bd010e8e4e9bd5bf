//! The parameters of a proximity sensor, and the beams derived from them.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use tatu_plugin_api::{
    abi::*,
    safe::{Beams, Fail, Form, Param, Params, Result},
};

/// The parameters as written in scenes, before they are checked; lengths in m, angles in rad.
#[derive(Debug, Clone)]
pub(crate) struct ProximitySettings {
    pub volume: String,
    pub range: f64,
    pub near: f64,
    pub min_range: f64,
    pub angle: f64,
    pub gap: f64,
    pub sizes: VolumeSizes,
    pub samples: i64,
    pub samples_needed: i64,
    pub max_incidence: f64,
    pub front_faces: bool,
    pub back_faces: bool,
    pub occlusion: bool,
    pub waves: String,
    pub skip_own_model: bool,
}

/// The sizes of a pyramid, a cylinder or a disc, m.
#[derive(Debug, Clone)]
pub(crate) struct VolumeSizes {
    pub size_near: [f64; 2],
    pub size_far: [f64; 2],
    pub radius_near: f64,
    pub radius_far: f64,
    pub height: f64,
}

/// The shapes of the detection volume that [`ProximitySettings::volume`] can name.
const VOLUMES: &[&str] = &["ray", "cone", "pyramid", "cylinder", "disc", "random_rays"];

/// Values of [`ProximitySettings::waves`], and the corresponding bits of [`Beams`].
const WAVES: &[(&str, u32)] = &[
    ("any", TATU_WAVES_ALL),
    ("ultrasonic", TATU_WAVES_ULTRASONIC),
    ("infrared", TATU_WAVES_INFRARED),
    ("laser", TATU_WAVES_LASER),
    ("inductive", TATU_WAVES_INDUCTIVE),
    ("capacitive", TATU_WAVES_CAPACITIVE),
];
const WAVE_NAMES: &[&str] = &["any", "ultrasonic", "infrared", "laser", "inductive", "capacitive"];

/// Maximum number of random rays per measurement.
const MAX_SAMPLES: i64 = 100_000;

/// Declares the parameters of the sensor kind.
pub(crate) fn params() -> Vec<Param> {
    let length = |key: &str| Param::float(key).unit("m").range(0.0, f64::INFINITY);
    [
        Param::string("volume").choices(VOLUMES).default("ray").text(
            "The volume of detection: the +z axis, or a volume around it; a cone and a disc have a round far \
                   end.",
        ),
        length("range").default(1.0).text(
            "Distance from the sensor's origin to the far end; for a pyramid or a cylinder, the height of the far end.",
        ),
        length("near").default(0.0).text(
            "Blind zone: surfaces closer to the origin are ignored; for a pyramid or a cylinder, the height of the \
             near end.",
        ),
        length("min_range").default(0.0).text(
            "Threshold: if the nearest surface is closer than this, nothing is reported; `near`, by contrast, ignores \
             only that surface.",
        ),
        Param::float("angle")
            .unit("rad")
            .range(0.0, TAU)
            .default(PI / 6.0)
            .text("Full opening angle of a cone, a disc or random rays, up to a full turn."),
        Param::float("gap")
            .unit("rad")
            .range(0.0, TAU)
            .default(0.0)
            .text("Full angle of a gap in the middle of a disc; must be less than `angle`."),
        Param::floats("size_near", 2)
            .unit("m")
            .range(0.0, f64::INFINITY)
            .default([0.1, 0.1])
            .text("Full size of a pyramid's near end, along x and y."),
        Param::floats("size_far", 2)
            .unit("m")
            .range(0.0, f64::INFINITY)
            .default([0.5, 0.5])
            .text("Full size of a pyramid's far end, along x and y."),
        length("radius_near").default(0.1).text("Radius of a cylinder's near end."),
        length("radius_far").default(0.1).text("Radius of a cylinder's far end."),
        length("height").default(0.05).text("Thickness of a disc, along y."),
        Param::int("samples")
            .range(1.0, MAX_SAMPLES as f64)
            .default(20i64)
            .text("Number of random rays in each measurement."),
        Param::int("samples_needed")
            .range(1.0, MAX_SAMPLES as f64)
            .default(1i64)
            .text("Number of random rays that must hit something before the nearest hit is reported."),
        Param::float("max_incidence").unit("rad").range(0.0, FRAC_PI_2).default(FRAC_PI_2).text(
            "Maximum angle between line of sight and surface normal; more slanted surfaces are not detected. pi/2: no \
             limit.",
        ),
        Param::bool("front_faces").default(true).text("Whether the outer sides of surfaces are detected."),
        Param::bool("back_faces").default(true).text("Whether the inner sides of surfaces are detected."),
        Param::bool("occlusion").default(false).text(
            "Whether the nearest point in a volume must have a free line of sight: surfaces that are not detected \
             themselves, because of their side or slant, then occlude surfaces behind them.",
        ),
        Param::string("waves").choices(WAVE_NAMES).default("any").text(
            "Kind of waves that the sensor emits; the `detectable_mask` of a shape selects the kinds that detect it.",
        ),
        Param::bool("skip_own_model").default(false).text("Whether objects of the sensor's own model are ignored."),
    ]
    .map(Param::rebuilds)
    .into()
}

impl ProximitySettings {
    pub fn read(p: &Params<'_>) -> Result<Self> {
        Ok(ProximitySettings {
            volume: p.string("volume")?,
            range: p.f64("range")?,
            near: p.f64("near")?,
            min_range: p.f64("min_range")?,
            angle: p.f64("angle")?,
            gap: p.f64("gap")?,
            sizes: VolumeSizes {
                size_near: p.array("size_near")?,
                size_far: p.array("size_far")?,
                radius_near: p.f64("radius_near")?,
                radius_far: p.f64("radius_far")?,
                height: p.f64("height")?,
            },
            samples: p.i64("samples")?,
            samples_needed: p.i64("samples_needed")?,
            max_incidence: p.f64("max_incidence")?,
            front_faces: p.bool("front_faces")?,
            back_faces: p.bool("back_faces")?,
            occlusion: p.bool("occlusion")?,
            waves: p.string("waves")?,
            skip_own_model: p.bool("skip_own_model")?,
        })
    }

    /// Checks the parameters, and returns the beams.
    pub fn beams(&self) -> Result<Beams> {
        let refuse = |text: String| Err(Fail::argument(text));
        let lengths =
            [self.range, self.near, self.min_range, self.sizes.radius_near, self.sizes.radius_far, self.sizes.height];
        let numbers = lengths.iter().chain([&self.angle, &self.gap, &self.max_incidence]);
        if numbers.chain(&self.sizes.size_near).chain(&self.sizes.size_far).any(|x| !x.is_finite()) {
            return refuse("a proximity sensor's parameters must be finite numbers".into());
        }
        if self.near < 0.0 || self.range <= self.near {
            return refuse(format!(
                "`range` ({} m) must be greater than `near` ({} m), which must not be negative",
                self.range, self.near
            ));
        }
        if self.min_range < 0.0 {
            return refuse(format!("`min_range` is {} m; expected at least 0", self.min_range));
        }
        if self.max_incidence <= 0.0 {
            return refuse("`max_incidence` must be greater than 0; pi/2 means no limit".into());
        }
        if !self.front_faces && !self.back_faces {
            return refuse("`front_faces` or `back_faces` must be true, otherwise the sensor detects nothing".into());
        }
        let Some((_, waves)) = WAVES.iter().find(|(name, _)| *name == self.waves) else {
            return refuse(format!("`waves` is `{}`; expected one of {}", self.waves, WAVE_NAMES.join(", ")));
        };
        Ok(Beams {
            form: self.form()?,
            near: self.near,
            far: self.range,
            max_incidence: self.max_incidence.min(FRAC_PI_2),
            skip_own_model: self.skip_own_model,
            faces: (self.front_faces, self.back_faces),
            occlude: self.occlusion,
            waves: *waves,
            aimed: self.volume == "random_rays",
            ..Beams::default()
        })
    }

    fn form(&self) -> Result<Form> {
        let refuse = |text: String| Err(Fail::argument(text));
        let ahead = [0.0, 0.0, 1.0];
        let volume = |form, dims: &[f64]| {
            let mut all = [0.0; 6];
            all[..dims.len()].copy_from_slice(dims);
            Ok(Form::Volume { form, dims: all })
        };
        if matches!(self.volume.as_str(), "cone" | "disc" | "random_rays")
            && !(self.angle > 0.0 && self.angle <= TAU + 1e-9)
        {
            return refuse(format!(
                "`angle` is {} rad; the volume `{}` requires more than 0 and at most 2 pi",
                self.angle, self.volume
            ));
        }
        let angle = self.angle.min(TAU);
        match self.volume.as_str() {
            "ray" => Ok(Form::Rays(vec![ahead])),
            "cone" => Ok(Form::Cone { half_angle: angle / 2.0 }),
            "pyramid" => {
                let ([x, y], [u, v]) = (self.sizes.size_near, self.sizes.size_far);
                if [x, y, u, v].iter().any(|s| *s < 0.0) || x.max(u) <= 0.0 || y.max(v) <= 0.0 {
                    return refuse(format!(
                        "`size_near` is {:?} m and `size_far` {:?} m; expected at least 0, and for each axis one size \
                         above 0",
                        self.sizes.size_near, self.sizes.size_far
                    ));
                }
                volume(TATU_BEAMS_PYRAMID, &[x, y, u, v])
            }
            "cylinder" => {
                let (near, far) = (self.sizes.radius_near, self.sizes.radius_far);
                if near < 0.0 || far < 0.0 || near.max(far) <= 0.0 {
                    return refuse(format!(
                        "`radius_near` is {near} m and `radius_far` {far} m; expected at least 0, and one above 0"
                    ));
                }
                volume(TATU_BEAMS_CYLINDER, &[near, far])
            }
            "disc" => {
                if self.sizes.height <= 0.0 || self.gap < 0.0 || self.gap >= angle {
                    return refuse(format!(
                        "`height` is {} m, `gap` is {} rad and `angle` is {angle} rad; a disc requires a height above \
                         0, and a gap that is at least 0 and less than `angle`",
                        self.sizes.height, self.gap
                    ));
                }
                volume(TATU_BEAMS_DISC, &[angle, self.sizes.height, self.gap])
            }
            "random_rays" => {
                if !(1..=MAX_SAMPLES).contains(&self.samples) || !(1..=self.samples).contains(&self.samples_needed) {
                    return refuse(format!(
                        "`samples_needed` is {} and `samples` is {}; expected `samples` from 1 to {MAX_SAMPLES}, and \
                         `samples_needed` from 1 to `samples`",
                        self.samples_needed, self.samples
                    ));
                }
                Ok(Form::Rays(vec![ahead; self.samples as usize]))
            }
            other => refuse(format!("`volume` is `{other}`; expected one of {}", VOLUMES.join(", "))),
        }
    }
}
