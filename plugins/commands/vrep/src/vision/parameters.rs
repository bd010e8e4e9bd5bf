//! Parameters of vision sensors by number: planes, resolution, angle. They are properties of the sensor's kind, by the
//! keys that cameras have: near, far, columns, rows, perspective_angle, ortho_size.

use super::{
    sensors::{is_one, number, prop},
    view::View,
};
use crate::kit::*;

/// What scripts of a sensor are given about it (`sysCall_vision`: tests/facts/script-api.md, 4).
pub(super) fn described(c: &Ctx<'_>, view: &View) -> Result<Value> {
    let get = |key| number(c, view.id, key).unwrap_or(0.0);
    let entries = [
        ("handle", Value::Int(handle(view.id))),
        ("resolution", Value::Ints(vec![view.columns as i64, view.rows as i64])),
        ("clippingPlanes", Value::Floats(view.planes.to_vec())),
        ("viewAngle", Value::Float(get("perspective_angle"))),
        ("orthoSize", Value::Float(get("ortho_size"))),
        ("perspectiveOperation", Value::Bool(get("ortho_size") == 0.0)),
    ];
    Ok(Value::Map(entries.map(|(k, v)| (Value::text(k), v)).into()))
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
