//! Custom data: strings, buffers and tables that scripts store with an object, the scene or the application.

use crate::kit::*;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let target = || Param::int("target").text("an object, sim.handle_scene or sim.handle_app");
    let tag = || Param::string("tag").text("any name");
    offer.command(
        both(["sim.writeCustomDataBlock", "simWriteCustomDataBlock"], MINUS_ONE, |c| {
            write(c, c.arg(2).as_bytes().map(<[u8]>::to_vec))?;
            c.ret(1_i64);
            Ok(())
        })
        .param(target())
        .param(Param::string("tag").text("any name; empty: all data is removed"))
        .param(Param::string("data").optional().text("nil or empty: removes the data"))
        .returns(Param::int("done"))
        .text("Stores data with an object, under a tag."),
    );
    for (name, kind) in [("sim.writeCustomStringData", "text"), ("sim.writeCustomBufferData", "bytes")] {
        offer.command(
            Cmd::new(name, |c| write(c, c.arg(2).as_bytes().map(<[u8]>::to_vec)))
                .param(target())
                .param(tag())
                .param(Param::string("data").optional().text("nil or empty: removes the data"))
                .text(format!("Stores {kind} with an object, under a tag.")),
        );
    }
    offer.command(
        both(["sim.readCustomDataBlock", "simReadCustomDataBlock"], NIL, |c| {
            let found = match object_and_tag(c) {
                Ok((id, tag)) => tags::get(c, id, &tag)?,
                // A missing object has no data, which is not an error.
                Err(_) => None,
            };
            match found {
                Some(data) => c.ret(data.as_slice()),
                // In a run without a scene, a neutral block replaces the missing data.
                None if c.world().stands_in(0, &format!("data {}", c.text(1)?)) => c.ret(STAND_IN_DATA),
                None => c.ret(Value::Nil),
            }
            Ok(())
        })
        .param(target())
        .param(tag())
        .returns(Param::string("data").text("nil: there is none"))
        .text("Returns the data stored with an object under a tag."),
    );
    for (name, kind) in [("sim.readCustomStringData", "text"), ("sim.readCustomBufferData", "bytes")] {
        let data = if kind == "text" { Param::string("data") } else { Param::bytes("data") };
        offer.command(
            Cmd::new(name, move |c| {
                let (id, tag) = object_and_tag(c)?;
                let data = tags::get(c, id, &tag)?.unwrap_or_default();
                c.ret(if kind == "text" { Value::Text(data) } else { Value::Bytes(data) });
                Ok(())
            })
            .param(target())
            .param(tag())
            .returns(data.text("empty: there is none"))
            .text(format!("Returns the {kind} stored with an object under a tag.")),
        );
    }
    offer.command(
        Cmd::new("sim.writeCustomTableData", |c| {
            let v = c.arg(2).to_value()?;
            let data = match &v {
                Value::Nil => None,
                Value::List(l) if l.is_empty() => None,
                v => Some(tables::pack(v)?),
            };
            write(c, data)
        })
        .param(target())
        .param(tag())
        .param(Param::any("table").text("nil or empty: removes the data"))
        .param(Param::any("options").optional().text("ignored"))
        .text("Stores a table with an object, under a tag."),
    );
    offer.command(
        Cmd::new("sim.readCustomTableData", |c| {
            let (id, tag) = object_and_tag(c)?;
            let table = match tags::get(c, id, &tag)? {
                Some(data) => tables::unpack(&data)?,
                None => Value::List(Vec::new()),
            };
            c.ret(table);
            Ok(())
        })
        .param(target())
        .param(tag())
        .param(Param::any("options").optional().text("ignored"))
        .returns(Param::any("table").text("empty: there is none"))
        .text("Returns the table that is stored with an object under a tag."),
    );
    offer.command(
        both(["sim.readCustomDataBlockTags", "simReadCustomDataBlockTags"], NIL, |c| {
            let tags = tags(c)?;
            if !tags.is_empty() {
                c.ret(Value::List(tags));
            }
            Ok(())
        })
        .param(target())
        .returns(Param::list("tags").text("no value if there are none"))
        .text("Lists the tags under which data is stored with an object."),
    );
    offer.command(
        Cmd::new("sim.readCustomDataTags", |c| {
            let tags = tags(c)?;
            c.ret(Value::List(tags));
            Ok(())
        })
        .param(target())
        .returns(Param::list("tags"))
        .text("Lists the tags under which data is stored with an object."),
    );
    offer.command(
        Cmd::new("sim.getObjectsWithTag", |c| {
            let (tag, models) = (c.bytes(0)?.to_vec(), c.arg(1).truthy());
            let mut out = Vec::new();
            for id in c.world().list(0, 0, 0)? {
                if tags::get(c, id, &tag)?.is_some() && (!models || bool_of(c, id, c.plugin().p.model_base)?) {
                    out.push(handle(id));
                }
            }
            c.ret(&out[..]);
            Ok(())
        })
        .param(tag())
        .param(Param::any("justModels").optional().text("true: only bases of models"))
        .returns(Param::list("objects"))
        .text("Lists the objects that have data stored under a tag."),
    );
    headers(offer);
    persistent(offer);
}

