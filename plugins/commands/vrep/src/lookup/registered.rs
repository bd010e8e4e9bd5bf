//! Finds collision objects and other entities that a scene registers by name. In runs without a scene, missing entities
//! have substitute handles.

use super::names;
use crate::kit::*;

/// The lowest handle that stands for a missing entity in a run without a scene.
const FIRST_STAND_IN: i64 = 0x8_0000;

/// Returns whether a number is the substitute handle of a missing entity.
pub(crate) fn is_stand_in(c: &Ctx<'_>, handle: i64) -> bool {
    (FIRST_STAND_IN..=FIRST_STAND_IN + 0xFFFF).contains(&handle) && c.world().makes_stand_ins()
}

/// Returns the handle registered under a name, to which the suffix of the calling script is appended.
pub(crate) fn by_name<'a>(
    c: &Ctx<'_>,
    name: &str,
    all: impl Iterator<Item = (&'a str, i64)> + Clone,
) -> Result<Option<i64>> {
    let name = name.split('@').next().unwrap_or(name);
    let wanted = names::adjust_suffix(name, names::suffix(c)?);
    Ok(all.clone().find(|(n, _)| *n == wanted).map(|(_, h)| h))
}

/// Returns the result of a lookup to the script, or an error if nothing was found. In a run without a scene, a missing
/// entity yields a handle that does not refer to an object and is the same in each run.
pub(crate) fn return_handle(c: &mut Ctx<'_>, name: &str, what: &str, found: Option<i64>) -> Result {
    match found {
        Some(found) => c.ret(found),
        None if c.world().makes_stand_ins() && !name.contains("@silentError") => {
            let sum = name.bytes().fold(0_i64, |sum, b| (31 * sum + i64::from(b)) & 0xFFFF);
            c.ret(FIRST_STAND_IN + sum);
        }
        None => return Err(Fail::missing(format!("there is no {what} `{name}`"))),
    }
    Ok(())
}
