//! Builds cameras, lights and paths.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_3};

use tatu_plugin_api::safe::{Node, Result, Value};

use crate::read::{
    others::{Camera, Light, Path},
    pose::isometry,
};

/// Sets the properties of a camera; invalid values are replaced by defaults.
pub fn camera(k: &Camera, node: Node<'_>) -> Result {
    let [side, angle] = k.size_and_angle;
    let perspective = k.perspective.map_or(k.bits & 2 != 0, |p| p != 0);
    let known = |x: f64| x.is_finite() && x > 0.0;
    if known(angle) && angle < 3.1 {
        node.set("camera.angle", angle)?;
    }
    if !perspective && known(side) {
        node.set("camera.ortho_size", side)?;
    }
    if known(k.clip[0]) && known(k.clip[1]) {
        node.set("camera.near", k.clip[0])?.set("camera.far", k.clip[1])?;
    }
    Ok(())
}

/// Sets the properties of a light.
pub fn light(l: &Light, node: Node<'_>) -> Result {
    let form = match l.kind {
        2 => "spot",
        3 => "directional",
        _ => "omni",
    };
    node.set("light.form", form)?.set("light.on", l.bits & 1 != 0)?;
    if let Some(color) = &l.color {
        node.set("light.color", color.light)?;
    }
    let angle = if l.angle.is_finite() { l.angle.clamp(0.01, FRAC_PI_2) } else { FRAC_PI_3 };
    if form == "spot" {
        node.set("light.angle", angle)?;
    }
    Ok(())
}

/// Bit of a path's attributes that closes the path.
const CLOSED: i32 = 4;

/// Builds a path: its control points, and the rounding of its corners.
pub fn path(p: &Path, node: Node<'_>) -> Result {
    let mut points = Vec::with_capacity(p.points.len() * 7);
    let mut rounding = Vec::with_capacity(p.points.len() * 3);
    for point in &p.points {
        let pose = isometry(&point.pose);
        let q = pose.rotation.coords;
        points.extend(pose.translation.vector.iter().chain(q.iter()).copied());
        // An assumption: the fractions refer to half the distance to the next point. Otherwise, neighbouring values of
        // 0.95, which occur in files, would overlap.
        let ([before, after], places) = point.bezier;
        let share = |x: f64| if x.is_finite() { x.clamp(0.0, 1.0) } else { 0.0 };
        rounding.extend([share(before), share(after), f64::from(places.clamp(1, 1000))]);
    }
    node.set("path.points", Value::Floats(points))?.set("path.closed", p.attributes & CLOSED != 0)?;
    if rounding.chunks(3).any(|r| r[2] > 1.0) {
        node.set("path.rounding", Value::Floats(rounding))?;
    }
    Ok(())
}
