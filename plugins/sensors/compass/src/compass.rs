//! The sensor kind "compass".

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use tatu_plugin_api::{
    abi::TATU_IN_POSE,
    fields,
    safe::{Beams, Change, Fail, Field, Instance, Param, Params, Preset, Readout, Result, Sample, Sensor, SharedWorld},
};

use crate::presets;

/// The plugin, which has no state.
pub struct CompassPlugin;

/// The configuration of a magnetometer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compass {
    /// The Earth's field in the world frame, T.
    field: [f64; 3],
    /// Scale factors along the sensor's axes, which model scale errors of the device and soft iron near it.
    scale: [f64; 3],
}

fields! {
    Compass {
        FIELD: f64 = Field::new("magnetic_field.field")
            .elements(3)
            .unit("T")
            .text("Magnetic flux density in the sensor's frame.");
        HEADING: f64 = Field::new("magnetic_field.heading")
            .unit("rad")
            .text("Angle from magnetic north to the sensor's +x, clockwise seen from its +z, 0 to 2 pi.");
    }
}

/// Dip, rad, of the field of a dipole along the Earth's axis at 48 degrees of latitude: tan dip = 2 tan latitude
/// (Wikipedia, "Dipole model of Earth's magnetic field").
const DEFAULT_DIP: f64 = 1.147_774;
/// Strength of the dipole's field at the same latitude, T: 31.2 uT sqrt(1 + 3 sin^2 latitude).
const DEFAULT_STRENGTH: f64 = 5.085e-5;

impl Compass {
    fn new(declination: f64, inclination: f64, strength: f64, scale: [f64; 3]) -> Result<Self> {
        if !scale.iter().all(|x| x.is_finite()) {
            return Err(Fail::argument(format!("`scale`: expected three finite numbers, found {scale:?}")));
        }
        let ((sd, cd), (si, ci)) = (libm::sincos(declination), libm::sincos(inclination));
        Ok(Compass { field: [ci * sd, ci * cd, -si].map(|x| strength * x), scale })
    }

    fn of(params: &Params<'_>) -> Result<Self> {
        let [declination, inclination, strength] = ["declination", "inclination", "strength"].map(|k| params.f64(k));
        Compass::new(declination?, inclination?, strength?, params.array("scale")?)
    }
}

/// Returns the heading of a level sensor that measures this field, rad, at least 0 and less than 2 pi.
fn heading([x, y, _]: [f64; 3]) -> f64 {
    let angle = libm::atan2(y, x);
    if angle < 0.0 { (angle + TAU).min(TAU.next_down()) } else { angle }
}

impl Sensor for Compass {
    type Plugin = CompassPlugin;
    const ID: &'static str = "compass";
    const TEXT: &'static str = "Measures the Earth's magnetic field, and the heading derived from it.";
    const SCHEMAS: &'static [&'static str] = &["magnetic_field/1"];
    const INPUTS: u32 = TATU_IN_POSE;
    const EVERY_PHYSICS_STEP: bool = true;
    const PRESETS: &'static [Preset] = presets::ALL;

    fn params() -> Vec<Param> {
        vec![
            Param::float("declination")
                .unit("rad")
                .range(-PI, PI)
                .default(0.0)
                .text("Angle from north (the world's +y) to magnetic north; positive to the east (+x)."),
            Param::float("inclination")
                .unit("rad")
                .range(-FRAC_PI_2, FRAC_PI_2)
                .default(DEFAULT_DIP)
                .text("Angle by which the field points below the horizon."),
            Param::float("strength")
                .unit("T")
                .range(0.0, 1.0)
                .default(DEFAULT_STRENGTH)
                .text("Magnitude of the field."),
            Param::floats("scale", 3)
                .default([1.0; 3])
                .text("Factors of the field along the sensor's axes, for scale errors and soft iron."),
        ]
    }

    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }

    fn create(_: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        Compass::of(params)
    }

    fn configure(&mut self, params: &Params<'_>, _: u64) -> Result<Change> {
        *self = Compass::of(params)?;
        Ok(Change::Taken)
    }

    fn beams(&self) -> Result<Beams> {
        Ok(Beams::default())
    }

    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        if sample.pose().is_none() {
            return Err(Fail::unsupported("this host does not provide the pose of sensors"));
        }
        let field = sample.to_sensor(self.field);
        let field = std::array::from_fn(|i| self.scale[i] * field[i]);
        out.slice(Self::FIELD).copy_from_slice(&field);
        out.set(Self::HEADING, heading(field));
        Ok(())
    }

    /// Computes the heading from the noisy field.
    fn finish(&self, _: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let field = out.slice(Self::FIELD);
        let field = [field[0], field[1], field[2]];
        out.set(Self::HEADING, heading(field));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_field_is_that_of_a_dipole_at_48_degrees() {
        let latitude = 48.0_f64.to_radians();
        assert!((DEFAULT_DIP - (2.0 * latitude.tan()).atan()).abs() < 1e-6);
        assert!((DEFAULT_STRENGTH - 3.12e-5 * (1.0 + 3.0 * latitude.sin().powi(2)).sqrt()).abs() < 1e-8);
    }

    #[test]
    fn the_field_points_north_by_the_declination_and_down_by_the_dip() {
        let [x, y, z] = Compass::new(0.1, 1.0, 5e-5, [1.0; 3]).unwrap().field;
        assert!((x.atan2(y) - 0.1).abs() < 1e-12);
        assert!((x.hypot(y) - 5e-5 * 1.0_f64.cos()).abs() < 1e-18 && (z + 5e-5 * 1.0_f64.sin()).abs() < 1e-18);
    }

    #[test]
    fn headings_are_clockwise_and_within_a_turn() {
        // North is to the left of a sensor that faces east.
        assert!((heading([0.0, 1.0, -2.0]) - FRAC_PI_2).abs() < 1e-15);
        assert_eq!(heading([1.0, 0.0, 0.0]), 0.0);
        assert!((heading([0.0, -1.0, 0.0]) - 3.0 * FRAC_PI_2).abs() < 1e-15);
        let nearly = heading([1.0, -1e-300, 0.0]);
        assert!((0.0..TAU).contains(&nearly), "{nearly}");
    }

    #[test]
    fn readme_names_every_parameter_field_and_preset() {
        let readme = include_str!("../README.md");
        let all = (Compass::params().iter().map(|p| p.key().to_owned()).collect::<Vec<_>>().into_iter())
            .chain(Compass::fields().into_iter().map(|f| f.name().to_owned()))
            .chain(Compass::PRESETS.iter().map(|p| p.id.to_owned()));
        for name in all {
            assert!(readme.contains(&format!("| `{name}`")), "{name}");
        }
    }
}