/// Adds the commands from before V-REP 3.3, which identify data by a number instead of a tag.
fn headers(offer: &mut Offer<Vrep>) {
    let header = |n: i64| format!("#{n}").into_bytes();
    for (add, get, scene) in [
        (
            ["sim.addObjectCustomData", "simAddObjectCustomData"],
            ["sim.getObjectCustomData", "simGetObjectCustomData"],
            false,
        ),
        (
            ["sim.addSceneCustomData", "simAddSceneCustomData"],
            ["sim.getSceneCustomData", "simGetSceneCustomData"],
            true,
        ),
    ] {
        let at = usize::from(!scene);
        let of = move |c: &Ctx<'_>| -> Result<tatu_object> { if scene { Ok(0) } else { target_of(c, 0) } };
        let object = |command: Cmd| if scene { command } else { command.param(flagged("object")) };
        offer.command(
            object(both(add, MINUS_ONE, move |c| {
                let (id, tag) = (of(c)?, header(c.i64(at)?));
                let data = c.arg(at + 1).as_bytes().filter(|d| !d.is_empty());
                tags::set(c, id, &tag, data)?;
                c.ret(1_i64);
                Ok(())
            }))
            .param(Param::int("header").text("a number used as the tag"))
            .param(Param::string("data").optional().text("nil or empty: removes the data"))
            .returns(Param::int("done"))
            .text("Stores data with an object or the scene, under a number."),
        );
        offer.command(
            object(both(get, NIL, move |c| {
                let (id, tag) = (of(c)?, header(c.i64(at)?));
                if let Some(data) = tags::get(c, id, &tag)? {
                    c.ret(data.as_slice());
                }
                Ok(())
            }))
            .param(Param::int("header").text("a number used as the tag"))
            .returns(Param::string("data").text("no value if there is none"))
            .text("Returns the data stored with an object or the scene under a number."),
        );
    }
}

fn persistent(offer: &mut Offer<Vrep>) {
    let key = |name: &[u8]| [b"persistent.", name].concat();
    offer.command(
        both(["sim.persistentDataWrite", "simPersistentDataWrite"], MINUS_ONE, move |c| {
            let name = key(c.bytes(0)?);
            let data = c.bytes(1)?.to_vec();
            let name = String::from_utf8_lossy(&name).into_owned();
            tags::set_private(c, 0, &name, (!data.is_empty()).then_some(data.as_slice()))?;
            c.ret(1_i64);
            Ok(())
        })
        .param(Param::string("name"))
        .param(Param::string("data").text("empty: removes it"))
        .param(Param::int("options").default(0).optional().text("ignored: data is not written to disk"))
        .returns(Param::int("done"))
        .text("Stores data under a name.")
        .partial("The data is lost when the scene is closed; it is not written to disk."),
    );
    offer.command(
        both(["sim.persistentDataRead", "simPersistentDataRead"], NIL, move |c| {
            let name = key(c.bytes(0)?);
            let name = String::from_utf8_lossy(&name).into_owned();
            if let Some(data) = tags::private(c, 0, &name)? {
                c.ret(data.as_slice());
            }
            Ok(())
        })
        .alias("sim.getPersistentDataRead")
        .param(Param::string("name"))
        .returns(Param::string("data").text("no value if there is none"))
        .text("Returns the data stored under a name."),
    );
}

/// Returns the object in argument `i`, or 0 for the scene and the application, whose data is stored with the scene.
fn target_of(c: &Ctx<'_>, i: usize) -> Result<tatu_object> {
    match c.i64(i)? {
        HANDLE_SCENE | -13 | -15 => Ok(0),
        HANDLE_SELF => Ok(c.caller_object()),
        _ => Ok(existing_object(c, i)?.id),
    }
}

/// Returns the object in argument 0 and the tag in argument 1. Tags of the application are given a private prefix.
fn object_and_tag(c: &Ctx<'_>) -> Result<(tatu_object, Vec<u8>)> {
    let id = target_of(c, 0)?;
    let mut tag = c.bytes(1)?.to_vec();
    if matches!(c.i64(0)?, -13 | -15) {
        tag.splice(0..0, *b"\x01app.");
    }
    Ok((id, tag))
}

fn write(c: &Ctx<'_>, data: Option<Vec<u8>>) -> Result {
    let (id, tag) = object_and_tag(c)?;
    if tag.is_empty() {
        let mut all = tags::all(c, id)?;
        all.retain(|(k, _)| k.first() == Some(&tags::PRIVATE_PREFIX));
        return tags::replace_all(c, id, all);
    }
    tags::set(c, id, &tag, data.as_deref().filter(|d| !d.is_empty()))
}

fn tags(c: &Ctx<'_>) -> Result<Vec<Value>> {
    let id = target_of(c, 0)?;
    let app: &[u8] = if matches!(c.i64(0)?, -13 | -15) { b"\x01app." } else { b"" };
    let all = tags::all(c, id)?;
    let seen = all.into_iter().filter_map(|(k, _)| k.strip_prefix(app).map(<[u8]>::to_vec));
    Ok(seen.filter(|k| k.first() != Some(&tags::PRIVATE_PREFIX)).map(Value::Text).collect())
}
