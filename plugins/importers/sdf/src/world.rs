//! Reads what concerns the whole world: gravity, time step, place on Earth, lights.

use nalgebra::{Isometry3, Vector3};
use tatu_importers_robots::{Element, FindingKind, Findings, alias, set_object_pose};
use tatu_plugin_api::safe::{Builder, Node, Result};

use crate::shapes::turn_z_to;

/// Gravity of a world that states none, m/s^2.
const DEFAULT_GRAVITY: [f64; 3] = [0.0, 0.0, -9.8];
/// Largest distance of a world from the surface of Earth, m.
const MAX_ELEVATION: f64 = 1e7;
/// Range of time steps that are taken over, s.
const STEPS: std::ops::Range<f64> = 1e-4..0.005;

/// Sets what applies to the whole scene if the file is opened as one.
pub fn set_world(builder: &Builder<'_>, world: Option<&Element>, findings: &Findings) -> Result {
    // The smaller friction of a pair applies in Gazebo.
    builder.setting("scene.friction_rule", "least")?;
    let Some(world) = world else { return Ok(()) };
    builder.setting("scene.gravity", world.numbers("gravity")?.unwrap_or(DEFAULT_GRAVITY))?;
    let step = world.child("physics").map(|physics| physics.finite("max_step_size")).transpose()?.flatten();
    if let Some(step) = step.filter(|dt| STEPS.contains(dt)) {
        builder.setting("scene.physics_dt", step)?;
    }
    if let Some(place) = world.child("spherical_coordinates") {
        let degrees = |name: &str| place.finite(name).map(|x| x.unwrap_or(0.0) * std::f64::consts::PI / 180.0);
        let (latitude, longitude) = (degrees("latitude_deg")?, degrees("longitude_deg")?);
        if degrees("heading_deg")? != 0.0 {
            let text = "the world is turned against east and north, which is left out".to_owned();
            findings.warn(FindingKind::World, place.line, text);
        }
        let (high, wide) = (std::f64::consts::FRAC_PI_2, std::f64::consts::PI);
        let elevation = place.finite("elevation")?.unwrap_or(0.0);
        if latitude.abs() > high || longitude.abs() > wide || elevation.abs() > MAX_ELEVATION {
            return Err(place.fail("<spherical_coordinates> is not a place on Earth"));
        }
        builder.setting("scene.origin.lat", latitude)?;
        builder.setting("scene.origin.lon", longitude)?;
        builder.setting("scene.origin.alt", elevation)?;
    }
    Ok(())
}

/// Builds a light whose pose below `parent` is `pose`.
pub fn light<'b>(builder: &Builder<'b>, tag: &Element, parent: Node<'b>, pose: &Isometry3<f64>) -> Result {
    let form = match tag.attribute("type").unwrap_or("point") {
        "directional" => "directional",
        "spot" => "spot",
        _ => "omni",
    };
    let direction = Vector3::from(tag.numbers("direction")?.unwrap_or([0.0, 0.0, -1.0]));
    let turn = direction.try_normalize(1e-9).map_or(Isometry3::identity(), |d| turn_z_to(&d));
    let name = if tag.label().is_empty() { "light" } else { tag.label() };
    let node = builder.object("light", Some(parent), &alias(name))?;
    set_object_pose(node, &if form == "omni" { *pose } else { pose * turn })?;
    let intensity = tag.finite("intensity")?.unwrap_or(1.0);
    let diffuse = match tag.child("diffuse") {
        Some(color) => color.own_numbers().or_else(|_| color.own_numbers::<3>().map(|[r, g, b]| [r, g, b, 1.0]))?,
        None => [1.0; 4],
    };
    let [r, g, b, _]: [f64; 4] = diffuse.map(|x| (x * intensity).clamp(0.0, 1.0));
    node.set("light.form", form)?.set("light.color", [r, g, b])?;
    if tag.flag("light_on") == Some(false) {
        node.set("light.on", false)?;
    }
    if let (Some(spot), "spot") = (tag.child("spot"), form) {
        // The file states the whole angle of the cone, the scene half of it.
        let angle = spot.finite("outer_angle")?.unwrap_or(1.0) / 2.0;
        node.set("light.angle", angle.clamp(0.01, std::f64::consts::FRAC_PI_2))?;
    }
    Ok(())
}
