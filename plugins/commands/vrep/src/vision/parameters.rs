//! Parameters of vision sensors by number: clipping planes, resolution, angle. They are mapped to properties of the
//! sensor's kind, with the keys of cameras: near, far, columns, rows, perspective_angle, ortho_size.

use super::{
    sensors::{is_vision_sensor, number, prop},
    view::VisionView,
};
use crate::kit::{tags, *};

/// Returns the data passed to a sensor's scripts (`sysCall_vision`: tests/facts/script-api.md, 4).
pub(super) fn callback_data(c: &Ctx<'_>, view: &VisionView) -> Result<Value> {
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

const FLOAT_PARAMETERS: &[(i64, &str)] =
    &[(1000, "near"), (1001, "far"), (1004, "perspective_angle"), (1005, "ortho_size")];
const INT_PARAMETERS: &[(i64, &str)] = &[(1002, "columns"), (1003, "rows")];

fn key(of: &[(i64, &'static str)], n: i64) -> Option<&'static str> {
    of.iter().find(|(k, _)| *k == n).map(|(_, key)| *key)
}

/// Number of the integer parameter that selects perspective projection.
const PERSPECTIVE_PARAMETER: i64 = 1018;
/// Number of the float parameter for the side of the image in orthographic projection, m.
const SIDE_PARAMETER: i64 = 1005;
/// Default side of the image in orthographic projection, m.
const DEFAULT_SIDE_M: f64 = 1.0;

/// Returns the default value of a parameter that only affects rendering or windows, and is therefore only stored
/// (tests/facts/script-api.md, 7); `None` for any other parameter.
fn stored_default(n: i64) -> Option<f64> {
    matches!(n, 1006 | 1007 | 1009..=1017 | 1020 | 1021).then_some(0.0)
}

/// Returns the tag under which a parameter is stored.
fn tag(n: i64) -> String {
    format!("parameter {n}")
}

/// Returns an integer parameter of a vision sensor, or `None` if there is no parameter with this number.
pub(crate) fn get_int(c: &Ctx<'_>, sensor: tatu_object, n: i64) -> Result<Option<i64>> {
    if !(1000..=1021).contains(&n) || !is_vision_sensor(c, sensor) {
        return Ok(None);
    }
    let x = match stored_default(n) {
        Some(usual) => Some(tags::number(c, sensor, &tag(n))?.unwrap_or(usual)),
        None if n == PERSPECTIVE_PARAMETER => number(c, sensor, "ortho_size").map(|x| f64::from(u8::from(x == 0.0))),
        None => key(INT_PARAMETERS, n).and_then(|key| number(c, sensor, key)),
    };
    Ok(x.map(|x| x as i64))
}

/// Sets an integer parameter; returns whether the sensor has such a parameter.
pub(crate) fn set_int(c: &Ctx<'_>, sensor: tatu_object, n: i64, value: i64) -> Result<bool> {
    if !(1000..=1021).contains(&n) || !is_vision_sensor(c, sensor) {
        return Ok(false);
    }
    match key(INT_PARAMETERS, n) {
        Some(key) => c.world().set(sensor, prop(c, sensor, key)?, &Value::Int(value))?,
        None if n == PERSPECTIVE_PARAMETER => set_perspective(c, sensor, value != 0)?,
        None if stored_default(n).is_some() => tags::set_number(c, sensor, &tag(n), value as f64)?,
        None => return Ok(false),
    }
    Ok(true)
}

/// Switches between perspective and orthographic projection. The side of the image in orthographic projection is stored
/// while the projection is perspective.
fn set_perspective(c: &Ctx<'_>, sensor: tatu_object, on: bool) -> Result {
    let side = number(c, sensor, "ortho_size").unwrap_or(0.0);
    if on == (side == 0.0) {
        return Ok(());
    }
    let next = match on {
        true => {
            tags::set_number(c, sensor, &tag(SIDE_PARAMETER), side)?;
            0.0
        }
        false => tags::number(c, sensor, &tag(SIDE_PARAMETER))?.unwrap_or(DEFAULT_SIDE_M),
    };
    c.world().set(sensor, prop(c, sensor, "ortho_size")?, &Value::Float(next))
}

/// Returns a float parameter of a vision sensor, or `None` if there is no parameter with this number.
pub(crate) fn get_float(c: &Ctx<'_>, sensor: tatu_object, n: i64) -> Result<Option<f64>> {
    if !is_vision_sensor(c, sensor) {
        return Ok(None);
    }
    if let Some(usual) = stored_default(n) {
        return Ok(Some(tags::number(c, sensor, &tag(n))?.unwrap_or(usual)));
    }
    let x = key(FLOAT_PARAMETERS, n).and_then(|key| number(c, sensor, key));
    match (n, x) {
        (SIDE_PARAMETER, Some(0.0)) => {
            Ok(Some(tags::number(c, sensor, &tag(SIDE_PARAMETER))?.unwrap_or(DEFAULT_SIDE_M)))
        }
        _ => Ok(x),
    }
}

/// Sets a float parameter; returns whether the sensor has such a parameter.
pub(crate) fn set_float(c: &Ctx<'_>, sensor: tatu_object, n: i64, value: f64) -> Result<bool> {
    if !is_vision_sensor(c, sensor) {
        return Ok(false);
    }
    // In perspective projection, the side is only stored, for a later switch to orthographic projection.
    if stored_default(n).is_some() || n == SIDE_PARAMETER && number(c, sensor, "ortho_size") == Some(0.0) {
        tags::set_number(c, sensor, &tag(n), value)?;
        return Ok(true);
    }
    let Some(key) = key(FLOAT_PARAMETERS, n) else { return Ok(false) };
    c.world().set(sensor, prop(c, sensor, key)?, &Value::Float(value))?;
    Ok(true)
}
