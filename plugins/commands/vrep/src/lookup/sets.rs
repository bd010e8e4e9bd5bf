//! Resolves sets of objects: lists of handles, and `sim.handle_single`, `_all`, `_tree` and `_chain`.

use crate::kit::*;

/// Returns the objects in argument `i`, a table of handles.
pub(crate) fn list(c: &Ctx<'_>, i: usize) -> Result<Vec<tatu_object>> {
    let v = c.arg(i);
    (0..v.len())
        .map(|k| {
            let n = v.number(k).unwrap_or(-1.0) as i64;
            let id = u64::try_from(n & HANDLE_BITS).unwrap_or(0);
            match c.world().look(id) {
                Ok(o) if n > 0 => Ok(o.id),
                _ => Err(Fail::missing(format!("element {}: there is no object {n}", k + 1))),
            }
        })
        .collect()
}

/// Returns the objects that `what` selects, relative to the object of argument `i`.
pub(crate) fn selected_objects(c: &Ctx<'_>, what: i64, i: usize) -> Result<Vec<tatu_object>> {
    let w = c.world();
    Ok(match what {
        HANDLE_ALL => w.list(0, 0, 0)?,
        -8 => vec![existing_object(c, i)?.id],
        -6 => w.list(existing_object(c, i)?.id, 0, 0)?,
        -7 => chain(c, existing_object(c, i)?.id)?,
        n => {
            return Err(Fail::argument(format!("{n} is not a valid selection of objects"))
                .help("use sim.handle_single, sim.handle_all, sim.handle_tree or sim.handle_chain"));
        }
    })
}

/// Returns an object and all its ancestors.
pub(crate) fn chain(c: &Ctx<'_>, id: tatu_object) -> Result<Vec<tatu_object>> {
    let mut out = vec![id];
    while let Some(up) = out.last().copied() {
        match parent(c, up)? {
            0 => break,
            next => out.push(next),
        }
    }
    Ok(out)
}
