//! Which objects are vision sensors, and what their kinds say of them.

use crate::kit::*;

/// Whether an object is a vision sensor.
pub(crate) fn is_one(c: &Shared<'_>, object: tatu_object) -> bool {
    let p = &c.plugin().p;
    c.world().reading(object, p.depth).is_ok() || c.world().reading(object, p.rgb).is_ok()
}

/// All vision sensors, each once.
pub(super) fn all(c: &Ctx<'_>) -> Result<Vec<tatu_object>> {
    let mut all = c.world().sensors("depth_image/1")?;
    let more = c.world().sensors("color_image/1")?;
    all.extend(more.into_iter().filter(|s| !all.contains(s)).collect::<Vec<_>>());
    Ok(all)
}

/// The planes of a sensor that names none, m: those of the original's Kinect.
pub(crate) const PLANES: [f64; 2] = [0.01, 3.5];

/// The property of a key of a sensor's kind.
pub(super) fn prop(c: &Ctx<'_>, sensor: tatu_object, key: &str) -> Result<Prop> {
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
