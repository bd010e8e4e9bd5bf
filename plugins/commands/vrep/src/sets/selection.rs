//! Commands on the selection. It is not displayed, but scripts use it to share a set of objects.

use crate::{kit::*, lookup::sets, state::state};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        both(["sim.getObjectSelection", "simGetObjectSelection"], NIL, |c| {
            let selected = selected(c)?;
            if !selected.is_empty() {
                c.ret(&selected[..]);
            }
            Ok(())
        })
        .returns(Param::list("objects").text("no value if no object is selected"))
        .text("Lists the selected objects."),
    );
    offer.command(
        Cmd::new("sim.getObjectSel", |c| {
            let selected = selected(c)?;
            c.ret(&selected[..]);
            Ok(())
        })
        .returns(Param::list("objects").text("empty if no object is selected"))
        .text("Lists the selected objects."),
    );
    offer.command(
        Cmd::new("sim.setObjectSel", |c| {
            let ids = sets::list(c, 0)?;
            state(c)?.sets.selection = ids;
            Ok(())
        })
        .alias("sim.setObjectSelection")
        .param(Param::list("objects").text("handles"))
        .text("Selects the given objects and deselects all others."),
    );
    for (names, add) in [
        (["sim.addObjectToSelection", "simAddObjectToSelection"], true),
        (["sim.removeObjectFromSelection", "simRemoveObjectFromSelection"], false),
    ] {
        let command = both(names, MINUS_ONE, move |c| {
            let ids = objects_of_arguments(c)?;
            let selection = &mut state(c)?.sets.selection;
            selection.retain(|s| !ids.contains(s));
            if add {
                selection.extend(ids);
            }
            c.ret(1_i64);
            Ok(())
        });
        offer.command(
            command
                .param(
                    Param::any("what")
                        .optional()
                        .text("sim.handle_single, _all, _tree or _chain; or a table of handles; nil: nothing"),
                )
                .param(Param::any("object").optional().text("the object to which `_tree` or `_chain` refers"))
                .returns(Param::int("done"))
                .text(if add { "Adds objects to the selection." } else { "Removes objects from the selection." }),
        );
    }
    offer.command(
        both(["sim.isObjectInSelection", "simIsObjectInSelection"], MINUS_ONE, |c| {
            let id = existing_object(c, 0)?.id;
            let inside = state(c)?.sets.selection.contains(&id);
            c.ret(i64::from(inside));
            Ok(())
        })
        .param(object("object"))
        .returns(Param::int("state").text("1 or 0"))
        .text("Returns whether an object is selected."),
    );
}

fn selected(c: &Ctx<'_>) -> Result<Vec<i64>> {
    let all = state(c)?.sets.selection.clone();
    Ok(all.into_iter().filter(|id| c.world().look(*id).is_ok()).map(handle).collect())
}

fn objects_of_arguments(c: &Ctx<'_>) -> Result<Vec<tatu_object>> {
    if is_table(c.arg(0)) {
        return sets::list(c, 0);
    }
    // `getObjectSelection` returns nil for an empty selection, and scripts pass this value back.
    if c.arg(0).is_nil() {
        return Ok(Vec::new());
    }
    sets::selected_objects(c, c.i64(0)?, 1)
}
