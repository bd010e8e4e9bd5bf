//! The sensor kind "barometer".

use tatu_plugin_api::{
    abi::TATU_IN_POSE,
    fields,
    safe::{Beams, Change, Fail, Field, Instance, Param, Params, Preset, Readout, Result, Sample, Sensor, SharedWorld},
};

use crate::{
    atmosphere::{self, SEA_LEVEL_PRESSURE},
    presets,
};

/// The plugin, which has no state.
pub struct BarometerPlugin;

/// The configuration of a barometer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Barometer {
    /// Altitude of the world's origin, m.
    origin: f64,
    /// Pressure at sea level, Pa.
    sea_level: f64,
}

fields! {
    Barometer {
        PRESSURE: f64 = Field::new("pressure.pressure").unit("Pa").text("Static pressure.");
        ALTITUDE: f64 = Field::new("pressure.altitude")
            .unit("m")
            .text("Altitude at which the standard atmosphere has this pressure.");
    }
}

fn altitude(pressure: f64) -> f64 {
    atmosphere::altitude(pressure / SEA_LEVEL_PRESSURE)
}

impl Sensor for Barometer {
    type Plugin = BarometerPlugin;
    const ID: &'static str = "barometer";
    const TEXT: &'static str = "Measures the pressure of the standard atmosphere, and the altitude derived from it.";
    const SCHEMAS: &'static [&'static str] = &["pressure/1"];
    const INPUTS: u32 = TATU_IN_POSE;
    const EVERY_PHYSICS_STEP: bool = true;
    const PRESETS: &'static [Preset] = presets::ALL;

    fn params() -> Vec<Param> {
        vec![
            Param::float("sea_level_pressure")
                .unit("Pa")
                .range(50_000.0, 150_000.0)
                .default(SEA_LEVEL_PRESSURE)
                .text("Air pressure at sea level (QNH)."),
        ]
    }

    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }

    fn create(world: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        let [_, _, origin] = world.f64s(0, world.host().prop("scene.origin"))?;
        if !origin.is_finite() {
            return Err(Fail::argument("the altitude in `scene.origin` must be finite for a barometer"));
        }
        Ok(Barometer { origin, sea_level: params.f64("sea_level_pressure")? })
    }

    fn configure(&mut self, params: &Params<'_>, _: u64) -> Result<Change> {
        self.sea_level = params.f64("sea_level_pressure")?;
        Ok(Change::Taken)
    }

    fn beams(&self) -> Result<Beams> {
        Ok(Beams::default())
    }

    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let Some([_, _, z, ..]) = sample.pose() else {
            return Err(Fail::unsupported("this host does not provide the pose of sensors"));
        };
        let pressure = self.sea_level * atmosphere::pressure_ratio(self.origin + z);
        out.set(Self::PRESSURE, pressure);
        out.set(Self::ALTITUDE, altitude(pressure));
        Ok(())
    }

    /// Computes the altitude from the noisy pressure.
    fn finish(&self, _: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let pressure = out.slice(Self::PRESSURE)[0];
        out.set(Self::ALTITUDE, altitude(pressure));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readme_names_every_parameter_field_and_preset() {
        let readme = include_str!("../README.md");
        let all = (Barometer::params().iter().map(|p| p.key().to_owned()).collect::<Vec<_>>().into_iter())
            .chain(Barometer::fields().into_iter().map(|f| f.name().to_owned()))
            .chain(Barometer::PRESETS.iter().map(|p| p.id.to_owned()));
        for name in all {
            assert!(readme.contains(&format!("| `{name}`")), "{name}");
        }
    }
}
