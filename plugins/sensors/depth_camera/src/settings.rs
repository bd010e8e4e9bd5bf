//! The parameters of a camera, and quantities derived from them.

use std::f64::consts::{FRAC_PI_2, PI};

use tatu_plugin_api::{
    abi::{TATU_IN_COLOR, TATU_IN_COSINE},
    safe::{Beams, Fail, Form, Param, Params, Result},
};

use crate::optics::{EdgeMode, Optics};

/// Maximum number of pixels along one side, which is also the host's limit.
const MAX_SIDE_PIXELS: f64 = 8192.0;

/// The checked parameters of a camera.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthCameraSettings {
    /// Number of columns.
    pub columns: u32,
    /// Number of rows.
    pub rows: u32,
    /// Angle between the edges of the image along its longer side, rad.
    pub perspective_angle: f64,
    /// Length of the image's longer side in orthographic projection, m; 0: perspective projection.
    pub ortho_size: f64,
    /// Distance of the near plane, m.
    pub near: f64,
    /// Distance of the far plane, m.
    pub far: f64,
    /// Colour of pixels without a surface: red, green and blue.
    pub background: [u8; 3],
    /// Whether beams ignore objects of the sensor's own model.
    pub skip_own_model: bool,
    /// Whether colours are measured.
    pub color: bool,
    /// Whether the point of each pixel is reported.
    pub points: bool,
    /// Whether the angle of incidence of each pixel is reported.
    pub incidence: bool,
    /// Depth of a pixel without a surface: infinity or 0.
    pub empty: f32,
    /// Limitations of the optics.
    pub optics: Optics,
}

/// Declares the parameters of the sensor kind.
pub fn params() -> Vec<Param> {
    let pixels = |key, n: i64| Param::int(key).range(1.0, MAX_SIDE_PIXELS).default(n);
    let metres = |key, x: f64| Param::float(key).unit("m").range(0.0, f64::INFINITY).default(x);
    [
        pixels("columns", 640).text("Pixels per row."),
        pixels("rows", 480).text("Number of rows."),
        Param::float("perspective_angle")
            .unit("rad")
            .range(0.0, PI)
            .default(57_f64.to_radians())
            .text("Angle between the edges of the image, along its longer side."),
        metres("ortho_size", 0.0)
            .text("Length of the image's longer side in orthographic projection; 0: perspective projection."),
        metres("near", 0.01).text("Near plane: surfaces closer than this, along the optical axis, are ignored."),
        metres("far", 3.5).text("Far plane: surfaces farther than this are ignored."),
        Param::floats("background", 3)
            .range(0.0, 1.0)
            .default([0.0; 3])
            .text("Red, green and blue of empty pixels, each 0 to 1."),
        Param::bool("color").default(true).text("Whether colours are rendered; if not, the colour image is empty."),
        Param::bool("points").default(false).text("Whether the point of each pixel in the sensor's frame is reported."),
        Param::bool("incidence")
            .default(false)
            .text("Whether the angle between line of sight and normal, on which noise can depend, is reported."),
        Param::bool("skip_own_model").default(false).text("Whether objects of the sensor's own model are ignored."),
        Param::string("empty")
            .choices(&["infinity", "zero"])
            .default("infinity")
            .text("Depth of empty pixels. The depth of pixels whose measurement fails is always 0."),
        Param::float("max_incidence")
            .unit("rad")
            .range(0.0, FRAC_PI_2)
            .default(FRAC_PI_2)
            .text("Maximum angle between line of sight and normal of a surface whose depth can be measured."),
        Param::float("projector").unit("m").default(0.0).text(
            "Position of the pattern projector on the x axis (+ to the left): surfaces that it does not light \
             have no depth. 0: no projector.",
        ),
        Param::string("edges").choices(&["exact", "lost", "mixed"]).default("exact").text(
            "Depth of pixels at depth discontinuities: exact, none, or a random value between the two \
             surfaces.",
        ),
        Param::float("lateral_sigma")
            .range(0.0, 16.0)
            .default(0.0)
            .text("Standard deviation of the position of edges, in pixels."),
    ]
    .map(Param::rebuilds)
    .into()
}

fn refuse<T>(text: String) -> Result<T> {
    Err(Fail::argument(text))
}

