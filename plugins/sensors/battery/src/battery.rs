//! The sensor kind "battery".

use tatu_plugin_api::{
    abi::{TATU_IN_JOINT, TATU_KIND_JOINT, tatu_object},
    fields,
    safe::{Beams, Change, Fail, Field, Instance, Param, Params, Preset, Readout, Result, Sample, Sensor, SharedWorld},
};

use crate::{
    cells::{BatteryCells, BatteryOutput},
    presets,
};

/// The plugin, which has no state.
pub struct BatteryPlugin;

/// The configuration of a battery.
#[derive(Debug, Clone, PartialEq)]
pub struct Battery {
    /// The joint whose motor the battery feeds; 0: the nearest joint above the sensor.
    joint: tatu_object,
    /// Charge at the start, 0 to 1.
    charge: f64,
    circuit: Circuit,
}

/// The parameters that a script can change during a run.
#[derive(Debug, Clone, PartialEq)]
struct Circuit {
    cells: BatteryCells,
    /// Number of motors, each of which draws as much power as the motor of the joint.
    motors: f64,
    /// Current of all loads except motors, A.
    idle: f64,
    /// Efficiency of a motor: mechanical power per electrical power.
    efficiency: f64,
}

fields! {
    Battery {
        VOLTAGE: f64 = Field::new("battery.voltage").unit("V").text("Voltage between the terminals; 0 if empty.");
        CURRENT: f64 = Field::new("battery.current").unit("A").text("Current that the battery delivers.");
        CHARGE: f64 = Field::new("battery.charge").unit("1").text("Remaining fraction of the capacity, 0 to 1.");
    }
}

/// Number of state values: whether a measurement has been made (0 or 1), its time, s, its current, A, and the charge.
const STATE_LEN: usize = 4;

impl Circuit {
    fn new(params: &Params<'_>) -> Result<Self> {
        let voltages = params.get("voltages")?.numbers().unwrap_or_default();
        if voltages.is_empty() || !voltages.iter().all(|v| v.is_finite() && *v >= 0.0) {
            return Err(Fail::argument(format!(
                "`voltages`: expected at least one value, each finite and at least 0, found {voltages:?} V"
            )));
        }
        const SECONDS_PER_HOUR: f64 = 3600.0;
        Ok(Circuit {
            cells: BatteryCells {
                capacity: params.f64("capacity_ah")? * SECONDS_PER_HOUR,
                voltages,
                resistance: params.f64("resistance_ohm")?,
            },
            motors: params.i64("motors")? as f64,
            idle: params.f64("idle_current")?,
            efficiency: params.f64("efficiency")?,
        })
    }
}

impl Battery {
    /// Updates the state with the joint's velocity and effort at a time, s, and returns the output and the charge.
    fn drain(&self, state: &mut [f64], (time, velocity, effort): (f64, f64, f64)) -> (BatteryOutput, f64) {
        let [there, last_time, current, charge] = state else {
            return (BatteryOutput { voltage: 0.0, current: 0.0 }, 0.0);
        };
        if *there == 0.0 {
            (*there, *charge) = (1.0, self.charge);
        } else {
            *charge = self.circuit.cells.charge_after(*charge, *current, time - *last_time);
        }
        let Circuit { cells, motors, idle, efficiency } = &self.circuit;
        let output = cells.deliver(*charge, *idle, motors * (effort * velocity).abs() / efficiency);
        (*last_time, *current) = (time, output.current);
        (output, *charge)
    }
}

