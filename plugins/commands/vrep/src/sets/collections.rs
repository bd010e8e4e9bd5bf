//! Commands on collections, which are sets of objects with a common handle.

use crate::{
    kit::*,
    lookup::entities::{missing_collection, objects},
    state::{
        collections::{Collection, CollectionPart, Collections},
        state,
    },
};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let collection = || Param::int("collection").text("a handle of a collection");
    offer.command(
        both(["sim.createCollection", "simCreateCollection"], MINUS_ONE, |c| {
            // Before 4.2, the first argument was the name.
            let name = c.arg(0).as_str().map_or(String::new(), |s| s.into_owned());
            let made = state(c)?.sets.collections.add(name);
            c.ret(made);
            Ok(())
        })
        .param(Param::any("options").optional().text("ignored; in old scripts, the name"))
        .param(Param::any("oldOptions").optional().text("ignored"))
        .returns(Param::int("collection"))
        .text("Creates a collection of objects."),
    );
    // In the older command, the object precedes `sim.handle_tree` and similar numbers; in the newer one, it follows.
    for (name, old, at) in [
        ("sim.addObjectToCollection", Some("simAddObjectToCollection"), [1, 2]),
        ("sim.addItemToCollection", None, [2, 1]),
    ] {
        let command = move |c: &mut Ctx<'_>| {
            let (which, what, options) = (c.i64(0)?, c.i64(at[1])?, int_or(c, 3, 0)?);
            let object = if what == HANDLE_ALL { 0 } else { existing_object(c, at[0])?.id };
            let part = CollectionPart { what, object, remove: options & 1 != 0, exclude: options & 2 != 0 };
            change(c, which, |collection| collection.parts.push(part))?;
            finish_setter(c)
        };
        let command = Cmd::new(name, command);
        let command = old.into_iter().fold(command, |command, old| command.old_name(old, MINUS_ONE));
        let (first, second) = if at[0] == 1 { ("object", "what") } else { ("what", "object") };
        let param = |key: &str| match key {
            "what" => Param::int(key).text("sim.handle_single, _all, _tree or _chain"),
            _ => Param::int(key),
        };
        offer.command(
            command
                .param(collection())
                .param(param(first))
                .param(param(second))
                .param(Param::int("options").default(0).optional().text("1: removes, 2: excludes the object itself"))
                .text("Adds objects to a collection, or removes them."),
        );
    }
    for (name, old) in [
        ("sim.removeCollection", Some("simRemoveCollection")),
        ("sim.destroyCollection", None),
        ("sim.emptyCollection", Some("simEmptyCollection")),
    ] {
        let run = move |c: &mut Ctx<'_>| {
            let which = c.i64(0)?;
            if name == "sim.emptyCollection" {
                change(c, which, |collection| collection.parts.clear())?;
            } else if state(c)?.sets.collections.all.remove(&which).is_none() {
                return Err(missing_collection(which));
            }
            finish_setter(c)
        };
        let command = Cmd::new(name, run);
        let command = old.into_iter().fold(command, |command, old| command.old_name(old, MINUS_ONE));
        let text = if name == "sim.emptyCollection" { "Empties a collection." } else { "Removes a collection." };
        offer.command(command.param(collection()).text(text));
    }
    offer.command(
        both(["sim.getCollectionObjects", "simGetCollectionObjects"], NIL, |c| {
            let objects: Vec<i64> = objects(c, c.i64(0)?)?.into_iter().map(handle).collect();
            c.ret(&objects[..]);
            Ok(())
        })
        .param(collection())
        .returns(Param::list("objects"))
        .text("Lists the objects of a collection."),
    );
    offer.command(
        both(["sim.getCollectionHandle", "simGetCollectionHandle"], MINUS_ONE, |c| {
            let name = c.text(0)?;
            let found = state(c)?.sets.collections.all.iter().find(|(_, k)| k.name == name).map(|(h, _)| *h);
            match found {
                Some(h) => c.ret(h),
                // In a run without a scene, an empty collection replaces a missing one.
                None if c.world().makes_stand_ins() => {
                    let made = state(c)?.sets.collections.add(name);
                    c.ret(made);
                }
                None => return Err(Fail::missing(format!("there is no collection `{name}`"))),
            }
            Ok(())
        })
        .param(Param::string("name"))
        .returns(Param::int("collection"))
        .text("Finds a collection by its name."),
    );
    offer.command(
        both(["sim.getCollectionName", "simGetCollectionName"], NIL, |c| {
            let which = c.i64(0)?;
            let name = state(c)?
                .sets
                .collections
                .all
                .get(&which)
                .map(|k| k.name.clone())
                .ok_or_else(|| missing_collection(which))?;
            c.ret(name.as_str());
            Ok(())
        })
        .param(collection())
        .returns(Param::string("name"))
        .text("Returns the name of a collection."),
    );
    offer.command(
        both(["sim.setCollectionName", "simSetCollectionName"], MINUS_ONE, |c| {
            let (which, name) = (c.i64(0)?, c.text(1)?);
            change(c, which, |collection| collection.name = name)?;
            finish_setter(c)
        })
        .param(collection())
        .param(Param::string("name"))
        .text("Sets the name of a collection."),
    );
}

fn change(c: &Ctx<'_>, which: i64, change: impl FnOnce(&mut Collection)) -> Result {
    change_in(&mut state(c)?.sets.collections, which, change)
}

fn change_in(all: &mut Collections, which: i64, change: impl FnOnce(&mut Collection)) -> Result {
    change(all.all.get_mut(&which).ok_or_else(|| missing_collection(which))?);
    Ok(())
}
