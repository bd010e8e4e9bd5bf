//! The entity that a sensor detects: an object, the objects of a collection, or everything
//! (`sim.proxintparam_entity_to_detect`, `sim.visionintparam_entity_to_render`).
//!
//! The core stores a list of paths (`sensor.targets`); the handle that the script passed is stored with the sensor. A
//! collection is resolved when the entity is set, so later changes to the collection have no effect.

use std::collections::BTreeSet;

use crate::{
    kit::{tags, *},
    lookup::entities,
};

/// Tag under which the entity's handle is stored.
const ENTITY_TAG: &str = "entity";
/// The handle that selects all objects.
const ALL_OBJECTS: i64 = -1;

/// Returns the handle of the entity that a sensor detects.
pub(super) fn get(c: &Ctx<'_>, sensor: tatu_object) -> Result<i64> {
    Ok(tags::number(c, sensor, ENTITY_TAG)?.map_or(ALL_OBJECTS, |x| x as i64))
}

/// Sets the entity that a sensor detects.
pub(super) fn set(c: &Ctx<'_>, sensor: tatu_object, entity: i64) -> Result {
    let (w, p) = (c.world(), &c.plugin().p);
    let objects = w.list(0, 0, 0)?;
    let seen: BTreeSet<tatu_object> = match entity {
        ALL_OBJECTS => objects.iter().copied().collect(),
        _ if entities::is_collection(c, entity)? => entities::objects(c, entity)?.into_iter().collect(),
        _ => BTreeSet::from([existing_object(c, 2)?.id]),
    };
    // Objects that are added later are detected if most of the existing ones are.
    let mut all = 2 * seen.len() > objects.len() || entity == ALL_OBJECTS;
    let mut lists = differences(c, &objects, &seen, all)?;
    if all && !lists.0.is_empty() {
        // If any object is listed as a target, the core does not detect unlisted objects.
        all = false;
        lists = differences(c, &objects, &seen, all)?;
    }
    let (mut targets, ignored) = lists;
    if targets.is_empty() && !all {
        // An empty list would mean all objects, so list only the sensor itself, which it never detects.
        targets.push(sensor);
    }
    let paths = |all: &[tatu_object]| Value::List(all.iter().map(|o| Value::text(path(c, *o))).collect());
    w.set(sensor, p.sensor_targets, &paths(&targets))?;
    w.set(sensor, p.sensor_ignored, &paths(&ignored))?;
    tags::set_number(c, sensor, ENTITY_TAG, entity as f64)
}

/// Returns the objects that are detected although their parent is not, and those that are not detected although their
/// parent is. `world` states whether the parent of root objects counts as detected.
fn differences(
    c: &Ctx<'_>,
    objects: &[tatu_object],
    seen: &BTreeSet<tatu_object>,
    world: bool,
) -> Result<(Vec<tatu_object>, Vec<tatu_object>)> {
    let (mut targets, mut ignored) = (Vec::new(), Vec::new());
    for o in objects {
        let above = match parent(c, *o)? {
            0 => world,
            up => seen.contains(&up),
        };
        match (seen.contains(o), above) {
            (true, false) => targets.push(*o),
            (false, true) => ignored.push(*o),
            _ => {}
        }
    }
    Ok((targets, ignored))
}
