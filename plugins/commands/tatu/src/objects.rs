//! Commands that add, copy and remove objects and scripts.

use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Offer, Param, Result, Value},
};

use crate::plugin::{Cmd, Ctx, Tatu};

/// Default language of a new script.
const LANGUAGE: &str = "lua";
/// Default kind of a new script.
const KIND: &str = "child";

/// Returns the objects of argument `i`, a list of handles.
fn objects(c: &Ctx<'_>, i: usize) -> Result<Vec<tatu_object>> {
    let numbers = c.arg(i).numbers().filter(|n| !n.is_empty());
    let numbers = numbers.ok_or_else(|| Fail::argument(format!("argument {}: expected a list of handles", i + 1)))?;
    numbers.iter().map(|n| Ok(c.world().look(*n as u64)?.id)).collect()
}

/// Returns the object whose handle is argument `i`, or the world (0) if the argument is missing or 0.
fn parent(c: &Ctx<'_>, i: usize) -> Result<tatu_object> {
    match if c.has(i) { c.i64(i)? } else { 0 } {
        0 => Ok(0),
        n => Ok(c.world().look(n as u64)?.id),
    }
}

/// Moves objects by the offset in argument `i`, if given: three lengths in the world frame, m.
fn shift(c: &Ctx<'_>, objects: &[tatu_object], i: usize) -> Result {
    if !c.has(i) {
        return Ok(());
    }
    let by = c.arg(i).numbers().filter(|n| n.len() == 3);
    let by = by.ok_or_else(|| Fail::argument(format!("argument {}: expected three numbers, in m", i + 1)))?;
    for object in objects {
        let mut pose = c.world().pose(*object, 0)?;
        pose[..3].iter_mut().zip(&by).for_each(|(x, d)| *x += d);
        c.world().set_pose(*object, 0, &pose)?;
    }
    Ok(())
}

fn copy(c: &mut Ctx<'_>) -> Result {
    let from = objects(c, 0)?;
    let (world, below) = (c.world(), parent(c, 1)?);
    let copies = world.copy(&from)?;
    let key = world.host().prop("object.parent");
    let mut tops = Vec::new();
    for (old, new) in from.iter().zip(&copies) {
        let above = world.get(*old, key)?.as_object().unwrap_or(0);
        if !from.iter().any(|o| tatu_slot(*o) == tatu_slot(above)) {
            tops.push(*new);
            if below != 0 {
                world.set(*new, key, &Value::Object(below))?;
            }
        }
    }
    shift(c, &tops, 2)?;
    let handles: Vec<i64> = copies.iter().map(|o| i64::from(tatu_slot(*o))).collect();
    c.ret(handles.as_slice());
    Ok(())
}

fn add_script(c: &mut Ctx<'_>) -> Result {
    let owner = c.world().look(c.i64(0)? as u64)?.id;
    let text = |i: usize, usual: &str| if c.has(i) { c.text(i) } else { Ok(usual.to_owned()) };
    let (kind, language) = (text(2, KIND)?, text(3, LANGUAGE)?);
    // Messages about the script contain its name. A save replaces it by the path of the script's file.
    let alias = c.world().get(owner, c.world().host().prop("object.alias"))?;
    let name = format!("script of {}", alias.as_str().unwrap_or_default());
    let made = c.world().add_script(owner, &language, "", &kind, &name, c.bytes(1)?)?;
    c.ret(i64::from(tatu_slot(made)));
    Ok(())
}

pub(crate) fn offer(offer: &mut Offer<Tatu>) {
    offer.command(
        Cmd::new("tatu.add", |c| {
            let below = parent(c, 1)?;
            let made = c.world().add_text(c.bytes(0)?, below)?;
            shift(c, &[made], 2)?;
            c.ret(i64::from(tatu_slot(made)));
            Ok(())
        })
        .param(
            Param::string("text").text("tables of a scene file, such as `[[object]]`: docs/reference/scene-format.md"),
        )
        .param(Param::int("parent").optional().text("a handle; omitted: the world"))
        .param(Param::list("by").optional().text("offset of the first object in the world frame: x, y, z, m"))
        .returns(Param::int("object").text("the first object"))
        .text("Adds objects of any kind, described as in a scene file: shapes, joints, sensors with presets, models.")
        .example(
            "local box = tatu.add([=[format = 1\n[[object]]\nkind = \"shape\"\nalias = \"example_box\"\n\
             position_m = [50, 50, 0.05]\n]=])\nassert(tatu.get(box, 'object.alias') == 'example_box')",
        ),
    );
    offer.command(
        Cmd::new("tatu.copy", copy)
            .param(Param::list("objects").text("handles; descendants are copied only if they are listed"))
            .param(Param::int("parent").optional().text("of copies whose parent is not copied; omitted: the world"))
            .param(Param::list("by").optional().text("offset of those copies in the world frame: x, y, z, m"))
            .returns(Param::list("copies").text("in the same order"))
            .text("Copies objects with their devices and scripts.")
            .example(
                "local box = tatu.list('shape')[1]\nlocal copy = tatu.copy({box}, nil, {0, 0, 40})[1]\n\
                 assert(copy ~= box)\ntatu.remove({copy})",
            ),
    );
    offer.command(
        Cmd::new("tatu.remove", |c| {
            let all = objects(c, 0)?;
            c.world().remove(&all)
        })
        .param(
            Param::list("objects")
                .text("handles of objects and scripts; descendants of an object are removed only if they are listed"),
        )
        .text("Removes objects and scripts.")
        .example("tatu.remove({tatu.add('format = 1\\n[[object]]\\nkind = \"dummy\"')})"),
    );
    offer.command(
        Cmd::new("tatu.addScript", add_script)
            .param(Param::int("object").text("the handle of the object"))
            .param(Param::string("text"))
            .param(Param::string("kind").optional().text("child (the default), threaded or customization"))
            .param(Param::string("language").optional().text("default: lua"))
            .returns(Param::int("script").text("its handle"))
            .text("Adds a script to an object.")
            .example(
                "local box = tatu.list('shape')[1]\nlocal script = tatu.addScript(box, 'function sysCall_init() end')\n\
                 tatu.remove({script})",
            ),
    );
}
