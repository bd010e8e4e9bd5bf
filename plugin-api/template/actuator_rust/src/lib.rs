//! my_plugin: a kind of actuator in Rust. A propeller, which pushes along its +z axis with a force that follows the
//! command `force` with a lag.
//!
//! Build: `tatu plugin build`. Run the demo: `tatu plugin run`. The manual: `cargo doc -p tatu-plugin-api --open`.
#![forbid(unsafe_code)]

use tatu_plugin_api::{safe::*, tatu_plugin};

/// The plugin. Data shared by all its actuators would be stored here.
struct ThisPlugin;

impl Plugin for ThisPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(ThisPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.actuator::<Propeller>();
    }
}

/// One propeller of a scene.
struct Propeller {
    max_force: f64,
    lag: f64,
}

impl Actuator for Propeller {
    type Plugin = ThisPlugin;

    const ID: &'static str = "my_plugin";
    const TEXT: &'static str = "Pushes along its +z axis, with a lag.";
    /// The state is the current force, N. The host saves it in snapshots, and zeroes it at a reset.
    const STATE: usize = 1;

    fn params() -> Vec<Param> {
        let positive = |key| Param::float(key).range(0.0, f64::INFINITY);
        vec![
            positive("max_force").unit("N").default(10.0).text("Maximum force, forwards and backwards."),
            positive("lag").unit("s").default(0.2).text("Time in which 63 % of a change is reached."),
        ]
    }
    fn commands() -> Vec<Param> {
        vec![Param::float("force").unit("N").default(0.0).text("Wanted force along +z.")]
    }

    fn create(_: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        Ok(Propeller { max_force: params.f64("max_force")?, lag: params.f64("lag")? })
    }
    fn configure(&mut self, params: &Params<'_>, _: u64) -> Result<Change> {
        (self.max_force, self.lag) = (params.f64("max_force")?, params.f64("lag")?);
        Ok(Change::Taken)
    }

    /// May be called on any thread, so it uses only the actuator and its arguments.
    fn apply(&self, drive: &Drive<'_>, out: &mut Output<'_>) -> Result {
        let wanted = drive.commands()[0].clamp(-self.max_force, self.max_force);
        let (now, x) = (out.state[0], drive.dt() / self.lag);
        // The mean force during the step, so that the impulse does not depend on the duration of steps.
        let (end, mean) = match x.is_finite() && x > 0.0 {
            true => (now + (wanted - now) * -(-x).exp_m1(), wanted + (now - wanted) * -(-x).exp_m1() / x),
            false => (wanted, wanted),
        };
        out.state[0] = end;
        out.force = drive.to_world([0.0, 0.0, mean]);
        Ok(())
    }
}

tatu_plugin! {
    plugin: ThisPlugin, id: "org.example.my_plugin", name: "my_plugin", version: "0.1.0", licence: "MIT",
}
