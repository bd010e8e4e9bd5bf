//! The Manta: a small car with rear-wheel drive and Ackermann steering.
//!
//! `numbers` has dimensions and masses, `parts` the moving and colliding parts, `look` the visible ones. The base frame
//! is at the middle of the rear axle, x forward, y left, so the car turns about a point on its own y axis.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "what tests compare with decides no bits"))]

mod look;
mod numbers;
mod parts;

use tatu_plugin_api::{
    safe::{Builder, Host, Model, Offer, Param, Params, Plugin, Result},
    tatu_plugin,
};

/// The plugin; it has no state.
pub struct Mantas;

impl Plugin for Mantas {
    fn start(_: &Host) -> Result<Self> {
        Ok(Mantas)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.model::<Manta>();
    }
}

/// The model "manta".
pub struct Manta;

impl Model for Manta {
    type Plugin = Mantas;
    const CATEGORY: &'static str = "mobile robots";
    const ID: &'static str = "manta";
    const TEXT: &'static str =
        "Manta: a small car, rear wheels driven, front wheels steered; stands on z = 0, facing +x.";
    const SLOTS: &'static [&'static str] = &[parts::SLOT];

    fn params() -> Vec<Param> {
        vec![
            Param::float("motor_torque")
                .unit("N m")
                .range(0.0, 1000.0)
                .default(numbers::MOTOR_TORQUE)
                .text("Greatest torque of the motor until a script sets another; each rear wheel gets half of it."),
            Param::floats("color", 3)
                .range(0.0, 1.0)
                .default([0.10, 0.30, 0.55])
                .text("Red, green and blue of the body, 0 to 1."),
        ]
    }

    fn build(builder: &Builder<'_>, params: &Params<'_>) -> Result {
        let color = params.array("color")?;
        let base = parts::base(builder, color)?;
        parts::steering(builder, base)?;
        parts::drive(builder, base, params.f64("motor_torque")?)?;
        parts::slot(builder, base)?;
        // Added last, so that the indices of the other children do not change.
        look::body(builder, base, color)
    }
}

tatu_plugin! {
    plugin: Mantas,
    id: "tatu.robot.manta",
    name: "Manta",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}
