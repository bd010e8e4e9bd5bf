//! Further commands on scripts: running code in them, their variables and attributes, and user parameters.

use super::calls as scripts;
use crate::{kit::*, state::state};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.prelude("lua", "", include_str!("catalogue.lua"));
    let target = || Param::any("script").text("a handle, or a script type if the object's name is appended");
    offer.command(
        both(["sim.executeScriptString", "simExecuteScriptString"], MINUS_ONE, |c| {
            let text = c.text(0)?;
            let (code, script) = target_of(c, &text, 1)?;
            match c.world().call_function(script, "_tatu_execute", &[Value::text(&code)]) {
                Ok(results) => {
                    let good = matches!(results.first(), Some(Value::Bool(true)));
                    c.ret(if good { 0_i64 } else { -1 });
                    if let Some(v) = results.get(1) {
                        c.ret(v.clone());
                    }
                    Ok(())
                }
                Err(e) if e.code() == TATU_ERR_MISSING => {
                    Err(Fail::unsupported("the script's language does not support running code from a string"))
                }
                Err(e) => Err(e),
            }
        })
        .param(Param::string("code").text("old scripts append `@` and the name of the script's object"))
        .param(target())
        .returns(Param::int("result").text("0; -1: it failed"))
        .returns(Param::any("value").text("the result of the code, or the error message"))
        .text("Runs code in a script."),
    );
    offer.command(
        both(["sim.setScriptVariable", "simSetScriptVariable"], MINUS_ONE, |c| {
            let text = c.text(0)?;
            let (name, script) = target_of(c, &text, 1)?;
            let value = c.arg(2).to_value()?;
            c.world().call_function(script, "_tatu_assign", &[Value::text(&name), value])?;
            c.ret(1_i64);
            Ok(())
        })
        .param(Param::string("name").text("old scripts append `@` and the name of the script's object"))
        .param(target())
        .param(Param::any("value"))
        .returns(Param::int("done"))
        .text("Sets a global variable of a script."),
    );
    offer.command(
        Cmd::new("sim.testCB", |c| {
            let function = c.arg(1).as_func().ok_or_else(|| Fail::argument("argument 2: expected a function"))?;
            let args = [c.arg(0).to_value()?, c.arg(2).to_value()?];
            let mut results = Vec::new();
            for _ in 0..=c.i64(3)?.clamp(0, 1_000_000) {
                results = c.call_func(function, &args)?;
            }
            results.iter().for_each(|r| c.ret(r));
            Ok(())
        })
        .param(Param::any("a").optional().text("its first argument"))
        .param(Param::func("function"))
        .param(Param::any("b").optional().text("its second argument"))
        .param(Param::int("iterations").default(99).text("number of calls before the last one"))
        .returns(Param::any("results").text("results of the last call"))
        .text("Calls a function repeatedly, to test callbacks like those of remote clients."),
    );
    offer.command(
        Cmd::new("sim.getScriptFunctions", |c| {
            scripts::self_or(c, 0)?;
            c.ret(Value::Map(Vec::new()));
            Ok(())
        })
        .param(Param::int("script"))
        .returns(Param::any("functions").text("a table whose fields are the script's functions"))
        .text("Returns a table whose methods call the functions of a script.")
        .partial("Works only in Lua; for other callers, the table is empty."),
    );
    offer.command(
        both(["sim.invertMatrix", "simInvertMatrix"], MINUS_ONE, |c| {
            let m = algebra::invert(&numbers(c, 0)?);
            c.ret(&m[..]);
            Ok(())
        })
        .param(table("matrix", "12 numbers"))
        .returns(Param::any("result").text("1 in Lua, otherwise the inverse"))
        .text("Inverts a matrix; in Lua, in place.")
        .notes("In languages other than Lua, the result is the inverse."),
    );
    attributes(offer);
    parameters(offer);
    offer.command(
        both(["sim.removeScript", "simRemoveScript"], MINUS_ONE, |c| {
            let script = scripts::self_or(c, 0)?;
            c.world().remove(&[script])?;
            finish_setter(c)
        })
        .param(Param::int("script").text("a handle, or sim.handle_self"))
        .text("Removes a script, which is then no longer called."),
    );
    offer.command(
        both(["sim.getLastError", "simGetLastError"], NIL, |c| {
            let text = std::mem::take(&mut state(c)?.last_error);
            if !text.is_empty() {
                c.ret(text.as_slice());
            }
            Ok(())
        })
        .alias("sim.getLastInfo")
        .returns(Param::string("text").text("no value if no call has failed"))
        .text("Returns the message of the last failed call, once.")
        .stub("errors of failed calls are written to the log"),
    );
    offer.command(
        Cmd::new("sim.copyTable", |c| {
            let v = c.arg(0).to_value()?;
            c.ret(v);
            Ok(())
        })
        .param(Param::any("table"))
        .returns(Param::any("copy"))
        .text("Returns a copy of a table, including the tables in it.")
        .partial("Only booleans, numbers, strings and tables can be copied."),
    );
}

