//! The sensor kind "laser".

use tatu_plugin_api::{
    abi::{TATU_IN_COLOR, TATU_IN_DISTANCE, TATU_IN_NORMAL, TATU_IN_POSE, TATU_IN_TWIST, TATU_WAVES_LASER},
    fields,
    safe::{Beams, Fail, Field, Form, Instance, Param, Params, Preset, Readout, Result, Sample, Sensor, SharedWorld},
};

use crate::{
    motion, presets,
    settings::{LaserSettings, direction, params},
};

/// The plugin, which has no state.
pub struct LaserPlugin;

/// A laser scanner: its settings, and the directions of its beams.
#[derive(Debug, Clone, PartialEq)]
pub struct LaserScanner {
    settings: LaserSettings,
    /// Azimuth and elevation of each beam, rad.
    angles: Vec<(f64, f64)>,
    directions: Vec<[f64; 3]>,
}

/// The measurement of one beam.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Echo {
    distance: f64,
    /// Angle between the beam and the surface's normal, rad.
    incidence: f64,
    intensity: f64,
}

impl Echo {
    /// The measurement of a beam that does not hit a surface.
    const NONE: Echo = Echo { distance: f64::INFINITY, incidence: 0.0, intensity: 0.0 };
}

impl LaserScanner {
    fn new(settings: LaserSettings) -> Self {
        let angles: Vec<_> = settings.angles().collect();
        LaserScanner { directions: angles.iter().copied().map(direction).collect(), angles, settings }
    }

    /// Returns the measurement of a surface at `distance` with the given unit normal and colour, or [`Echo::NONE`] if
    /// the distance is infinite or less than `min_range`.
    ///
    /// The intensity follows the lidar equation for a matt (Lambertian) surface that is larger than the spot: it is
    /// proportional to reflectivity, the cosine of the incidence and 1/r². Reflectivity is the mean of red, green and
    /// blue, since scenes have no infrared properties.
    fn echo(&self, direction: [f64; 3], distance: f64, normal: [f64; 3], color: [u8; 3]) -> Echo {
        if !self.is_reported(distance) {
            return Echo::NONE;
        }
        let cosine = -(0..3).map(|i| direction[i] * normal[i]).sum::<f64>();
        let cosine = cosine.clamp(0.0, 1.0);
        let reflectivity = color.iter().map(|c| f64::from(*c)).sum::<f64>() / (3.0 * 255.0);
        let spread = (self.settings.full_intensity / distance).powi(2).min(1.0);
        Echo { distance, incidence: libm::acos(cosine), intensity: reflectivity * cosine * spread }
    }

    fn is_reported(&self, distance: f64) -> bool {
        distance.is_finite() && distance >= self.settings.min_range
    }

    /// Replaces infinite distances with the maximum range if `none_as_max` is set.
    fn fill_missing_hits(&self, out: &mut Readout<'_>) {
        if self.settings.none_as_max {
            let range = self.settings.range;
            out.slice(Self::DISTANCE).iter_mut().filter(|d| d.is_infinite()).for_each(|d| *d = range);
        }
    }
}

fields! {
    LaserScanner {
        DISTANCE: f64 = Field::new("range_scan.distance")
            .per_beam()
            .unit("m")
            .text("Distance along each beam, layer after layer, each from right to left; infinity: no hit.");
        ANGLE: f64 = Field::new("range_scan.angle")
            .per_beam()
            .unit("rad")
            .text("Azimuth of each beam; to the left is positive.");
        LIMITS: f64 = Field::new("range_scan.limits").elements(2).unit("m").text("`min_range` and `range`.");
        ELEVATION: f64 = Field::new("range_scan.elevation")
            .per_beam()
            .unit("rad")
            .text("Elevation of each beam; upwards is positive.");
        INTENSITY: f64 = Field::new("range_scan.intensity").per_beam().unit("1").text(
            "Strength of each echo, 0 to 1: reflectivity x cosine of the incidence x 1/r², 1 for a white surface hit \
             perpendicularly within `full_intensity`; 0: no hit.",
        );
        INCIDENCE: f64 = Field::new("range_scan.incidence")
            .per_beam()
            .unit("rad")
            .text("Angle between each beam and the normal of the surface that it hits; 0: no hit.");
    }
}

