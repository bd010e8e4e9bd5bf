//! Commands on the names of objects: unique names with a suffix, and aliases.

use crate::{kit::*, lookup::names, state::state};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.getObjectName", get_name)
            .old_name("simGetObjectName", NIL)
            .param(flagged("object"))
            .returns(Param::string("name"))
            .text("Returns the unique name of an object, with its suffix: `motor#2`.")
            .example("name = sim.getObjectName(robot)"),
    );
    offer.command(
        Cmd::new("sim.setObjectName", set_name)
            .old_name("simSetObjectName", MINUS_ONE)
            .param(flagged("object"))
            .param(Param::string("name").text("letters, digits, _ ( ) and one #; must not be in use by another object"))
            .returns(Param::int("done"))
            .text("Sets the unique name of an object.")
            .example("sim.setObjectName(robot, 'scout')"),
    );
    offer.command(
        Cmd::new("sim.getObjectAlias", get_alias)
            .param(object("object"))
            .param(Param::int("options").default(-1).optional().text(
                "-1: the alias, 0: with its index, 1, 2 and 5: the path, 3: with the handle \
                 if the alias is not unique, 4: with the handle, 6: \"/alias{index}\"",
            ))
            .returns(Param::string("alias"))
            .text("Returns the alias of an object, or another form of its name.")
            .example("path = sim.getObjectAlias(robot, 1)"),
    );
    offer.command(
        Cmd::new("sim.setObjectAlias", set_alias)
            .param(object("object"))
            .param(Param::string("alias").text("letters, digits, _ ( ) -; others become _"))
            .text("Sets the alias of an object, which need not be unique.")
            .example("sim.setObjectAlias(robot, 'scout')"),
    );
    offer.command(
        Cmd::new("sim.getNameSuffix", get_suffix)
            .old_name("simGetNameSuffix", MINUS_ONE)
            .param(Param::string("name").optional().text("nil: the suffix of the calling script"))
            .returns(Param::int("suffix").text("-1: none"))
            .returns(Param::string("name").text("without the suffix, if a name was given"))
            .text("Returns the number after the # of a name, or the suffix that lookups of this script append.")
            .example("n, name = sim.getNameSuffix('motor#2')"),
    );
    offer.command(
        Cmd::new("sim.setNameSuffix", |c| {
            let suffix = c.i64(0)?.max(-1);
            let script = c.caller_script();
            state(c)?.script_values.suffixes.insert(script, suffix);
            c.ret(1_i64);
            Ok(())
        })
        .old_name("simSetNameSuffix", MINUS_ONE)
        .param(Param::int("suffix").text("-1: names are used unchanged"))
        .returns(Param::int("done"))
        .text("Sets the suffix that later lookups of this script append to names.")
        .example("sim.setNameSuffix(-1)"),
    );
}

fn get_name(c: &mut Ctx<'_>) -> Result {
    let name = text_of(c, id(c, 0)?, c.plugin().p.name)?;
    c.ret(name.as_str());
    Ok(())
}

fn set_name(c: &mut Ctx<'_>) -> Result {
    let (id, name) = (id(c, 0)?, c.text(1)?);
    let (base, suffix) = names::split(&name);
    let legal = |b: u8| b.is_ascii_alphanumeric() || b"_()".contains(&b);
    if base.is_empty() || base.len() > 127 || !base.bytes().all(legal) {
        return Err(Fail::argument(format!("`{name}` is not a valid name for an object"))
            .help("names consist of letters, digits, `_`, `(` and `)`, and can end in `#` and a number"));
    }
    if suffix >= 0 && name != format!("{base}#{suffix}") {
        return Err(Fail::argument(format!("`{name}`: the number after `#` must not have a leading zero")));
    }
    let set = c.world().set(id, c.plugin().p.name, &Value::text(&name));
    set.map_err(|e| explain_any(c, id, e))?;
    finish_setter(c)
}

fn get_alias(c: &mut Ctx<'_>) -> Result {
    let (o, p) = (existing_object(c, 0)?, &c.plugin().p);
    let alias = text_of(c, o.id, p.alias)?;
    let text = match int_or(c, 1, -1)? {
        -1 => alias,
        0 => {
            let path = path(c, o.id);
            path.rsplit('/').next().unwrap_or_default().to_owned()
        }
        1 | 2 | 5 => path(c, o.id),
        3 if same_alias(c, &alias)?.len() < 2 => alias,
        3 | 4 => format!("{alias}__{}__", o.handle()),
        6 => {
            let same = same_alias(c, &alias)?;
            let index = same.iter().position(|s| *s == o.id).unwrap_or(0);
            format!("/{alias}{{{index}}}")
        }
        n => {
            return Err(Fail::unsupported(format!("argument 2: expected an alias option from -1 to 6, found {n}")));
        }
    };
    c.ret(text.as_str());
    Ok(())
}

/// Returns all objects with the given alias.
fn same_alias(c: &Ctx<'_>, alias: &str) -> Result<Vec<tatu_object>> {
    let mut all = c.world().list(0, 0, 0)?;
    all.retain(|o| text_of(c, *o, c.plugin().p.alias).is_ok_and(|a| a == alias));
    Ok(all)
}

fn set_alias(c: &mut Ctx<'_>) -> Result {
    let (id, alias) = (id(c, 0)?, c.text(1)?);
    let alias: String =
        alias.chars().map(|x| if x.is_alphanumeric() || "_()-".contains(x) { x } else { '_' }).collect();
    if !alias.is_empty() {
        let set = c.world().set(id, c.plugin().p.alias, &Value::text(&alias));
        set.map_err(|e| explain_any(c, id, e))?;
    }
    Ok(())
}

fn get_suffix(c: &mut Ctx<'_>) -> Result {
    if c.has(0) {
        let text = c.text(0)?;
        let (name, suffix) = names::split(&text);
        c.ret(suffix);
        c.ret(name);
    } else {
        let suffix = names::suffix(c)?;
        c.ret(suffix);
    }
    Ok(())
}
