//! Commands on handles and types of objects.

use crate::{kit::*, lookup::names};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.getObjectHandle", get_handle)
            .old_name("simGetObjectHandle", MINUS_ONE)
            .param(Param::any("name").text(
                "a unique name, a path, or sim.handle_self; in a script of `robot#2`, `motor` means `motor#2`, and \
                 `motor#` exactly `motor`; with `@silentError` appended, -1 is returned if the object is missing",
            ))
            .param(Param::any("options").optional().text("{noError=true}: -1 if the object is missing"))
            .returns(Param::int("handle"))
            .text("Finds an object by its unique name.")
            .example("motor = sim.getObjectHandle('Pioneer_p3dx_leftMotor')"),
    );
    offer.command(
        Cmd::new("sim.getObject", get_object)
            .param(Param::string("path").text("\"/a/b[1]\", \"./b\", \"../b\", \":/b\", \"/b{2}\""))
            .param(Param::any("options").optional().text(
                "{noError=true}: -1 if the object is missing; index: zero-based index of the match; \
                    proxy: the start of a relative path",
            ))
            .returns(Param::int("handle"))
            .text("Finds an object by its path.")
            .example("motor = sim.getObject('../leftMotor')"),
    );
    offer.command(
        Cmd::new("sim.getObjectHandle_noErrorNoSuffixAdjustment", |c| {
            let name = c.text(0)?;
            let found = c.world().find(0, name.trim_end_matches('#'));
            c.ret(found.map_or(-1, handle));
            Ok(())
        })
        .old_name("simGetObjectHandle_noErrorNoSuffixAdjustment", MINUS_ONE)
        .param(Param::string("name").text("a unique name"))
        .returns(Param::int("handle"))
        .text("Finds an object by its exact unique name; returns -1 if there is none.")
        .example("h = sim.getObjectHandle_noErrorNoSuffixAdjustment('Cuboid#0')"),
    );
    offer.command(
        Cmd::side_by_side("sim.getObjectType", |c| {
            let o = existing_object(c, 0)?;
            let kind = type_of(c, o);
            c.ret(kind);
            Ok(())
        })
        .old_name("simGetObjectType", MINUS_ONE)
        .param(object("object"))
        .returns(Param::int("type").text("sim.object_..._type; -1 for objects that V-REP does not have"))
        .text("Returns the type of an object.")
        .example("isShape = sim.getObjectType(h) == sim.object_shape_type"),
    );
    offer.command(
        Cmd::new("sim.isHandle", |c| {
            let there = exists(c);
            c.ret(there);
            Ok(())
        })
        .param(Param::any("handle"))
        .returns(Param::bool("there"))
        .text("Returns whether a number is the handle of an object.")
        .example("if sim.isHandle(h) then sim.removeObjects({h}) end"),
    );
    offer.command(
        Cmd::side_by_side("sim.isHandleValid", |c| {
            let there = exists(c);
            c.ret(i64::from(there));
            Ok(())
        })
        .old_name("simIsHandleValid", MINUS_ONE)
        .param(Param::any("handle"))
        .param(Param::int("type").default(-1).optional().text("ignored: all handles belong to objects"))
        .returns(Param::int("valid").text("1 or 0"))
        .text("Returns whether a number is the handle of an object, as 1 or 0.")
        .example("if sim.isHandleValid(h) == 1 then sim.removeObject(h) end"),
    );
    offer.command(
        Cmd::new("sim.getObjectUid", |c| {
            let o = existing_object(c, 0)?;
            c.ret(o.id as i64);
            Ok(())
        })
        .alias("sim.getObjectUniqueIdentifier")
        .old_name("simGetObjectUniqueIdentifier", MINUS_ONE)
        .param(object("object"))
        .returns(Param::int("uid"))
        .text("Returns a number that identifies an object uniquely during the whole run.")
        .example("uid = sim.getObjectUid(robot)"),
    );
    offer.command(
        Cmd::new("sim.getObjectFromUid", |c| {
            let id = c.i64(0)? as u64;
            let found = c.world().look(id).ok().filter(|o| o.id == id);
            match found {
                Some(o) => c.ret(o.handle()),
                None if no_error(c) => c.ret(-1_i64),
                None => return Err(Fail::missing(format!("there is no object with the unique number {id}"))),
            }
            Ok(())
        })
        .param(Param::int("uid"))
        .param(Param::any("options").optional().text("{noError=true}: -1 if the object is missing"))
        .returns(Param::int("handle"))
        .text("Finds an object by the number that sim.getObjectUid returns."),
    );
}

