//! The sensor kind "contact".

use std::f64::consts::{PI, TAU};

use tatu_plugin_api::{
    abi::{TATU_IN_CONTACTS, TATU_IN_POSE, TATU_KIND_SHAPE, tatu_object},
    fields,
    safe::{Beams, Change, Fail, Field, Instance, Param, Params, Preset, Readout, Result, Sample, Sensor, SharedWorld},
};

use crate::presets;

/// The plugin, which has no state.
pub struct ContactPlugin;

/// The configuration of a contact sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactSensor {
    /// The observed shape; 0: the nearest shape with a body above the sensor.
    shape: tatu_object,
    settings: ContactSettings,
}

/// The parameters that can change during a run.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ContactSettings {
    /// Minimum sum of normal forces at which the sensor reports a contact, N.
    threshold: f64,
    /// Direction of the middle of the sector: angle about the sensor's +z, from +x, rad.
    direction: f64,
    /// Full angle of the sector, rad.
    sector: f64,
    /// Minimum and maximum corners of the sensitive region in the sensor's frame, m; `None`: no limits.
    region: Option<[f64; 6]>,
}

fields! {
    ContactSensor {
        TOUCHING: i32 = Field::new("contact.touching")
            .text("Whether the normal force is at least the threshold: 1 or 0.");
        FORCE: f64 = Field::new("contact.force")
            .elements(3)
            .unit("N")
            .text("Sum of normal forces and friction on the shape, in the sensor's frame.");
        COUNT: i32 = Field::new("contact.count").text("Number of pairs of faces in contact that carry a force.");
        NORMAL_FORCE: f64 = Field::new("contact.normal_force").unit("N").text("Sum of the normal forces.");
        POINT: f64 = Field::new("contact.point")
            .elements(3)
            .unit("m")
            .text("Centre of pressure in the sensor's frame; 0 0 0 without a contact.");
    }
}

impl ContactSettings {
    fn new(params: &Params<'_>) -> Result<Self> {
        let region = if params.get("region")?.is_nil() { None } else { Some(params.array::<6>("region")?) };
        if let Some(r) = region.filter(|r| (0..3).any(|i| r[i].is_nan() || r[i + 3].is_nan() || r[i] > r[i + 3])) {
            return Err(Fail::argument(format!(
                "`region`: expected x y z of the minimum corner, then of the maximum corner, found {r:?} m"
            )));
        }
        let (threshold, direction) = (params.f64("threshold")?, params.f64("direction")?);
        Ok(ContactSettings { threshold, direction, sector: params.f64("sector")?, region })
    }

    /// Returns whether a point, in the sensor's frame, is in the sector and the region.
    fn is_sensitive_at(&self, at: [f64; 3]) -> bool {
        let inside = self.region.is_none_or(|r| (0..3).all(|i| r[i] <= at[i] && at[i] <= r[i + 3]));
        if !inside || self.sector >= TAU {
            return inside;
        }
        let turn = libm::atan2(at[1], at[0]) - self.direction;
        let off = turn - TAU * ((turn + PI) / TAU).floor();
        off.abs() <= 0.5 * self.sector
    }

    fn reaches_threshold(&self, force: f64) -> bool {
        force > 0.0 && force >= self.threshold
    }
}

/// The load on the shape, in the sensor's frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct ContactLoad {
    count: i32,
    normal: f64,
    force: [f64; 3],
    /// Sum of the contact points, each multiplied by its normal force, N m.
    moment: [f64; 3],
}

impl ContactLoad {
    fn of(sample: &Sample<'_>, settings: &ContactSettings) -> Self {
        let mut load = ContactLoad::default();
        let Some([x, y, z, ..]) = sample.pose() else { return load };
        for (contact, friction) in sample.contacts().iter().zip(sample.frictions()) {
            let ([px, py, pz], normal) = (contact.point, contact.force);
            let at = sample.to_sensor([px - x, py - y, pz - z]);
            if normal <= 0.0 || !settings.is_sensitive_at(at) {
                continue;
            }
            let force = sample.to_sensor([0, 1, 2].map(|i| normal * contact.normal[i] + friction[i]));
            load.count += 1;
            load.normal += normal;
            for i in 0..3 {
                load.force[i] += force[i];
                load.moment[i] += normal * at[i];
            }
        }
        load
    }
}

