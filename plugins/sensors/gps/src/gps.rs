//! The sensor kind "gps".

use tatu_plugin_api::{
    abi::{TATU_IN_POSE, TATU_IN_TWIST},
    fields,
    safe::{Beams, Fail, Field, Form, Instance, Param, Params, Preset, Readout, Result, Sample, Sensor, SharedWorld},
};

use crate::{
    earth::{GeodeticPosition, TangentPlane},
    presets,
};

/// The plugin, which has no state.
pub struct GpsPlugin;

/// The configuration of a satellite receiver.
#[derive(Debug, Clone, PartialEq)]
pub struct Gps {
    /// Position of the antenna in the sensor's frame, m.
    antenna: [f64; 3],
    /// The plane tangent to the Earth that contains the x and y axes of the world.
    plane: TangentPlane,
}

fields! {
    Gps {
        VALID: i32 = Field::new("gps.valid").text("Whether there is a fix: 1 or 0; without a fix, all other fields are 0.");
        POSITION: f64 = Field::new("gps.position")
            .elements(3)
            .unit("m")
            .text("Position of the antenna in the world: x east, y north, z up.");
        VELOCITY: f64 = Field::new("gps.velocity").elements(3).unit("m/s").text("Velocity of the antenna in the world.");
        LATITUDE: f64 = Field::new("gps.latitude")
            .unit("rad")
            .text("Latitude (WGS 84) of the position including its noise; north positive.");
        LONGITUDE: f64 = Field::new("gps.longitude")
            .unit("rad")
            .text("Longitude of the position, -pi to pi; east positive.");
        ALTITUDE: f64 = Field::new("gps.altitude").unit("m").text("Height of the position above the ellipsoid.");
    }
}

impl Gps {
    fn new(antenna: [f64; 3], [latitude, longitude, altitude]: [f64; 3]) -> Result<Self> {
        if !antenna.iter().all(|x| x.is_finite()) {
            return Err(Fail::argument(format!("`antenna`: expected three finite numbers, found {antenna:?} m")));
        }
        if ![latitude, longitude, altitude].iter().all(|x| x.is_finite()) {
            return Err(Fail::argument(
                "latitude, longitude and altitude in `scene.origin` must be finite for a satellite receiver",
            ));
        }
        Ok(Gps { antenna, plane: TangentPlane::at(GeodeticPosition { latitude, longitude, altitude }) })
    }

    /// Returns the position and velocity of the antenna in the world frame, given the pose and twist of the mount.
    fn fix(&self, pose: [f64; 7], twist: [f64; 6]) -> ([f64; 3], [f64; 3]) {
        let arm = rotate([pose[3], pose[4], pose[5], pose[6]], self.antenna);
        let swung = cross([twist[3], twist[4], twist[5]], arm);
        ([0, 1, 2].map(|i| pose[i] + arm[i]), [0, 1, 2].map(|i| twist[i] + swung[i]))
    }

    /// Writes the latitude, longitude and altitude of a position in the world frame.
    fn write_geodetic(&self, position: [f64; 3], out: &mut Readout<'_>) {
        let place = self.plane.geodetic_position(position);
        out.set(Self::LATITUDE, place.latitude);
        out.set(Self::LONGITUDE, place.longitude);
        out.set(Self::ALTITUDE, place.altitude);
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Rotates a vector by the quaternion x y z w.
fn rotate([x, y, z, w]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let t = cross([x, y, z], v);
    let u = cross([x, y, z], t);
    [0, 1, 2].map(|i| v[i] + 2.0 * (w * t[i] + u[i]))
}

impl Sensor for Gps {
    type Plugin = GpsPlugin;
    const ID: &'static str = "gps";
    const TEXT: &'static str = "Measures the position and velocity of an antenna, in the world and on Earth.";
    const SCHEMAS: &'static [&'static str] = &["gps/1"];
    const INPUTS: u32 = TATU_IN_POSE | TATU_IN_TWIST;
    const PRESETS: &'static [Preset] = presets::ALL;

    fn params() -> Vec<Param> {
        vec![
            Param::floats("antenna", 3)
                .unit("m")
                .default([0.0; 3])
                .text("Position of the antenna in the sensor's frame.")
                .rebuilds(),
        ]
    }

    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }

