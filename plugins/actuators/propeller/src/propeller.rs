//! The actuator kind "propeller".

use tatu_plugin_api::{
    fields,
    safe::{Actuator, Drive, Fail, Field, Instance, Output, Param, Params, Result, SharedWorld},
};

use crate::rotor::{Rotor, RotorLoad};

/// The propeller plugin. It has no state.
pub struct PropellerPlugin;

/// A propeller with its motor.
#[derive(Debug, Clone, PartialEq)]
pub struct Propeller {
    rotor: Rotor,
}

fields! {
    Report {
        SPEED: f64 = Field::new("rotor.speed").unit("rad/s").text("Speed of the rotor, at least 0.");
        THRUST: f64 = Field::new("thrust.force").unit("N").text("Thrust along +z, mean since the previous call.");
        TORQUE: f64 = Field::new("rotor.torque")
            .unit("N m")
            .text("Torque of the air against the rotation, mean since the previous call.");
    }
}

/// The fields that a propeller reports.
struct Report;

fn number(key: &str, unit: &'static str, default: f64, text: &str) -> Param {
    let param = Param::float(key).range(0.0, 1e6).default(default).rebuilds().text(text);
    if unit.is_empty() { param } else { param.unit(unit) }
}

impl Actuator for Propeller {
    type Plugin = PropellerPlugin;
    const ID: &'static str = "propeller";
    const TEXT: &'static str = "Rotor with a commanded speed: thrust along +z, drag torque, and lag of the motor.";
    // The thrust must follow the attitude of a multicopter, which can change considerably within a step of the world.
    const EVERY_SUBSTEP: bool = true;
    /// The state is the speed, rad/s.
    const STATE: usize = 1;
    const SCHEMAS: &'static [&'static str] = &["thrust/1", "rotor/1"];

    fn params() -> Vec<Param> {
        vec![
            number("max_speed", "rad/s", 838.0, "Maximum speed.").range(0.001, 1e5),
            number("max_thrust", "N", 7.0, "Thrust at the maximum speed; thrust grows with the square of the speed."),
            number("torque_per_thrust", "m", 0.016, "Drag torque about the axis, in N m per N of thrust."),
            Param::string("turns")
                .choices(&["counter-clockwise", "clockwise"])
                .default("counter-clockwise")
                .rebuilds()
                .text("Sense of rotation, seen from the side towards which the thrust points."),
            number("time_constant", "s", 0.0125, "Time constant of an increase in speed (63 %); 0: no lag."),
            number("time_constant_down", "s", 0.025, "Time constant of a decrease in speed; 0: no lag."),
            number("inflow", "", 0.0, "Loss of thrust, N per rad/s of the rotor and m/s along +z."),
            number("rotor_drag", "", 0.0, "Force against motion across the axis, N per rad/s of the rotor and m/s."),
            number("rolling_moment", "", 0.0, "Torque against motion across the axis, N m per rad/s and m/s."),
            number("rotor_inertia", "kg m^2", 0.0, "Inertia about the axis, for gyroscopic torques."),
        ]
    }

    fn fields() -> Vec<Field> {
        Report::declared_fields()
    }

    fn commands() -> Vec<Param> {
        vec![Param::float("speed").unit("rad/s").default(0.0).text("Requested speed, clamped to 0 to `max_speed`.")]
    }

    fn create(_: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        let finite = |key: &str| match params.f64(key)? {
            x if x.is_finite() => Ok(x),
            _ => Err(Fail::argument(format!("`{key}` must be finite"))),
        };
        let max_speed = finite("max_speed")?;
        let direction = if params.string("turns")? == "clockwise" { -1.0 } else { 1.0 };
        let rotor = Rotor {
            max_speed,
            thrust: finite("max_thrust")? / (max_speed * max_speed),
            torque: finite("torque_per_thrust")?,
            direction,
            lag: [finite("time_constant")?, finite("time_constant_down")?],
            inflow: finite("inflow")?,
            drag: finite("rotor_drag")?,
            rolling: finite("rolling_moment")?,
            inertia: finite("rotor_inertia")?,
        };
        Ok(Propeller { rotor })
    }

    fn apply(&self, drive: &Drive<'_>, out: &mut Output<'_>) -> Result {
        let wanted = drive.commands().first().copied().unwrap_or(0.0);
        let (now, dt) = (out.state[0], drive.dt());
        let spin = self.rotor.spin(now, wanted, dt);
        let acceleration = if dt > 0.0 { (spin.end - now) / dt } else { 0.0 };
        let [vx, vy, vz, wx, wy, wz] = drive.twist();
        let (velocity, turn) = (to_mount(drive, [vx, vy, vz]), to_mount(drive, [wx, wy, wz]));
        let RotorLoad { force, torque, thrust, drag_torque } = self.rotor.load(spin, velocity, turn, acceleration);
        out.state[0] = spin.end;
        out.force = drive.to_world(force);
        out.torque = drive.to_world(torque);
        out.report.set(Report::SPEED, spin.end);
        out.report.set(Report::THRUST, thrust);
        out.report.set(Report::TORQUE, drag_torque);
        Ok(())
    }
}

/// Rotates a direction from the world frame to the mount's frame.
fn to_mount(drive: &Drive<'_>, v: [f64; 3]) -> [f64; 3] {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| drive.to_world(axis));
    axes.map(|a| a[0] * v[0] + a[1] * v[1] + a[2] * v[2])
}