fn get_handle(c: &mut Ctx<'_>) -> Result {
    if c.arg(0).as_i64() == Some(HANDLE_SELF) {
        c.ret(handle(c.caller_object()));
        return Ok(());
    }
    let v = c.arg(0);
    let text = match v.as_i64() {
        Some(n) => n.to_string(),
        None => c.text(0)?,
    };
    let (name, mark) = text.split_once('@').unwrap_or((&text, ""));
    if !matches!(mark, "" | "silentError") {
        return Err(Fail::unsupported(format!(
            "`{text}`: alternative names are not supported; only `@silentError` can be appended to a name"
        )));
    }
    let silent = !mark.is_empty() || no_error(c);
    let found = if silent && !names::is_path(name) {
        let name = names::adjust_suffix(name, names::suffix(c)?).into_owned();
        c.world().find(0, &name)
    } else if silent {
        names::find(c, name)
    } else {
        names::find_or_create(c, name)
    };
    answer(c, found, silent)
}

fn get_object(c: &mut Ctx<'_>) -> Result {
    let path = c.text(0)?;
    let options = c.arg(1);
    let (index, proxy) = (options.get("index"), options.get("proxy"));
    let base = match proxy {
        Some(v) if !v.is_nil() => Some(id_of(v, 1)?),
        _ => None,
    };
    let index = index.and_then(|v| v.as_i64()).unwrap_or(0);
    let silent = no_error(c);
    let find = if silent { names::find_path } else { names::find_path_or_create };
    let found = if !names::is_path(&path) {
        Err(Fail::missing(format!("`{path}` is not a path"))
            .help("a path begins with `/`, `.` or `:`; to find an object by unique name, use sim.getObjectHandle"))
    } else if index > 0 {
        find(c, &format!("{path}{{{index}}}"), base)
    } else {
        find(c, &path, base)
    };
    answer(c, found, silent)
}

fn no_error(c: &Ctx<'_>) -> bool {
    c.arg(1).get("noError").is_some_and(|v| v.truthy())
}

fn answer(c: &mut Ctx<'_>, found: Result<tatu_object>, silent: bool) -> Result {
    match found {
        Ok(id) => c.ret(handle(id)),
        Err(e) if silent && e.code() == TATU_ERR_MISSING => c.ret(-1_i64),
        Err(e) => return Err(e),
    }
    Ok(())
}

fn exists(c: &SharedCtx<'_>) -> bool {
    let flags = c.arg(0).as_i64().is_some_and(|n| n > HANDLE_BITS);
    !flags && id(c, 0).is_ok_and(|id| c.world().look(id).is_ok())
}

/// Returns the type number of an object, `sim.object_..._type`.
pub(crate) fn type_of(c: &SharedCtx<'_>, o: Object) -> i64 {
    match o.kind {
        TATU_KIND_SHAPE => 0,
        TATU_KIND_JOINT => 1,
        TATU_KIND_GRAPH => 2,
        TATU_KIND_CAMERA => 3,
        TATU_KIND_DUMMY if crate::paths::objects::is_path(c, o.id) && version(c) < (4, 2) => 8,
        TATU_KIND_DUMMY => 4,
        TATU_KIND_SENSOR if c.world().reading(o.id, c.plugin().p.detected).is_ok() => 5,
        TATU_KIND_SENSOR if crate::vision::sensors::is_vision_sensor(c, o.id) => 9,
        TATU_KIND_PATH => 8,
        TATU_KIND_FORCE_SENSOR => 12,
        TATU_KIND_LIGHT => 13,
        TATU_KIND_SCRIPT => 17,
        _ => -1,
    }
}

/// Returns the bit mask of kinds for a type number, as used by `World::list` (0 means all), or `None` if objects cannot
/// have this type.
pub(crate) fn kinds_of(kind: i64) -> Option<u32> {
    Some(match kind {
        HANDLE_ALL | 109 => 0,
        0 => 1 << TATU_KIND_SHAPE,
        1 => 1 << TATU_KIND_JOINT,
        2 => 1 << TATU_KIND_GRAPH,
        3 => 1 << TATU_KIND_CAMERA,
        4 => 1 << TATU_KIND_DUMMY,
        5 | 9 => 1 << TATU_KIND_SENSOR,
        8 => 1 << TATU_KIND_PATH,
        12 => 1 << TATU_KIND_FORCE_SENSOR,
        13 => 1 << TATU_KIND_LIGHT,
        17 => 1 << TATU_KIND_SCRIPT,
        _ => return None,
    })
}
