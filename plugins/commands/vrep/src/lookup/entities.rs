//! Resolves handles of collections, and the arguments that select the objects among which a command searches.

use super::sets;
use crate::{
    kit::*,
    state::{collections::FIRST_HANDLE, state},
};

/// Builds the error for a missing collection.
pub(crate) fn missing_collection(which: i64) -> Fail {
    Fail::missing(format!("there is no collection {which}"))
}

/// Returns the objects of a collection without duplicates, in the order in which they were added.
pub(crate) fn objects(c: &Ctx<'_>, which: i64) -> Result<Vec<tatu_object>> {
    let collection = state(c)?.sets.collections.all.get(&which).cloned().ok_or_else(|| missing_collection(which))?;
    let w = c.world();
    let mut out: Vec<tatu_object> = Vec::new();
    for part in &collection.parts {
        if part.object != 0 && w.look(part.object).is_err() {
            continue;
        }
        let mut meant = match part.what {
            HANDLE_ALL => w.list(0, 0, 0)?,
            -6 => w.list(part.object, 0, 0)?,
            -7 => sets::chain(c, part.object)?,
            _ => vec![part.object],
        };
        if part.exclude {
            meant.retain(|o| *o != part.object);
        }
        out.retain(|o| !meant.contains(o));
        if !part.remove {
            out.extend(meant);
        }
    }
    Ok(out)
}

/// Returns whether a number is the handle of a collection.
pub(crate) fn is_collection(c: &Ctx<'_>, which: i64) -> Result<bool> {
    Ok(which > FIRST_HANDLE && state(c)?.sets.collections.all.contains_key(&which))
}

/// The objects among which a command searches: the whole scene, or a list.
pub(crate) enum Entity {
    All,
    Objects(Vec<tatu_object>),
}

impl Entity {
    /// Converts the entity to a list of objects.
    pub(crate) fn list(self, c: &Ctx<'_>) -> Result<Vec<tatu_object>> {
        match self {
            Entity::All => c.world().list(0, 0, 0),
            Entity::Objects(all) => Ok(all),
        }
    }
}

/// Resolves argument `i`: the handle of an object or a collection, or `sim.handle_all`.
pub(crate) fn entity(c: &Ctx<'_>, i: usize) -> Result<Entity> {
    Ok(match c.i64(i)? {
        HANDLE_ALL => Entity::All,
        which if is_collection(c, which)? => Entity::Objects(objects(c, which)?),
        _ => Entity::Objects(vec![existing_object(c, i)?.id]),
    })
}
