//! The sensor kind "imu".

use tatu_plugin_api::{
    abi::{TATU_IN_ACCELERATION, TATU_IN_POSE, TATU_IN_TWIST},
    fields,
    safe::{Beams, Fail, Field, Instance, Param, Params, Preset, Readout, Result, Sample, Sensor, SharedWorld},
};

use crate::presets;

/// The plugin, which has no state.
pub struct ImuPlugin;

/// An inertial measurement unit, which has no parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Imu;

fields! {
    Imu {
        ACCELERATION: f64 = Field::new("imu.acceleration")
            .elements(3)
            .unit("m/s^2")
            .text("Specific force in the sensor's frame: acceleration minus gravity.");
        ANGULAR_VELOCITY: f64 = Field::new("imu.angular_velocity")
            .elements(3)
            .unit("rad/s")
            .text("Angular velocity in the sensor's frame.");
        ORIENTATION: f64 = Field::new("imu.orientation")
            .elements(4)
            .text("Attitude of the sensor in the world: unit quaternion x y z w.");
    }
}

impl Sensor for Imu {
    type Plugin = ImuPlugin;
    const ID: &'static str = "imu";
    const TEXT: &'static str = "Measures specific force, angular velocity and attitude, after each physics step.";
    const SCHEMAS: &'static [&'static str] = &["imu/1"];
    const INPUTS: u32 = TATU_IN_POSE | TATU_IN_TWIST | TATU_IN_ACCELERATION;
    const EVERY_PHYSICS_STEP: bool = true;
    const PRESETS: &'static [Preset] = presets::ALL;

    fn params() -> Vec<Param> {
        Vec::new()
    }

    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }

    fn create(_: &SharedWorld<'_>, _: Instance, _: &Params<'_>) -> Result<Self> {
        Ok(Imu)
    }

    fn beams(&self) -> Result<Beams> {
        Ok(Beams::default())
    }

    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let (Some(pose), Some(twist), Some(acceleration)) = (sample.pose(), sample.twist(), sample.acceleration())
        else {
            return Err(Fail::unsupported("this host does not provide the acceleration of sensors"));
        };
        let gravity = sample.gravity();
        let force = std::array::from_fn(|i| acceleration[i] - gravity[i]);
        out.slice(Self::ACCELERATION).copy_from_slice(&sample.to_sensor(force));
        out.slice(Self::ANGULAR_VELOCITY).copy_from_slice(&sample.to_sensor([twist[3], twist[4], twist[5]]));
        out.slice(Self::ORIENTATION).copy_from_slice(&pose[3..]);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readme_names_every_field_and_preset() {
        let readme = include_str!("../README.md");
        let fields = Imu::fields().into_iter().map(|f| f.name().to_owned()).collect::<Vec<_>>();
        for name in fields.into_iter().chain(Imu::PRESETS.iter().map(|p| p.id.to_owned())) {
            assert!(readme.contains(&format!("| `{name}`")), "{name}");
        }
    }
}
