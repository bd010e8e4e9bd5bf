//! The sensor kind "wheel_encoder".

use std::f64::consts::{PI, TAU};

use tatu_plugin_api::{
    abi::{TATU_IN_JOINT, TATU_LOG_WARNING, tatu_object},
    fields,
    safe::{Beams, Fail, Field, Instance, Param, Params, Preset, Readout, Result, Sample, Sensor, SharedWorld, Value},
};

use crate::presets;

/// The plugin, which has no state.
pub struct WheelEncoderPlugin;

/// The configuration of an encoder.
#[derive(Debug, Clone, PartialEq)]
pub struct WheelEncoder {
    /// The measured joint; 0: the nearest joint above the sensor.
    joint: tatu_object,
    /// Counts per rad, or per metre for a prismatic joint.
    counts: f64,
    /// The joint's position when the encoder was created, rad or m; the count is 0 at this position.
    start: f64,
}

fields! {
    WheelEncoder {
        TICKS: i32 = Field::new("encoder.ticks").text("Counts since the encoder was created.");
        POSITION: f64 = Field::new("encoder.position").unit("rad|m").text("Position that corresponds to the counts.");
        VELOCITY: f64 = Field::new("encoder.velocity")
            .unit("rad/s|m/s")
            .text("Change of the position since the previous measurement, divided by the elapsed time.");
    }
}

/// Number of state values: whether a measurement has been made (0 or 1), its time, s, the joint's position, the
/// position since the start, and the counts.
const STATE_LEN: usize = 5;

impl WheelEncoder {
    /// Returns the counts at a position relative to the start, rounded down.
    fn count(&self, position: f64) -> f64 {
        (position * self.counts).floor()
    }

    /// Updates the state with the joint's position and velocity at a time, s. Returns the counts, the counts of the
    /// previous measurement, and the time since then, s.
    fn update_counts(&self, state: &mut [f64], (time, position, velocity): (f64, f64, f64)) -> (f64, f64, f64) {
        let [there, last_time, last_position, total, counted] = state else { return (0.0, 0.0, 0.0) };
        if *there == 0.0 {
            (*there, *last_time, *last_position) = (1.0, 0.0, self.start);
        }
        let (passed, before) = (time - *last_time, *counted);
        // The position of a joint without limits is in (-pi, pi]; its velocity determines the number of whole turns.
        let expected = velocity * passed;
        let off = position - *last_position - expected;
        *total += expected + off - TAU * ((off + PI) / TAU).floor();
        (*last_time, *last_position) = (time, position);
        *counted = self.count(*total);
        (*counted, before, passed)
    }
}

impl Sensor for WheelEncoder {
    type Plugin = WheelEncoderPlugin;
    const ID: &'static str = "wheel_encoder";
    const TEXT: &'static str = "Counts the ticks of a joint, like the incremental encoder of a wheel.";
    const SCHEMAS: &'static [&'static str] = &["encoder/1"];
    const INPUTS: u32 = TATU_IN_JOINT;
    const EVERY_PHYSICS_STEP: bool = true;
    const STATE: usize = STATE_LEN;
    const PRESETS: &'static [Preset] = presets::ALL;

    fn params() -> Vec<Param> {
        vec![
            Param::string("joint")
                .default("")
                .text("Path of the joint relative to the sensor (`..` is its parent); empty: the nearest above it.")
                .rebuilds(),
            Param::float("counts_per_turn")
                .range(1.0, 1e9)
                .default(2000.0)
                .text("Counts per turn of the encoder's own shaft, after quadrature; prismatic joint: per metre."),
            Param::float("gear")
                .range(-1e6, 1e6)
                .default(1.0)
                .text("Turns of the encoder's shaft per turn of the joint; if negative, the encoder counts backwards."),
        ]
    }

    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }

    fn create(world: &SharedWorld<'_>, instance: Instance, params: &Params<'_>) -> Result<Self> {
        let (counts, gear) = (params.f64("counts_per_turn")?, params.f64("gear")?);
        if gear == 0.0 {
            return Err(Fail::argument("`gear`: expected a number other than 0"));
        }
        let path = params.string("joint")?;
        let joint = if path.is_empty() { 0 } else { world.find(instance.owner, &path)? };
        let [kind, position, parent] = ["joint.type", "joint.position", "object.parent"].map(|k| world.host().prop(k));
        // Determine the joint now, so that a later change of the tree has no effect.
        let mut found = if joint == 0 { instance.owner } else { joint };
        while found != 0 && world.get(found, kind).is_err() {
            if joint != 0 {
                return Err(Fail::argument(format!("`joint`: `{path}` is not a joint")));
            }
            found = match world.get(found, parent)?.to_value() {
                Ok(Value::Object(above)) => above,
                _ => 0,
            };
        }
        if found == 0 {
            let text = "the encoder counts nothing because no joint is above it; set `joint` to the path of a joint";
            world.log(TATU_LOG_WARNING, text.as_bytes());
            return Ok(WheelEncoder { joint, counts: counts * gear / TAU, start: 0.0 });
        }
        let slides = world.get(found, kind)?.to_value().is_ok_and(|v| v == "prismatic".into());
        let start = world.f64(found, position)?;
        Ok(WheelEncoder { joint, counts: counts * gear / if slides { 1.0 } else { TAU }, start })
    }

    fn beams(&self) -> Result<Beams> {
        Ok(Beams { observed: self.joint, ..Beams::default() })
    }

    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let Some([position, velocity, _]) = sample.joint() else {
            return Err(Fail::unsupported("this host does not provide the state of joints"));
        };
        let (counted, before, passed) = self.update_counts(out.state(), (sample.time(), position, velocity));
        // A 32-bit register wraps around.
        out.set(Self::TICKS, (counted as i64) as i32);
        out.set(Self::POSITION, counted / self.counts);
        out.set(Self::VELOCITY, if passed > 0.0 { (counted - before) / self.counts / passed } else { 0.0 });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_turns_between_two_measurements_are_counted() {
        let encoder = WheelEncoder { joint: 0, counts: 100.0 / TAU, start: 0.0 };
        let mut state = [0.0; STATE_LEN];
        let wrapped = |x: f64| x - TAU * ((x + PI) / TAU).floor();
        for i in 1..=20 {
            // At 50 rad/s and 10 Hz, the wheel turns by 0.8 turns between measurements.
            let angle = 5.0 * f64::from(i);
            let (counted, ..) = encoder.update_counts(&mut state, (0.1 * f64::from(i), wrapped(angle), 50.0));
            assert_eq!(counted, (angle * 100.0 / TAU).floor(), "{i}");
        }
        // The wheel turns backwards, and the velocity has an error of 30 %.
        for i in 1..=20 {
            let angle = 100.0 - 5.0 * f64::from(i);
            let (counted, ..) = encoder.update_counts(&mut state, (2.0 + 0.1 * f64::from(i), wrapped(angle), -35.0));
            assert_eq!(counted, (angle * 100.0 / TAU).floor(), "{i}");
        }
    }

    #[test]
    fn readme_names_every_parameter_field_and_preset() {
        let readme = include_str!("../README.md");
        let all = (WheelEncoder::params().iter().map(|p| p.key().to_owned()).collect::<Vec<_>>().into_iter())
            .chain(WheelEncoder::fields().into_iter().map(|f| f.name().to_owned()))
            .chain(WheelEncoder::PRESETS.iter().map(|p| p.id.to_owned()));
        for name in all {
            assert!(readme.contains(&format!("| `{name}`")), "{name}");
        }
    }
}
