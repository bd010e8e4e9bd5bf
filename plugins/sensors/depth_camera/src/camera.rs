//! The sensor kind "depth_camera".

use tatu_plugin_api::{
    abi::{TATU_DIM_COLUMNS, TATU_DIM_OWN, TATU_DIM_ROWS, TATU_IN_COLOR, TATU_IN_COSINE, TATU_IN_DISTANCE},
    fields,
    safe::{Beams, Field, Instance, Param, Params, Preset, Readout, Result, Sample, Sensor, SharedWorld},
};

use crate::{
    optics::{IdealImage, RandomSource},
    presets,
    settings::{self, DepthCameraSettings},
};

/// The plugin, which has no state.
pub struct DepthCameraPlugin;

/// A depth camera with its checked parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthCamera(DepthCameraSettings);

/// Draws the random numbers of a measurement from its sample.
impl RandomSource for Sample<'_> {
    fn uniform(&self, first: u64, out: &mut [f64]) {
        Sample::uniform(self, first, out);
    }
    fn normal(&self, first: u64, out: &mut [f64]) {
        Sample::normal(self, first, out);
    }
}

const IMAGE_DIMS: [u32; 3] = [TATU_DIM_ROWS, TATU_DIM_COLUMNS, 1];

/// Returns the shape of an image whose number of channels is the instance's own dimension `own` (`tatu_beams.own`).
const fn channel_dims(own: u32) -> [u32; 3] {
    [TATU_DIM_ROWS, TATU_DIM_COLUMNS, TATU_DIM_OWN + own]
}

fields! {
    DepthCamera {
        DEPTH: f32 = Field::new("depth_image.depth")
            .dims(IMAGE_DIMS)
            .unit("m")
            .text("Distance along +z, the lowest row first; infinity: no surface; 0: the measurement failed.");
        LIMITS: f64 = Field::new("depth_image.limits").elements(2).unit("m").text("Depths of the near and far planes.");
        INTRINSICS: f64 = Field::new("depth_image.intrinsics")
            .elements(4)
            .unit("1")
            .text("fx fy cx cy, in pixels; if the lines of sight are parallel, fx and fy in pixels per metre.");
        PARALLEL: i32 = Field::new("depth_image.parallel")
            .text("1: the lines of sight are parallel; 0: they start at one point.");
        RGB: u8 = Field::new("color_image.rgb")
            .dims(channel_dims(0))
            .unit("1")
            .text("Red, green and blue, 0 to 255, the lowest row first.");
        POINTS: f32 = Field::new("depth_image.points")
            .dims(channel_dims(1))
            .unit("m")
            .text("x y z of each pixel in the sensor's frame; 0 0 0 without a depth. Only with `points`.");
        INCIDENCE: f32 = Field::new("depth_image.incidence")
            .dims(channel_dims(2))
            .unit("rad")
            .text("Angle between line of sight and normal; pi/2 without a surface. Only with `incidence`.");
    }
}

impl Sensor for DepthCamera {
    type Plugin = DepthCameraPlugin;
    const ID: &'static str = "depth_camera";
    const TEXT: &'static str =
        "Measures images of depth along the optical axis and of colour, like V-REP's vision sensors and the Kinect.";
    const SCHEMAS: &'static [&'static str] = &["depth_image/1", "color_image/1"];
    const INPUTS: u32 = TATU_IN_DISTANCE | TATU_IN_COLOR | TATU_IN_COSINE;
    const PRESETS: &'static [Preset] = presets::ALL;

    fn params() -> Vec<Param> {
        settings::params()
    }

    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }

    fn create(_: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        Ok(DepthCamera(DepthCameraSettings::read(params)?))
    }

    fn beams(&self) -> Result<Beams> {
        Ok(self.0.beams())
    }

    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let DepthCamera(s) = self;
        let seen = sample.depths();
        let depth = out.slice(Self::DEPTH);
        if s.optics.is_ideal() {
            depth.copy_from_slice(seen);
        } else {
            let frame = IdealImage {
                columns: s.columns as usize,
                focal: s.focal(),
                depth: seen,
                cosine: sample.pixel_cosines(),
            };
            s.optics.measure(&frame, sample, depth);
        }
        if s.empty.is_finite() {
            depth.iter_mut().filter(|z| z.is_infinite()).for_each(|z| *z = s.empty);
        }
        out.slice(Self::LIMITS).copy_from_slice(&[s.near, s.far]);
        out.slice(Self::INTRINSICS).copy_from_slice(&s.intrinsics());
        out.set(Self::PARALLEL, i32::from(s.ortho_size > 0.0));
        let rgb = out.slice(Self::RGB).as_chunks_mut::<3>().0;
        for ((pixel, color), z) in rgb.iter_mut().zip(sample.pixel_colors()).zip(seen) {
            *pixel = if z.is_infinite() { s.background } else { *color };
        }
        for (angle, cosine) in out.slice(Self::INCIDENCE).iter_mut().zip(sample.pixel_cosines()) {
            *angle = libm::acosf(cosine.clamp(0.0, 1.0));
        }
        self.write_points(out);
        Ok(())
    }

    /// Computes points from the noisy depths.
    fn finish(&self, _: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        self.write_points(out);
        Ok(())
    }
}

impl DepthCamera {
    fn write_points(&self, out: &mut Readout<'_>) {
        let DepthCamera(s) = self;
        if !s.points {
            return;
        }
        let (depth, intrinsics) = (out.slice(Self::DEPTH).to_vec(), s.intrinsics());
        for ((i, z), point) in depth.iter().enumerate().zip(out.slice(Self::POINTS).as_chunks_mut::<3>().0) {
            let (column, row) = (i % s.columns as usize, i / s.columns as usize);
            *point = if *z > 0.0 && z.is_finite() { s.point(intrinsics, column, row, *z) } else { [0.0; 3] };
        }
    }
}
