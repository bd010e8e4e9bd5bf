//! Commands for views and remote clients: object properties, script texts, key presses, models, and opening a different
//! scene.

use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Offer, Param, Value, ValueRef, World},
};

use crate::plugin::{Cmd, Ctx, Tatu};

/// Returns the object whose handle is argument `i`; 0 is the world.
fn object(c: &Ctx<'_>, i: usize) -> tatu_plugin_api::safe::Result<tatu_object> {
    match c.i64(i)? {
        0 => Ok(0),
        n => Ok(c.world().look(n as u64)?.id),
    }
}

/// Collects `nth(0)`, `nth(1)` and so on into a list, up to the first `None`.
fn list<'a>(
    c: &mut Ctx<'a>,
    nth: impl Fn(&World<'a>, u32) -> tatu_plugin_api::safe::Result<Option<ValueRef<'a>>>,
) -> tatu_plugin_api::safe::Result {
    let mut all = Vec::new();
    while let Some(value) = nth(&c.world(), all.len() as u32)? {
        all.push(value.to_value()?);
    }
    c.ret(Value::List(all));
    Ok(())
}

pub(crate) fn offer(offer: &mut Offer<Tatu>) {
    offer.command(
        Cmd::new("tatu.properties", |c| {
            let object = object(c, 0)?;
            list(c, |world, n| world.row(object, n))
        })
        .param(Param::int("object").text("a handle; 0: the world"))
        .returns(Param::any("properties").text("a table per property: key, type, count, unit, settable, choices, text"))
        .text("Lists the properties of an object, including those of its device.")
        .example("for _, p in ipairs(tatu.properties(0)) do assert(p.key:find('scene.') == 1) end"),
    );
    offer.command(
        Cmd::new("tatu.models", |c| list(c, |world, n| world.model(n)))
            .returns(
                Param::any("models").text("a table per model: id, text, category (a heading such as `mobile robots`)"),
            )
            .text("Lists the models that plugins offer, and those in model folders.")
            .example("assert(#tatu.models() > 0)"),
    );
    offer.command(
        Cmd::new("tatu.kinds", |c| list(c, |world, n| world.kind(n)))
            .returns(Param::any("kinds").text("a table per kind: object (sensor or actuator), id, text"))
            .text("Lists the kinds of sensors and actuators that plugins offer, for `tatu.add`.")
            .example("for _, k in ipairs(tatu.kinds()) do assert(k.object == 'sensor' or k.object == 'actuator') end"),
    );
    offer.command(
        Cmd::new("tatu.addModel", |c| {
            let id = c.text(0)?;
            let mut at = 0;
            while let Some(model) = c.world().model(at)? {
                if model.get("id").and_then(|v| v.as_str()).is_some_and(|m| m == id) {
                    let made = c.world().load(id.as_bytes(), 0)?;
                    c.ret(i64::from(tatu_slot(made)));
                    return Ok(());
                }
                at += 1;
            }
            Err(Fail::missing(format!("there is no model `{id}`")).help("`tatu list models` shows them"))
        })
        .param(Param::string("model").text("its id: `tatu.models`"))
        .returns(Param::int("object").text("its base, placed at the origin of the world"))
        .text("Adds a model listed by `tatu.models`, with its default parameters.")
        .example("local robot = tatu.addModel('pioneer_p3dx')\ntatu.set(robot, 'object.position', {60, 60, 0.14})"),
    );
    offer.command(
        Cmd::new("tatu.getScript", |c| {
            let text = c.world().script_text(object(c, 0)?)?;
            c.ret(Value::Bytes(text));
            Ok(())
        })
        .param(Param::int("script").text("a handle: tatu.list('script')"))
        .returns(Param::string("text"))
        .text("Returns the text of a script.")
        .example("assert(#tatu.getScript(tatu.list('script')[1]) > 0)"),
    );
    offer.command(
        Cmd::new("tatu.setScript", |c| {
            let script = object(c, 0)?;
            c.world().change_script(script, c.bytes(1)?)
        })
        .param(Param::int("script").text("a handle: tatu.list('script')"))
        .param(Param::string("text"))
        .text(
            "Replaces the text of a script between two of its callbacks; variables that the new text contains keep \
             their values. A text that cannot be loaded is rejected, and nothing changes. A script cannot change its \
             own text.",
        )
        .example("assert(not pcall(tatu.setScript, tatu.list('script')[1], 'this is no Lua'))"),
    );
    offer.command(
        Cmd::new("tatu.press", |c| {
            let key = c.text(0)?;
            c.world().put_in("key", &key)
        })
        .param(Param::string("key").text("a character, a name such as `up`, or a code"))
        .text("Presses a key, as the option `--keys` or a terminal does.")
        .example("tatu.press('up')"),
    );
    offer.command(
        Cmd::new("tatu.open", |c| {
            let name = c.bytes(0)?;
            if name.is_empty() {
                return c.world().open_scene("");
            }
            let file = c.world().file(name, TATU_FILE_READ)?;
            c.world().open_scene(&String::from_utf8_lossy(&file))
        })
        .param(Param::string("file").text("a scene, or a file that an importer reads; empty: reloads this scene"))
        .text("Loads another scene once the current one has stopped. Supported only by `tatu serve` and `tatu open`.")
        .example("assert(not pcall(tatu.open, ''))"),
    );
}