/// Returns the text before `@`, and the script that is named after the `@` or identified by argument `i`, or the caller
/// if the argument is missing.
fn target_of(c: &Ctx<'_>, text: &str, i: usize) -> Result<(String, tatu_object)> {
    let by_type = c.arg(i).as_i64().is_some_and(|n| scripts::kind_of(n).is_some());
    match text.rsplit_once('@') {
        Some((head, owner)) if by_type => Ok((head.into(), scripts::script_of_named_object(c, owner, c.i64(i)?)?)),
        _ if !c.has(i) => match c.caller_script() {
            0 => Err(Fail::missing("the caller is not a script, so the handle of a script must be passed")),
            script => Ok((text.into(), script)),
        },
        _ => Ok((text.into(), scripts::any_script(c, i)?)),
    }
}

fn attributes(offer: &mut Offer<Vrep>) {
    let id = || Param::int("attribute").text("sim.scriptattribute_...");
    let name = |n: i64| format!("attribute {n}");
    offer.command(
        both(["sim.getScriptAttribute", "simGetScriptAttribute"], MINUS_ONE, move |c| {
            let (script, n) = (scripts::self_or(c, 0)?, c.i64(1)?);
            let kept = tags::number(c, script, &name(n))?;
            match n {
                2 => c.ret(int_of(c, script, c.plugin().p.script_calls)?),
                // The attributes active, cascaded and enabled are booleans.
                0 | 3 | 4 => c.ret(kept.is_none_or(|x| x != 0.0)),
                _ => c.ret(kept.unwrap_or(1.0) as i64),
            }
            Ok(())
        })
        .param(Param::int("script").text("a handle, or sim.handle_self"))
        .param(id())
        .returns(Param::any("value"))
        .text("Returns an attribute of a script."),
    );
    offer.command(
        both(["sim.setScriptAttribute", "simSetScriptAttribute"], MINUS_ONE, move |c| {
            let (script, n) = (scripts::self_or(c, 0)?, c.i64(1)?);
            let v = c.arg(2);
            let x = v.as_f64().unwrap_or(f64::from(u8::from(v.truthy())));
            tags::set_number(c, script, &name(n), x)?;
            c.ret(1_i64);
            Ok(())
        })
        .param(Param::int("script").text("a handle, or sim.handle_self"))
        .param(id())
        .param(Param::any("value"))
        .returns(Param::int("done"))
        .text("Sets an attribute of a script.")
        .partial("The attribute is only stored and returned; it does not affect how scripts are called."),
    );
}

/// Adds commands for the parameters that users can set in V-REP's dialogs.
fn parameters(offer: &mut Offer<Vrep>) {
    let name = |c: &Ctx<'_>| Ok::<_, Fail>(format!("parameter {}", c.text(1)?));
    let target = |c: &Ctx<'_>| match c.i64(0)? {
        HANDLE_SELF => Ok(c.caller_object()),
        _ => Ok(existing_object(c, 0)?.id),
    };
    offer.command(
        both(["sim.getUserParameter", "simGetUserParameter"], NIL, move |c| {
            if let Some(data) = tags::private(c, target(c)?, &name(c)?)? {
                let value = tables::unpack(&data)?;
                c.ret(value);
            }
            Ok(())
        })
        .param(flagged("object"))
        .param(Param::string("name").text("`name`, or `@alternative`"))
        .returns(Param::any("value").text("no value if the parameter is not set"))
        .text("Returns a user parameter of an object."),
    );
    offer.command(
        both(["sim.setUserParameter", "simSetUserParameter"], MINUS_ONE, move |c| {
            let (id, name) = (target(c)?, name(c)?);
            let value = c.arg(2).to_value()?;
            let data = if value == Value::Nil { None } else { Some(tables::pack(&value)?) };
            tags::set_private(c, id, &name, data.as_deref())?;
            finish_setter(c)
        })
        .param(flagged("object"))
        .param(Param::string("name"))
        .param(Param::any("value").text("nil: removes the parameter"))
        .text("Sets a user parameter of an object."),
    );
}