    fn create(world: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        let origin = world.f64s(0, world.host().prop("scene.origin"))?;
        Gps::new(params.array("antenna")?, origin)
    }

    fn beams(&self) -> Result<Beams> {
        Ok(Beams { form: Form::None, ..Beams::default() })
    }

    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let (Some(pose), Some(twist)) = (sample.pose(), sample.twist()) else {
            return Err(Fail::unsupported("this host does not provide the pose and velocity of sensors"));
        };
        let (position, velocity) = self.fix(pose, twist);
        out.set(Self::VALID, 1);
        out.slice(Self::POSITION).copy_from_slice(&position);
        out.slice(Self::VELOCITY).copy_from_slice(&velocity);
        self.write_geodetic(position, out);
        Ok(())
    }

    /// Computes the position on Earth from the noisy position, or clears all fields if the noise model has removed the
    /// fix.
    fn finish(&self, _: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        if out.slice(Self::VALID)[0] == 0 {
            for field in [Self::POSITION, Self::VELOCITY, Self::LATITUDE, Self::LONGITUDE, Self::ALTITUDE] {
                out.slice(field).fill(0.0);
            }
            return Ok(());
        }
        let position = out.slice(Self::POSITION);
        let position = [position[0], position[1], position[2]];
        self.write_geodetic(position, out);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

    use super::*;

    #[test]
    fn antenna_without_offset_is_at_the_mount() {
        let gps = Gps::new([0.0; 3], [0.0; 3]).unwrap();
        let pose = [1.25, -2.5, 0.75, 0.1, 0.2, 0.3, (1.0 - 0.14_f64).sqrt()];
        let twist = [0.5, 0.25, -1.0, 3.0, 2.0, 1.0];
        assert_eq!(gps.fix(pose, twist), ([1.25, -2.5, 0.75], [0.5, 0.25, -1.0]));
    }

    #[test]
    fn antenna_offset_rotates_with_the_mount() {
        // The mount is rotated by 90 degrees to the left, so its x axis points north (y). Its rotation at 2 rad/s moves
        // the antenna along -x.
        let gps = Gps::new([0.5, 0.0, 0.2], [0.0; 3]).unwrap();
        let pose = [1.0, 1.0, 0.0, 0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2];
        let (position, velocity) = gps.fix(pose, [0.0, 3.0, 0.0, 0.0, 0.0, 2.0]);
        for (found, wanted) in position.into_iter().chain(velocity).zip([1.0, 1.5, 0.2, -1.0, 3.0, 0.0]) {
            assert!((found - wanted).abs() < 1e-12, "{position:?} {velocity:?}");
        }
    }

    #[test]
    fn non_finite_parameters_are_refused() {
        assert!(Gps::new([0.0, f64::NAN, 0.0], [0.0; 3]).is_err());
        assert!(Gps::new([0.0; 3], [0.0, 0.0, f64::INFINITY]).is_err());
        assert!(Gps::new([0.0; 3], [FRAC_PI_2, 0.0, 0.0]).is_ok(), "the pole is a valid position");
    }

    #[test]
    fn readme_names_every_parameter_field_and_preset() {
        let readme = include_str!("../README.md");
        let quoted = |d: &dyn std::fmt::Debug| format!("{d:?}").split('"').nth(1).unwrap().to_owned();
        let all = (Gps::params().into_iter().map(|p| quoted(&p)).collect::<Vec<_>>().into_iter())
            .chain(Gps::fields().into_iter().map(|f| quoted(&f)))
            .chain(Gps::PRESETS.iter().map(|p| p.id.to_owned()));
        for name in all {
            assert!(readme.contains(&format!("| `{name}`")), "{name}");
        }
    }
}