impl DepthCameraSettings {
    /// Reads and checks the parameters.
    pub fn read(p: &Params<'_>) -> Result<Self> {
        let count = |key: &str| -> Result<u32> {
            let n = p.i64(key)?;
            u32::try_from(n)
                .ok()
                .filter(|n| *n > 0 && f64::from(*n) <= MAX_SIDE_PIXELS)
                .ok_or_else(|| Fail::argument(format!("`{key}` is {n}; expected 1 to {MAX_SIDE_PIXELS} pixels")))
        };
        let optics = Optics {
            least_cosine: match p.f64("max_incidence")? {
                x if x >= FRAC_PI_2 => 0.0,
                x => libm::cos(x) as f32,
            },
            projector: p.f64("projector")?,
            edges: match p.string("edges")?.as_str() {
                "exact" => EdgeMode::Exact,
                "lost" => EdgeMode::Lost,
                "mixed" => EdgeMode::Mixed,
                other => return refuse(format!("`edges` is `{other}`; expected `exact`, `lost` or `mixed`")),
            },
            lateral_sigma: p.f64("lateral_sigma")?,
        };
        DepthCameraSettings {
            columns: count("columns")?,
            rows: count("rows")?,
            perspective_angle: p.f64("perspective_angle")?,
            ortho_size: p.f64("ortho_size")?,
            near: p.f64("near")?,
            far: p.f64("far")?,
            background: p.array::<3>("background")?.map(|x| (x.clamp(0.0, 1.0) * 255.0).round() as u8),
            color: p.bool("color")?,
            points: p.bool("points")?,
            incidence: p.bool("incidence")?,
            skip_own_model: p.bool("skip_own_model")?,
            empty: match p.string("empty")?.as_str() {
                "infinity" => f32::INFINITY,
                "zero" => 0.0,
                other => return refuse(format!("`empty` is `{other}`; expected `infinity` or `zero`")),
            },
            optics,
        }
        .check()
    }

    fn check(self) -> Result<Self> {
        let o = &self.optics;
        let numbers = [self.perspective_angle, self.ortho_size, self.near, self.far, o.projector, o.lateral_sigma];
        if numbers.iter().any(|x| !x.is_finite()) {
            return refuse("a camera's parameters must be finite numbers".into());
        }
        if self.near < 0.0 || self.far <= self.near {
            return refuse(format!(
                "`far` ({} m) must be greater than `near` ({} m), which must not be negative",
                self.far, self.near
            ));
        }
        if self.ortho_size < 0.0 {
            return refuse(format!("`ortho_size` is {} m; it must not be negative", self.ortho_size));
        }
        if self.ortho_size == 0.0 && !(self.perspective_angle > 0.0 && self.perspective_angle < PI) {
            return refuse(format!(
                "`perspective_angle` is {} rad; expected more than 0 and less than pi",
                self.perspective_angle
            ));
        }
        if o.projector != 0.0 && self.ortho_size > 0.0 {
            return refuse("a camera with a projector must use perspective projection: omit `ortho_size`".into());
        }
        Ok(self)
    }

    /// Returns the number of pixels of the longer side.
    fn longer_side(&self) -> f64 {
        f64::from(self.columns.max(self.rows))
    }

    /// Returns the focal length in pixels, or the number of pixels per metre for orthographic projection.
    pub fn focal(&self) -> f64 {
        if self.ortho_size > 0.0 {
            self.longer_side() / self.ortho_size
        } else {
            self.longer_side() / 2.0 / libm::tan(self.perspective_angle / 2.0)
        }
    }

    /// Returns the beams that the core casts.
    pub fn beams(&self) -> Beams {
        let (columns, rows) = (self.columns, self.rows);
        let form = if self.ortho_size > 0.0 {
            Form::Parallel { columns, rows, width: f64::from(columns) / self.focal() }
        } else {
            let horizontal_angle = 2.0 * libm::atan(f64::from(columns) / 2.0 / self.focal());
            Form::Image { columns, rows, horizontal_angle }
        };
        Beams {
            form,
            near: self.near,
            far: self.far,
            skip_own_model: self.skip_own_model,
            visible: true,
            own: [if self.color { 3 } else { 0 }, if self.points { 3 } else { 0 }, u32::from(self.incidence), 0],
            without: if self.color { 0 } else { TATU_IN_COLOR }
                | if self.needs_incidence() { 0 } else { TATU_IN_COSINE },
            ..Beams::default()
        }
    }

    /// Returns whether the host must compute angles of incidence.
    pub fn needs_incidence(&self) -> bool {
        self.incidence || self.optics.least_cosine > 0.0
    }

    /// Returns the point of a pixel in the sensor's frame, m, given its [`intrinsics`](Self::intrinsics).
    pub fn point(&self, [fx, fy, cx, cy]: [f64; 4], column: usize, row: usize, z: f32) -> [f32; 3] {
        let along = if self.ortho_size > 0.0 { 1.0 } else { f64::from(z) };
        [(-(column as f64 - cx) / fx * along) as f32, ((row as f64 - cy) / fy * along) as f32, z]
    }

