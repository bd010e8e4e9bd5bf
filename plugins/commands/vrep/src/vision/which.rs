//! Which objects are vision sensors.

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
