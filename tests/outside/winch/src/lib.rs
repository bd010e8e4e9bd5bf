//! A winch: an actuator that pulls the bodies that the scene lists as its targets, each on a cable of the commanded
//! length, with equal and opposite forces.

use tatu_plugin_api::{
    abi::TATU_IN_TARGETS,
    fields,
    safe::{Actuator, Drive, Field, Host, Instance, Offer, Output, Param, Params, Plugin, Result, SharedWorld},
    tatu_plugin,
};

/// The plugin; it has no state.
pub struct Winches;

impl Plugin for Winches {
    fn start(_: &Host) -> Result<Self> {
        Ok(Winches)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.actuator::<Winch>();
    }
}

/// A winch in a scene.
pub struct Winch {
    /// Tension of a cable per extension, N/m.
    stiffness: f64,
    /// Tension of a cable per speed of extension, N s/m.
    damping: f64,
}

fields! {
    Winch {
        TENSION: f64 = Field::new("winch.tension").unit("N").text("Tension of all cables together.");
    }
}

impl Actuator for Winch {
    type Plugin = Winches;
    const ID: &'static str = "winch";
    const TEXT: &'static str = "Pulls bodies with cables.";
    const INPUTS: u32 = TATU_IN_TARGETS;
    const EVERY_SUBSTEP: bool = true;
    const SCHEMAS: &'static [&'static str] = &["winch/1"];

    fn params() -> Vec<Param> {
        vec![
            Param::float("stiffness").unit("N/m").range(0.0, 1e7).default(2e4).text("Tension per extension."),
            Param::float("damping").unit("N s/m").range(0.0, 1e6).default(400.0).text("Tension per speed."),
        ]
    }

    fn commands() -> Vec<Param> {
        vec![Param::float("length").unit("m").range(0.0, 1e3).default(1.0).text("Length of each cable.")]
    }

    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }

    fn create(_: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        Ok(Winch { stiffness: params.f64("stiffness")?, damping: params.f64("damping")? })
    }

    fn apply(&self, drive: &Drive<'_>, out: &mut Output<'_>) -> Result {
        let (pose, twist, length) = (drive.pose(), drive.twist(), drive.commands()[0]);
        let mut sum = 0.0;
        for (wrench, target) in out.target_wrenches.iter_mut().zip(drive.targets()) {
            // A target that has been removed has no cable.
            let Some(target) = target else { continue };
            let along: [f64; 3] = std::array::from_fn(|k| target.pose[k] - pose[k]);
            let distance = along.iter().map(|x| x * x).sum::<f64>().sqrt();
            if distance <= length {
                continue;
            }
            let along = along.map(|x| x / distance);
            let speed: f64 = (0..3).map(|k| (target.twist[k] - twist[k]) * along[k]).sum();
            // A cable does not push.
            let tension = (self.stiffness * (distance - length) + self.damping * speed).max(0.0);
            for k in 0..3 {
                wrench[k] = -tension * along[k];
                out.force[k] += tension * along[k];
            }
            sum += tension;
        }
        out.report.set(Self::TENSION, sum);
        Ok(())
    }
}

tatu_plugin! {
    plugin: Winches, id: "org.example.winch", name: "Winch", version: "1.0.0", licence: "MIT",
}
