//! The sensor kind "force_torque".

use tatu_plugin_api::{
    abi::{TATU_IN_WRENCH, TATU_KIND_FORCE_SENSOR, tatu_object},
    fields,
    safe::{Beams, Fail, Field, Instance, Param, Params, Preset, Readout, Result, Sample, Sensor, SharedWorld},
};

use crate::presets;

/// The plugin, which has no state.
pub struct ForceTorquePlugin;

/// The configuration of a force and torque sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ForceTorque {
    /// The force sensor object whose load is measured; 0: the nearest one above the sensor.
    force_sensor: tatu_object,
}

fields! {
    ForceTorque {
        FORCE: f64 = Field::new("wrench.force")
            .elements(3)
            .unit("N")
            .text("Force of the load on the sensor, in the sensor's frame.");
        TORQUE: f64 = Field::new("wrench.torque")
            .elements(3)
            .unit("N m")
            .text("Torque of the load about the sensor's origin, in the sensor's frame.");
    }
}

impl Sensor for ForceTorque {
    type Plugin = ForceTorquePlugin;
    const ID: &'static str = "force_torque";
    const TEXT: &'static str = "Measures force and torque between the two bodies that a force sensor connects.";
    const SCHEMAS: &'static [&'static str] = &["wrench/1"];
    const INPUTS: u32 = TATU_IN_WRENCH;
    const EVERY_PHYSICS_STEP: bool = true;
    const PRESETS: &'static [Preset] = presets::ALL;

    fn params() -> Vec<Param> {
        vec![
            Param::string("force_sensor")
                .default("")
                .text("Path of the force sensor relative to this one (`..` is its parent); empty: the nearest above.")
                .rebuilds(),
        ]
    }

    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }

    fn create(world: &SharedWorld<'_>, instance: Instance, params: &Params<'_>) -> Result<Self> {
        let path = params.string("force_sensor")?;
        let force_sensor = if path.is_empty() { 0 } else { world.find(instance.owner, &path)? };
        if force_sensor != 0 && world.look(force_sensor)?.kind != TATU_KIND_FORCE_SENSOR {
            return Err(Fail::argument(format!("`force_sensor`: `{path}` is not a force sensor")));
        }
        Ok(ForceTorque { force_sensor })
    }

    fn beams(&self) -> Result<Beams> {
        Ok(Beams { observed: self.force_sensor, ..Beams::default() })
    }

    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let Some([fx, fy, fz, tx, ty, tz]) = sample.wrench() else {
            return Err(Fail::unsupported("this host does not provide the load of force sensors"));
        };
        out.slice(Self::FORCE).copy_from_slice(&[fx, fy, fz]);
        out.slice(Self::TORQUE).copy_from_slice(&[tx, ty, tz]);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readme_names_every_parameter_field_and_preset() {
        let readme = include_str!("../README.md");
        let all = (ForceTorque::params().iter().map(|p| p.key().to_owned()).collect::<Vec<_>>().into_iter())
            .chain(ForceTorque::fields().into_iter().map(|f| f.name().to_owned()))
            .chain(ForceTorque::PRESETS.iter().map(|p| p.id.to_owned()));
        for name in all {
            assert!(readme.contains(&format!("| `{name}`")), "{name}");
        }
    }
}
