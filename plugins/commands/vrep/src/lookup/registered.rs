//! What scenes register beside their objects, by name, and numbers that stand in for it.

use super::names;
use crate::kit::*;

/// From here on lie the handles of collision objects and their like in runs that make stand-ins.
const REGISTERED: i64 = 0x8_0000;

/// Whether a number is one of these.
pub(crate) fn is_stand_in(c: &Ctx<'_>, handle: i64) -> bool {
    (REGISTERED..=REGISTERED + 0xFFFF).contains(&handle) && c.world().makes_stand_ins()
}

/// The handle under a name, by the rule for names of old scripts.
pub(crate) fn by_name<'a>(
    c: &Ctx<'_>,
    name: &str,
    all: impl Iterator<Item = (&'a str, i64)> + Clone,
) -> Result<Option<i64>> {
    let name = name.split('@').next().unwrap_or(name);
    let wanted = names::adjusted(name, names::suffix(c)?);
    Ok(all.clone().find(|(n, _)| *n == wanted).map(|(_, h)| h))
}

/// Answers a search for something registered. A run that makes stand-ins has no scene: it gives a number that names no
/// object, the same in each run.
pub(crate) fn answer_handle(c: &mut Ctx<'_>, name: &str, what: &str, found: Option<i64>) -> Result {
    match found {
        Some(found) => c.ret(found),
        None if c.world().makes_stand_ins() && !name.contains("@silentError") => {
            let sum = name.bytes().fold(0_i64, |sum, b| (31 * sum + i64::from(b)) & 0xFFFF);
            c.ret(REGISTERED + sum);
        }
        None => return Err(Fail::missing(format!("there is no {what} `{name}`"))),
    }
    Ok(())
}
