//! Parameters of vision sensors by number: planes, resolution, angle. They are properties of the sensor's kind, by the
//! keys that cameras have: near, far, columns, rows, perspective_angle, ortho_size.

use super::which::is_one;
use crate::kit::*;

/// The planes of a sensor that names none, m: those of the original's Kinect.
pub(crate) const PLANES: [f64; 2] = [0.01, 3.5];

/// The property of a key of a sensor's kind.
fn prop(c: &Ctx<'_>, sensor: tatu_object, key: &str) -> Result<Prop> {
    let kind = text_of(c, sensor, c.plugin().p.sensor_kind)?;
    Ok(c.world().host().prop(&format!("{kind}.{key}")))
}

/// A number of a sensor's kind, if it has it.
pub(super) fn number(c: &Ctx<'_>, sensor: tatu_object, key: &str) -> Option<f64> {
    c.world().get(sensor, prop(c, sensor, key).ok()?).ok()?.as_f64()
}

/// Near and far plane, m.
pub(super) fn planes(c: &Ctx<'_>, sensor: tatu_object) -> [f64; 2] {
    let one = |key, i: usize| number(c, sensor, key).unwrap_or(PLANES[i]);
    [one("near", 0), one("far", 1)]
}

/// The angle between the edges of its longer side, rad.
pub(super) fn angle(c: &Ctx<'_>, sensor: tatu_object) -> f64 {
    number(c, sensor, "perspective_angle").unwrap_or(1.0)
}

const FLOATS: &[(i64, &str)] = &[(1000, "near"), (1001, "far"), (1004, "perspective_angle"), (1005, "ortho_size")];
const INTS: &[(i64, &str)] = &[(1002, "columns"), (1003, "rows")];

fn key(of: &[(i64, &'static str)], n: i64) -> Option<&'static str> {
    of.iter().find(|(k, _)| *k == n).map(|(_, key)| *key)
}

/// An integer parameter of a vision sensor; `None`: it has none of this number.
pub(crate) fn get_int(c: &Ctx<'_>, sensor: tatu_object, n: i64) -> Option<i64> {
    if !(1000..=1021).contains(&n) || !is_one(c, sensor) {
        return None;
    }
    match n {
        // The way of drawing; what is drawn: all; a perspective; colours and depths are taken.
        1017 => Some(0),
        1008 => Some(-1),
        1018 => number(c, sensor, "ortho_size").map(|x| i64::from(x == 0.0)),
        1020 | 1021 => Some(0),
        _ => number(c, sensor, key(INTS, n)?).map(|x| x as i64),
    }
}

/// Sets one; whether it could.
pub(crate) fn set_int(c: &Ctx<'_>, sensor: tatu_object, n: i64, value: i64) -> Result<bool> {
    if !(1000..=1021).contains(&n) || !is_one(c, sensor) {
        return Ok(false);
    }
    match key(INTS, n) {
        Some(key) => c.world().set(sensor, prop(c, sensor, key)?, &Value::Int(value))?,
        // What it is already.
        None => return Ok(get_int(c, sensor, n) == Some(value)),
    }
    Ok(true)
}

/// Likewise of numbers.
pub(crate) fn get_float(c: &Ctx<'_>, sensor: tatu_object, n: i64) -> Option<f64> {
    let key = key(FLOATS, n)?;
    if is_one(c, sensor) { number(c, sensor, key) } else { None }
}

/// Likewise of numbers.
pub(crate) fn set_float(c: &Ctx<'_>, sensor: tatu_object, n: i64, value: f64) -> Result<bool> {
    let Some(key) = key(FLOATS, n).filter(|_| is_one(c, sensor)) else { return Ok(false) };
    c.world().set(sensor, prop(c, sensor, key)?, &Value::Float(value))?;
    Ok(true)
}
