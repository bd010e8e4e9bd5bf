//! Determines which objects are vision sensors, and reads their properties.

use crate::kit::*;

/// Returns whether an object is a vision sensor: a sensor whose readings contain depths or colours.
pub(crate) fn is_vision_sensor(c: &SharedCtx<'_>, object: tatu_object) -> bool {
    let p = &c.plugin().p;
    c.world().reading(object, p.depth).is_ok() || c.world().reading(object, p.rgb).is_ok()
}

/// Returns all vision sensors, without duplicates.
pub(super) fn all(c: &Ctx<'_>) -> Result<Vec<tatu_object>> {
    let mut all = c.world().sensors("depth_image/1")?;
    let more = c.world().sensors("color_image/1")?;
    all.extend(more.into_iter().filter(|s| !all.contains(s)).collect::<Vec<_>>());
    Ok(all)
}

/// Default near and far planes, m, which are those of V-REP's Kinect model.
pub(crate) const DEFAULT_PLANES: [f64; 2] = [0.01, 3.5];

/// Returns the property of the sensor's kind with the given key.
pub(super) fn prop(c: &Ctx<'_>, sensor: tatu_object, key: &str) -> Result<Prop> {
    let kind = text_of(c, sensor, c.plugin().p.sensor_kind)?;
    Ok(c.world().host().prop(&format!("{kind}.{key}")))
}

/// Returns a numeric property of the sensor's kind, or `None` if the kind does not have this property.
pub(super) fn number(c: &Ctx<'_>, sensor: tatu_object, key: &str) -> Option<f64> {
    c.world().get(sensor, prop(c, sensor, key).ok()?).ok()?.as_f64()
}

/// Returns the distances of the near and the far plane, m.
pub(super) fn planes(c: &Ctx<'_>, sensor: tatu_object) -> [f64; 2] {
    let one = |key, i: usize| number(c, sensor, key).unwrap_or(DEFAULT_PLANES[i]);
    [one("near", 0), one("far", 1)]
}

/// Returns the field of view along the longer side, rad.
pub(super) fn angle(c: &Ctx<'_>, sensor: tatu_object) -> f64 {
    number(c, sensor, "perspective_angle").unwrap_or(1.0)
}
