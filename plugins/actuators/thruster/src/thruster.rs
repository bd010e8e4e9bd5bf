//! The actuator kinds "thruster" and "thruster_substep", whose forces are computed once per step of the world and
//! before each engine step, respectively.

use tatu_plugin_api::{
    fields,
    safe::{Actuator, Drive, Fail, Field, Instance, Output, Param, Params, Result, SharedWorld},
};

/// The thruster plugin. It has no state.
pub struct ThrusterPlugin;

/// A thruster. If `SUBSTEP` is true, the force is updated before each engine step, not only in each step of the world.
#[derive(Debug, Clone, PartialEq)]
pub struct Thruster<const SUBSTEP: bool> {
    max_force: f64,
    time_constant: f64,
}

fields! {
    Report {
        FORCE: f64 = Field::new("thrust.force").unit("N").text("Thrust along +z, mean since the previous call.");
    }
}

/// The fields that a thruster reports.
struct Report;

/// Returns the thrust after a time `dt` and the mean thrust during `dt`, N, for a first-order lag from `now` to
/// `wanted`.
///
/// The mean yields the exact impulse, so the velocity of a body does not depend on the duration of a step.
fn lag(now: f64, wanted: f64, time_constant: f64, dt: f64) -> (f64, f64) {
    if time_constant <= 0.0 || dt <= 0.0 {
        return (wanted, wanted);
    }
    let x = dt / time_constant;
    // 1 - exp(-x), accurate for small x.
    let reached = -libm::expm1(-x);
    (now + (wanted - now) * reached, wanted + (now - wanted) * (reached / x))
}

impl<const SUBSTEP: bool> Actuator for Thruster<SUBSTEP> {
    type Plugin = ThrusterPlugin;
    const ID: &'static str = if SUBSTEP { "thruster_substep" } else { "thruster" };
    const TEXT: &'static str = if SUBSTEP {
        "Force along its +z axis, evaluated before each engine step, so its direction follows fast rotation."
    } else {
        "Force along its +z axis, which a script sets."
    };
    const EVERY_SUBSTEP: bool = SUBSTEP;
    /// The state is the thrust, N.
    const STATE: usize = 1;
    const SCHEMAS: &'static [&'static str] = &["thrust/1"];

    fn params() -> Vec<Param> {
        vec![
            Param::float("max_force")
                .unit("N")
                .range(0.0, f64::INFINITY)
                .default(10.0)
                .rebuilds()
                .text("Maximum thrust, forwards and backwards."),
            Param::float("time_constant")
                .unit("s")
                .range(0.0, f64::INFINITY)
                .default(0.0)
                .rebuilds()
                .text("Time constant of a change of thrust (63 % of the change); 0: no lag."),
        ]
    }

    fn fields() -> Vec<Field> {
        Report::declared_fields()
    }

    fn commands() -> Vec<Param> {
        vec![Param::float("thrust").unit("N").default(0.0).text("Requested force along +z, limited to `max_force`.")]
    }

    fn create(_: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        let (max_force, time_constant) = (params.f64("max_force")?, params.f64("time_constant")?);
        if !(max_force.is_finite() && time_constant.is_finite()) {
            return Err(Fail::argument("`max_force` and `time_constant` must be finite"));
        }
        Ok(Thruster { max_force, time_constant })
    }

    fn apply(&self, drive: &Drive<'_>, out: &mut Output<'_>) -> Result {
        let wanted = drive.commands().first().copied().unwrap_or(0.0).clamp(-self.max_force, self.max_force);
        let now = out.state[0];
        let (end, mean) = lag(now, wanted, self.time_constant, drive.dt());
        out.state[0] = end;
        out.force = drive.to_world([0.0, 0.0, mean]);
        out.report.set(Report::FORCE, mean);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::lag;

    #[test]
    fn a_lag_does_not_depend_on_the_length_of_steps() {
        // The thrust and the impulse of a step response are F (1 - e^(-t/tau)) and F (t - tau (1 - e^(-t/tau))).
        let (force, tau, t) = (8.0, 0.3, 1.2);
        for steps in [1, 7, 100] {
            let dt = t / f64::from(steps);
            let (mut now, mut impulse) = (0.0, 0.0);
            for _ in 0..steps {
                let (end, mean) = lag(now, force, tau, dt);
                now = end;
                impulse += mean * dt;
            }
            let left = libm::exp(-t / tau);
            assert!((now - force * (1.0 - left)).abs() < 1e-12, "{steps}: {now}");
            assert!((impulse - force * (t - tau * (1.0 - left))).abs() < 1e-12, "{steps}: {impulse}");
        }
    }

    #[test]
    fn thrust_without_lag_is_immediate() {
        assert_eq!(lag(1.0, 5.0, 0.0, 0.01), (5.0, 5.0));
    }
}