impl Sensor for LaserScanner {
    type Plugin = LaserPlugin;
    const ID: &'static str = "laser";
    const TEXT: &'static str = "Measures distances along a fan of beams in one or more layers, like a laser scanner.";
    const SCHEMAS: &'static [&'static str] = &["range_scan/1"];
    const INPUTS: u32 = TATU_IN_DISTANCE | TATU_IN_NORMAL | TATU_IN_COLOR | TATU_IN_POSE | TATU_IN_TWIST;
    const PRESETS: &'static [Preset] = presets::ALL;

    fn params() -> Vec<Param> {
        params()
    }

    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }

    fn create(_: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        Ok(LaserScanner::new(LaserSettings::read(params)?))
    }

    fn beams(&self) -> Result<Beams> {
        Ok(Beams {
            form: Form::Rays(self.directions.clone()),
            near: self.settings.near,
            far: self.settings.range,
            skip_own_model: self.settings.skip_own_model,
            waves: TATU_WAVES_LASER,
            aimed: self.settings.scan_time > 0.0,
            ..Beams::default()
        })
    }

    /// Moves and rotates each beam to the pose that the mount had when the beam was sent.
    fn aim(&self, sample: &Sample<'_>, rays: &mut [[f64; 6]]) -> Result {
        let (Some(pose), Some(twist)) = (sample.pose(), sample.twist()) else {
            return Err(Fail::unsupported("this host does not provide the pose and velocity of sensors"));
        };
        let motion = motion::MountMotion::of(pose, twist);
        for (ray, age) in rays.iter_mut().zip(self.settings.ages()) {
            *ray = motion.earlier_ray(*ray, age);
        }
        Ok(())
    }

    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let seen = sample.distances().iter().zip(sample.normals()).zip(sample.colors());
        // With a scan time, `aim` has changed the directions of beams.
        let turned: Vec<[f64; 3]> = sample.rays().iter().map(|r| [r[3], r[4], r[5]]).collect();
        let directions = if turned.is_empty() { &self.directions } else { &turned };
        let echoes: Vec<Echo> = (seen.zip(directions))
            .map(|(((distance, normal), color), direction)| self.echo(*direction, *distance, *normal, *color))
            .collect();
        fill(out.slice(Self::DISTANCE), echoes.iter().map(|e| e.distance));
        fill(out.slice(Self::ANGLE), self.angles.iter().map(|a| a.0));
        fill(out.slice(Self::LIMITS), [self.settings.min_range, self.settings.range]);
        fill(out.slice(Self::ELEVATION), self.angles.iter().map(|a| a.1));
        fill(out.slice(Self::INTENSITY), echoes.iter().map(|e| e.intensity));
        fill(out.slice(Self::INCIDENCE), echoes.iter().map(|e| e.incidence));
        self.fill_missing_hits(out);
        Ok(())
    }

    /// Resets beams without a hit, and beams whose hit was removed by noise, to infinite distance, zero intensity and
    /// zero incidence.
    fn finish(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        for (i, met) in sample.distances().iter().enumerate() {
            if self.is_reported(*met) && out.slice(Self::DISTANCE)[i] < f64::INFINITY {
                continue;
            }
            out.slice(Self::DISTANCE)[i] = f64::INFINITY;
            out.slice(Self::INTENSITY)[i] = 0.0;
            out.slice(Self::INCIDENCE)[i] = 0.0;
        }
        self.fill_missing_hits(out);
        Ok(())
    }
}

fn fill(field: &mut [f64], values: impl IntoIterator<Item = f64>) {
    field.iter_mut().zip(values).for_each(|(place, x)| *place = x);
}

#[cfg(test)]
mod tests;