impl Sensor for ContactSensor {
    type Plugin = ContactPlugin;
    const ID: &'static str = "contact";
    const TEXT: &'static str = "Measures the contacts of a shape and their forces, for bumpers and feet.";
    const SCHEMAS: &'static [&'static str] = &["contact/1"];
    const INPUTS: u32 = TATU_IN_POSE | TATU_IN_CONTACTS;
    const EVERY_PHYSICS_STEP: bool = true;
    const PRESETS: &'static [Preset] = presets::ALL;

    fn params() -> Vec<Param> {
        vec![
            Param::string("shape")
                .default("")
                .text("Path of the shape relative to the sensor (`..` is its parent); empty: the nearest above it.")
                .rebuilds(),
            Param::float("threshold")
                .unit("N")
                .range(0.0, 1e9)
                .default(0.0)
                .text("Minimum sum of normal forces at which a contact is reported."),
            Param::float("direction")
                .unit("rad")
                .range(-TAU, TAU)
                .default(0.0)
                .text("Middle of the sensitive sector: angle about the sensor's +z, from +x towards +y."),
            Param::float("sector")
                .unit("rad")
                .range(0.0, TAU)
                .default(TAU)
                .text("Full angle of the sector, seen from the sensor's origin; a full turn: all directions."),
            Param::floats("region", 6)
                .unit("m")
                .optional()
                .text("Sensitive box in the sensor's frame: minimum x y z, maximum x y z."),
        ]
    }

    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }

    fn create(world: &SharedWorld<'_>, instance: Instance, params: &Params<'_>) -> Result<Self> {
        let path = params.string("shape")?;
        let shape = if path.is_empty() { 0 } else { world.find(instance.owner, &path)? };
        if shape != 0 && world.look(shape)?.kind != TATU_KIND_SHAPE {
            return Err(Fail::argument(format!("`shape`: `{path}` is not a shape")));
        }
        Ok(ContactSensor { shape, settings: ContactSettings::new(params)? })
    }

    fn configure(&mut self, params: &Params<'_>, _: u64) -> Result<Change> {
        self.settings = ContactSettings::new(params)?;
        Ok(Change::Taken)
    }

    fn beams(&self) -> Result<Beams> {
        Ok(Beams { observed: self.shape, ..Beams::default() })
    }

    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        if sample.pose().is_none() {
            return Err(Fail::unsupported("this host does not provide the pose of sensors"));
        }
        let load = ContactLoad::of(sample, &self.settings);
        out.set(Self::TOUCHING, self.settings.reaches_threshold(load.normal).into());
        out.slice(Self::FORCE).copy_from_slice(&load.force);
        out.set(Self::COUNT, load.count);
        out.set(Self::NORMAL_FORCE, load.normal);
        let point = if load.normal > 0.0 { load.moment.map(|m| m / load.normal) } else { [0.0; 3] };
        out.slice(Self::POINT).copy_from_slice(&point);
        Ok(())
    }

    /// Compares the noisy normal force with the threshold.
    fn finish(&self, _: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let normal = out.slice(Self::NORMAL_FORCE)[0];
        out.set(Self::TOUCHING, self.settings.reaches_threshold(normal).into());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNRESTRICTED: ContactSettings = ContactSettings { threshold: 0.0, direction: 0.0, sector: TAU, region: None };

    #[test]
    fn a_sector_is_centred_on_its_direction_across_half_a_turn() {
        let quarter = ContactSettings { direction: PI, sector: 0.5 * PI, ..UNRESTRICTED };
        let at = |degrees: f64| [degrees.to_radians().cos(), degrees.to_radians().sin(), 3.0];
        for (degrees, felt) in [(180.0, true), (136.0, true), (-136.0, true), (134.0, false), (-134.0, false)] {
            assert_eq!(quarter.is_sensitive_at(at(degrees)), felt, "{degrees}");
        }
        assert!(UNRESTRICTED.is_sensitive_at(at(77.0)));
        assert!(!ContactSettings { sector: 0.0, ..UNRESTRICTED }.is_sensitive_at(at(1.0)), "a sector of 0 is a line");
    }

    #[test]
    fn a_region_includes_its_faces() {
        let region = ContactSettings { region: Some([-0.1, -0.1, 0.0, 0.1, 0.1, 0.0]), ..UNRESTRICTED };
        assert!(region.is_sensitive_at([0.1, -0.1, 0.0]) && region.is_sensitive_at([0.0; 3]));
        assert!(!region.is_sensitive_at([0.11, 0.0, 0.0]) && !region.is_sensitive_at([0.0, 0.0, 1e-9]));
    }

    #[test]
    fn a_switch_closes_at_its_threshold_but_never_without_a_force() {
        assert!(!UNRESTRICTED.reaches_threshold(0.0) && UNRESTRICTED.reaches_threshold(1e-9));
        let switch = ContactSettings { threshold: 1.5, ..UNRESTRICTED };
        assert!(!switch.reaches_threshold(1.49) && switch.reaches_threshold(1.5));
    }

    #[test]
    fn readme_names_every_parameter_field_and_preset() {
        let readme = include_str!("../README.md");
        let all = (ContactSensor::params().iter().map(|p| p.key().to_owned()).collect::<Vec<_>>().into_iter())
            .chain(ContactSensor::fields().into_iter().map(|f| f.name().to_owned()))
            .chain(ContactSensor::PRESETS.iter().map(|p| p.id.to_owned()));
        for name in all {
            assert!(readme.contains(&format!("| `{name}`")), "{name}");
        }
    }
}
