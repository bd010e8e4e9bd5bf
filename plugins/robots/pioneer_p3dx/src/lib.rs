//! The Pioneer P3-DX: two driven wheels, a caster and a ring of sixteen sonars.
//!
//! `presets` has the numbers, `sonar` the ring, `parts` the moving and colliding parts, `look` the visible ones. The
//! base frame is 44.5 mm behind the axle and 0.1388 m above the floor, x forward, y left.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "what tests compare with decides no bits"))]

mod look;
mod parts;
mod presets;
mod sonar;
mod sonar_poses;

use std::f64::consts::{FRAC_PI_2, PI};

use tatu_plugin_api::{
    safe::{Builder, Host, Model, Offer, Param, Params, Plugin, Result},
    tatu_plugin,
};

/// The plugin; it has no state.
pub struct Pioneers;

impl Plugin for Pioneers {
    fn start(_: &Host) -> Result<Self> {
        Ok(Pioneers)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.model::<PioneerP3dx>();
    }
}

/// The model "pioneer_p3dx".
pub struct PioneerP3dx;

impl Model for PioneerP3dx {
    type Plugin = Pioneers;
    const CATEGORY: &'static str = "mobile robots";
    const ID: &'static str = "pioneer_p3dx";
    const TEXT: &'static str =
        "Pioneer P3-DX: two driven wheels, a caster, sixteen sonars; stands on z = 0, facing +x.";
    const SLOTS: &'static [&'static str] = parts::SLOTS;

    fn params() -> Vec<Param> {
        vec![
            Param::string("preset").choices(presets::NAMES).default(presets::NAMES[0]).text(
                "Set of numbers: those of V-REP's library model, or those of data sheets and the maker's software.",
            ),
            Param::float("sonar_range")
                .unit("m")
                .range(0.1, 5.0)
                .optional()
                .text("How far the sonars see; default: 1 as V-REP, 5 as the data sheet."),
            Param::float("sonar_angle")
                .unit("rad")
                .range(0.01, PI)
                .default(PI / 6.0)
                .text("Full opening angle of a sonar's cone."),
            Param::float("sonar_max_incidence").unit("rad").range(0.0, FRAC_PI_2).default(72f64.to_radians()).text(
                "Greatest angle between a sonar's line of sight and the surface normal; a quarter turn switches \
                     the limit off. 72 degrees keep the floor out of cones that reach the ground 0.77 m away, at 75 \
                     degrees from its normal. The original model has 45 degrees, which hides slanted walls and box \
                     corners, and drives the course's avoidance script into them.",
            ),
            Param::float("sonar_min_range")
                .unit("m")
                .range(0.0, 1.0)
                .default(0.05)
                .text("A sonar whose nearest echo is closer than this reports nothing."),
            Param::floats("color", 3)
                .range(0.0, 1.0)
                .default([0.72, 0.04, 0.05])
                .text("Red, green and blue of the body, 0 to 1."),
        ]
    }

    fn build(builder: &Builder<'_>, params: &Params<'_>) -> Result {
        let robot = presets::named(&params.string("preset")?)?;
        let beam = sonar::Beam {
            range: params.get("sonar_range")?.as_f64().unwrap_or(robot.sonar_range),
            angle: params.f64("sonar_angle")?,
            max_incidence: params.f64("sonar_max_incidence")?,
            min_range: params.f64("sonar_min_range")?,
        };
        let base = parts::base(builder, &robot)?;
        parts::drive(builder, base, &robot)?;
        parts::caster(builder, base, &robot)?;
        let body = look::body(builder, base, &robot, params.array("color")?)?;
        sonar::ring(builder, body, &robot, &beam)?;
        parts::slots(builder, base)
    }
}

tatu_plugin! {
    plugin: Pioneers,
    id: "tatu.robot.pioneer_p3dx",
    name: "Pioneer P3-DX",
    version: env!("CARGO_PKG_VERSION"),
    licence: "MIT OR Apache-2.0",
}

#[cfg(test)]
mod tests;