impl Sensor for Battery {
    type Plugin = BatteryPlugin;
    const ID: &'static str = "battery";
    const TEXT: &'static str = "Measures voltage, current and charge of a battery that a joint's motor drains.";
    const SCHEMAS: &'static [&'static str] = &["battery/1"];
    const INPUTS: u32 = TATU_IN_JOINT;
    const EVERY_PHYSICS_STEP: bool = true;
    const STATE: usize = STATE_LEN;
    const PRESETS: &'static [Preset] = presets::ALL;

    fn params() -> Vec<Param> {
        vec![
            Param::string("joint")
                .default("")
                .text("Path of the joint relative to the sensor (`..` is its parent); empty: the nearest joint above.")
                .rebuilds(),
            Param::int("motors")
                .range(0.0, 1e6)
                .default(1_i64)
                .text("Number of motors, each of which is assumed to draw as much power as the joint's motor."),
            Param::float("capacity_ah").range(1e-9, 1e9).default(2.0).text("Full charge, A h."),
            Param::floats("voltages", 0)
                .unit("V")
                .default(vec![9.0, 11.1, 12.6])
                .text("Open-circuit voltages at equally spaced charges, from empty to full."),
            Param::float("resistance_ohm").range(0.0, 1e9).default(0.1).text("Internal resistance, Ohm."),
            Param::float("idle_current")
                .unit("A")
                .range(0.0, 1e6)
                .default(0.0)
                .text("Current of all loads except the motors."),
            Param::float("efficiency")
                .range(1e-3, 1.0)
                .default(0.7)
                .text("Efficiency of a motor: mechanical power per electrical power."),
            Param::float("charge").range(0.0, 1.0).default(1.0).text("Charge at the start.").rebuilds(),
        ]
    }

    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }

    fn create(world: &SharedWorld<'_>, instance: Instance, params: &Params<'_>) -> Result<Self> {
        let path = params.string("joint")?;
        let joint = if path.is_empty() { 0 } else { world.find(instance.owner, &path)? };
        if joint != 0 && world.look(joint)?.kind != TATU_KIND_JOINT {
            return Err(Fail::argument(format!("`joint`: `{path}` is not a joint")));
        }
        Ok(Battery { joint, charge: params.f64("charge")?, circuit: Circuit::new(params)? })
    }

    fn configure(&mut self, params: &Params<'_>, _: u64) -> Result<Change> {
        self.circuit = Circuit::new(params)?;
        Ok(Change::Taken)
    }

    fn beams(&self) -> Result<Beams> {
        Ok(Beams { observed: self.joint, ..Beams::default() })
    }

    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        let Some([_, velocity, effort]) = sample.joint() else {
            return Err(Fail::unsupported("this host does not provide the state of joints"));
        };
        let (output, charge) = self.drain(out.state(), (sample.time(), velocity, effort));
        out.set(Self::VOLTAGE, output.voltage);
        out.set(Self::CURRENT, output.current);
        out.set(Self::CHARGE, charge);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motor_drains_the_charge_by_its_power() {
        let cells = BatteryCells { capacity: 100.0, voltages: vec![10.0], resistance: 0.0 };
        let circuit = Circuit { cells, motors: 2.0, idle: 1.0, efficiency: 0.5 };
        let it = Battery { joint: 0, charge: 0.5, circuit };
        let mut state = [0.0; STATE_LEN];
        // Two motors of 5 W with an efficiency of 0.5 draw 20 W, which is 2 A; the idle current is 1 A.
        let (output, charge) = it.drain(&mut state, (3.0, -5.0, 1.0));
        assert_eq!((output.current, output.voltage, charge), (3.0, 10.0, 0.5));
        let (_, charge) = it.drain(&mut state, (8.0, 0.0, 1.0));
        assert!((charge - 0.35).abs() < 1e-12, "5 s of 3 A out of 100 C: {charge}");
    }

    #[test]
    fn readme_names_every_parameter_field_and_preset() {
        let readme = include_str!("../README.md");
        let all = (Battery::params().iter().map(|p| p.key().to_owned()).collect::<Vec<_>>().into_iter())
            .chain(Battery::fields().into_iter().map(|f| f.name().to_owned()))
            .chain(Battery::PRESETS.iter().map(|p| p.id.to_owned()));
        for name in all {
            assert!(readme.contains(&format!("| `{name}`")), "{name}");
        }
    }
}