    /// Returns the intrinsics fx, fy, cx and cy: in pixels, except that fx and fy are in pixels per metre for
    /// orthographic projection.
    pub fn intrinsics(&self) -> [f64; 4] {
        let f = self.focal();
        [f, f, (f64::from(self.columns) - 1.0) / 2.0, (f64::from(self.rows) - 1.0) / 2.0]
    }
}

#[cfg(test)]
impl Default for DepthCameraSettings {
    fn default() -> Self {
        DepthCameraSettings {
            columns: 640,
            rows: 480,
            perspective_angle: 57_f64.to_radians(),
            ortho_size: 0.0,
            near: 0.01,
            far: 3.5,
            background: [0; 3],
            color: true,
            points: false,
            incidence: false,
            skip_own_model: false,
            empty: f32::INFINITY,
            optics: Optics::NONE,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 57 degrees over 640 pixels: f = 320 / tan 28.5 = 589.37, and 44.32 degrees over 480.
    #[test]
    fn default_field_of_view_matches_the_original_sensor() {
        let s = DepthCameraSettings::default();
        assert!((s.focal() - 589.366).abs() < 1e-3, "{}", s.focal());
        let vertical = 2.0 * libm::atan(240.0 / s.focal());
        assert!((vertical.to_degrees() - 44.315).abs() < 1e-2, "{}", vertical.to_degrees());
        assert_eq!(s.intrinsics()[2..], [319.5, 239.5]);
    }

    #[test]
    fn the_angle_belongs_to_the_longer_side() {
        let s = DepthCameraSettings {
            columns: 10,
            rows: 40,
            perspective_angle: FRAC_PI_2,
            ..DepthCameraSettings::default()
        };
        assert!((s.focal() - 20.0).abs() < 1e-12);
        let Form::Image { horizontal_angle, .. } = s.beams().form else { panic!() };
        assert!(((horizontal_angle / 2.0).tan() - 0.25).abs() < 1e-12);
    }

    /// With f = 320.5 / tan 28.5 = 590.29, a pixel 100 columns to the left of the centre and 50 rows above it is at
    /// 0.1694 and 0.0847 m per metre of depth.
    #[test]
    fn points_follow_from_pixels() {
        let s = DepthCameraSettings { columns: 641, rows: 481, ..DepthCameraSettings::default() };
        let [x, y, z] = s.point(s.intrinsics(), 220, 290, 2.0);
        let f = 320.5 / libm::tan(28.5_f64.to_radians());
        assert!(
            (f64::from(x) - 200.0 / f).abs() < 1e-6 && (f64::from(y) - 100.0 / f).abs() < 1e-6 && z == 2.0,
            "{x} {y}"
        );
        let s = DepthCameraSettings { columns: 3, rows: 3, ortho_size: 0.3, ..DepthCameraSettings::default() };
        let [x, y, _] = s.point(s.intrinsics(), 0, 2, 2.0);
        assert!((x - 0.1).abs() < 1e-6 && (y - 0.1).abs() < 1e-6, "{x} {y}");
    }

    #[test]
    fn unneeded_inputs_are_not_requested() {
        let plain = DepthCameraSettings::default().beams();
        assert_eq!((plain.own, plain.without), ([3, 0, 0, 0], TATU_IN_COSINE));
        let other =
            DepthCameraSettings { color: false, points: true, incidence: true, ..DepthCameraSettings::default() }
                .beams();
        assert_eq!((other.own, other.without), ([0, 3, 1, 0], TATU_IN_COLOR));
    }

    #[test]
    fn parallel_images_have_square_pixels() {
        let s = DepthCameraSettings { columns: 8, rows: 16, ortho_size: 0.4, ..DepthCameraSettings::default() };
        let Form::Parallel { width, .. } = s.beams().form else { panic!() };
        assert!((width - 0.2).abs() < 1e-12);
    }

    #[test]
    fn invalid_settings_are_refused() {
        for (wrong, word) in [
            (DepthCameraSettings { far: 0.01, ..DepthCameraSettings::default() }, "far"),
            (DepthCameraSettings { near: -1.0, ..DepthCameraSettings::default() }, "near"),
            (DepthCameraSettings { perspective_angle: 0.0, ..DepthCameraSettings::default() }, "perspective_angle"),
            (DepthCameraSettings { perspective_angle: f64::NAN, ..DepthCameraSettings::default() }, "finite"),
            (DepthCameraSettings { ortho_size: -0.1, ..DepthCameraSettings::default() }, "ortho_size"),
            (
                DepthCameraSettings {
                    ortho_size: 1.0,
                    optics: Optics { projector: 0.075, ..Optics::NONE },
                    ..DepthCameraSettings::default()
                },
                "projector",
            ),
        ] {
            let text = wrong.check().unwrap_err().to_string();
            assert!(text.contains(word), "{text}");
        }
    }
}
