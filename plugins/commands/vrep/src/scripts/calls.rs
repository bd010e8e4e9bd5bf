//! Commands on scripts: the objects to which they belong, calls of their functions, their parameters.

use crate::{kit::*, lookup::names, state::state};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.getObjectAssociatedWithScript", |c| {
            let owner = match c.i64(0)? {
                HANDLE_SELF => c.caller_object(),
                _ => parent(c, of_kind(c, 0, TATU_KIND_SCRIPT)?)?,
            };
            c.ret(handle(owner));
            Ok(())
        })
        .old_name("simGetObjectAssociatedWithScript", MINUS_ONE)
        .param(Param::int("script").text("a handle, or sim.handle_self"))
        .returns(Param::int("object").text("-1: none"))
        .text("Returns the object to which a script belongs.")
        .example("robot = sim.getObjectAssociatedWithScript(sim.handle_self)"),
    );
    for (names, kind, text) in [
        (
            ["sim.getScriptAssociatedWithObject", "simGetScriptAssociatedWithObject"],
            "child",
            "Returns the child script of an object.",
        ),
        (
            ["sim.getCustomizationScriptAssociatedWithObject", "simGetCustomizationScriptAssociatedWithObject"],
            "customization",
            "Returns the customization script of an object.",
        ),
    ] {
        offer.command(
            both(names, MINUS_ONE, move |c| {
                let script = script_of(c, existing_object(c, 0)?.id, kind)?;
                c.ret(handle(script));
                Ok(())
            })
            .param(object("object"))
            .returns(Param::int("script").text("-1: none"))
            .text(text)
            .example(format!("script = {}(robot)", names[0])),
        );
    }
    offer.command(
        Cmd::new("sim.getScript", |c| {
            let kind = c.i64(0)?;
            let script = match (c.arg(1), kind) {
                (v, 0) if v.is_nil() => main_script(c)?,
                (v, HANDLE_SELF) if v.is_nil() => c.caller_script(),
                (v, _) => {
                    let owner = match v.as_str() {
                        Some(name) => names::find(c, &name)?,
                        None => existing_object(c, 1)?.id,
                    };
                    let kind = kind_of(kind)
                        .ok_or_else(|| Fail::unsupported(format!("script type {kind} is not supported")))?;
                    script_of(c, owner, kind)?
                }
            };
            c.ret(handle(script));
            Ok(())
        })
        .param(Param::int("type").text("sim.scripttype_...; or sim.handle_self alone: the calling script"))
        .param(Param::any("object").optional().text("a handle, path or name"))
        .returns(Param::int("script").text("-1: none"))
        .text("Returns an object's script of a given type.")
        .example("script = sim.getScript(sim.scripttype_childscript, robot)"),
    );
    offer.command(
        Cmd::new("sim.getScriptHandle", |c| {
            let text = if c.has(0) { c.text(0)? } else { String::new() };
            let script = if !c.has(0) {
                c.caller_script()
            } else if text.is_empty() {
                main_script(c)?
            } else {
                let (kind, name) = text.split_once('@').unwrap_or(("child", &text));
                script_of(c, names::find_or_create(c, name)?, kind)?
            };
            c.ret(handle(script));
            Ok(())
        })
        .old_name("simGetScriptHandle", MINUS_ONE)
        .param(Param::string("name").optional().text(
            "name of the object; `customization@name`: its customization script; empty: the main script; \
                       omitted: the caller",
        ))
        .returns(Param::int("script").text("-1: none"))
        .text("Finds a script by the name of its object.")
        .example("script = sim.getScriptHandle('robot')"),
    );
    offer.command(
        Cmd::new("sim.getScriptName", |c| {
            let script = self_or(c, 0)?;
            let name = text_of(c, parent(c, script)?, c.plugin().p.name)?;
            c.ret(name.as_str());
            Ok(())
        })
        .old_name("simGetScriptName", NIL)
        .param(Param::int("script").text("a handle, or sim.handle_self"))
        .returns(Param::string("name"))
        .text("Returns the name of the object to which a script belongs.")
        .example("name = sim.getScriptName(sim.handle_self)"),
    );
    offer.command(
        Cmd::new("sim.callScriptFunction", call)
            .old_name("simCallScriptFunction", MINUS_ONE)
            .param(Param::string("function").text("its name; old scripts append `@` and the script's object"))
            .param(Param::int("script").text("a handle, sim.handle_self, or a script type if the object is named"))
            .param(Param::any("arguments").rest())
            .returns(Param::any("results").text("the values that the function returns"))
            .text("Calls a function of another script.")
            .example("x = sim.callScriptFunction('grasp', script, 0.5)"),
    );
    offer.command(
        Cmd::new("sim.getScriptExecutionCount", |c| {
            let calls = match c.caller_script() {
                0 => 0,
                // The counter includes the current call.
                script => int_of(c, script, c.plugin().p.script_calls)? - 1,
            };
            c.ret(calls.max(0));
            Ok(())
        })
        .old_name("simGetScriptExecutionCount", MINUS_ONE)
        .returns(Param::int("count").text("0 in the first call"))
        .text("Returns the number of previous calls of the calling script.")
        .example("if sim.getScriptExecutionCount() == 0 then end"),
    );
    offer.command(
        Cmd::new("sim.isScriptExecutionThreaded", |c| {
            let threaded = c.can_wait();
            c.ret(i64::from(threaded));
            Ok(())
        })
        .alias("sim.isScriptRunningInThread")
        .old_name("simIsScriptExecutionThreaded", MINUS_ONE)
        .old_name("simIsScriptRunningInThread", MINUS_ONE)
        .returns(Param::int("threaded").text("1 or 0"))
        .text("Returns whether the calling script can wait.")
        .example("threaded = sim.isScriptExecutionThreaded() == 1"),
    );
    offer.command(
        Cmd::new("sim.getScriptSimulationParameter", |c| {
            let script = if c.i64(0)? == HANDLE_MAIN_SCRIPT { main_script(c)? } else { self_or(c, 0)? };
            let key = (script, c.bytes(1)?.to_vec());
            let mut found = state(c)?.script_values.parameters.get(&key).cloned();
            if found.is_none() {
                found = scene_parameter(c, &key)?;
            }
            // In a run without a scene, "1" replaces the missing parameter.
            if found.is_none() && c.world().stands_in(key.0, &String::from_utf8_lossy(&key.1)) {
                found = Some(b"1".to_vec());
            }
            if let Some(text) = found {
                let value = if c.arg(2).truthy() { Value::Text(text) } else { parse_value(text) };
                c.ret(value);
            }
            Ok(())
        })
        .old_name("simGetScriptSimulationParameter", NIL)
        .param(Param::int("script").text("a handle, or sim.handle_self"))
        .param(Param::string("name"))
        .param(Param::any("asText").optional().text("true: returns the value as a string"))
        .returns(Param::any("value").text("a boolean, number or string; no value if the parameter is not set"))
        .text(
            "Returns a parameter of a script, set by another script, or by the scene as custom data of the script's \
             object under the tag `parameter.` followed by the name.",
        )
        .example("speed = sim.getScriptSimulationParameter(sim.handle_self, 'speed')"),
    );
    offer.command(
        Cmd::new("sim.setScriptSimulationParameter", |c| {
            let (name, value) = (c.bytes(1)?.to_vec(), c.bytes(2)?.to_vec());
            let scripts = with_parameters(c)?;
            for script in &scripts {
                state(c)?.script_values.parameters.insert((*script, name.clone()), value.clone());
            }
            if old_era(c) {
                c.ret(scripts.len() as i64);
            }
            Ok(())
        })
        .old_name("simSetScriptSimulationParameter", MINUS_ONE)
        .param(Param::int("script").text("a handle, sim.handle_self, _all, or (of the caller's object) _tree, _chain"))
        .param(Param::string("name"))
        .param(Param::string("value"))
        .returns(Param::int("count").text("before 4.2: the number of scripts that now have the parameter"))
        .text("Sets a parameter of a script until the end of the simulation.")
        .example("sim.setScriptSimulationParameter(script, 'speed', 2)"),
    );
}

/// Returns the script of a kind that belongs to an object, or 0 if there is none.
fn script_of(c: &Ctx<'_>, owner: tatu_object, kind: &str) -> Result<tatu_object> {
    let all = c.world().scripts(owner)?;
    let of_kind = |s: &&tatu_object| {
        text_of(c, **s, c.plugin().p.script_kind).is_ok_and(|k| k == kind || k == "threaded" && kind == "child")
    };
    let found = all.iter().find(of_kind).copied();
    if found.is_none() && owner != 0 && kind == "child" {
        // In a run without a scene, objects that replace missing ones have no scripts at first. Report the failed
        // lookup, so that the host can add a script in the next attempt.
        c.world().missed_script(owner);
    }
    Ok(found.unwrap_or(0))
}

fn main_script(c: &Ctx<'_>) -> Result<tatu_object> {
    script_of(c, 0, "main")
}

/// Returns the script kind for a type number, or `None` if the number is not a supported type.
pub(crate) fn kind_of(kind: i64) -> Option<&'static str> {
    match kind {
        0 => Some("main"),
        // 241 is sim_scripttype_childscript + sim_scripttype_threaded.
        1 | 241 => Some("child"),
        6 => Some("customization"),
        _ => None,
    }
}

/// Returns the script of the given type that belongs to the named object.
pub(crate) fn script_of_named_object(c: &Ctx<'_>, owner: &str, kind: i64) -> Result<tatu_object> {
    let script = match kind_of(kind) {
        Some("main") => main_script(c)?,
        Some(kind) => script_of(c, names::find(c, owner)?, kind)?,
        None => 0,
    };
    if script == 0 { Err(Fail::missing(format!("`{owner}` has no script of type {kind}"))) } else { Ok(script) }
}

/// Returns the script that argument `i` denotes: a script, the caller, the main script, or an object's child script.
pub(crate) fn any_script(c: &Ctx<'_>, i: usize) -> Result<tatu_object> {
    let found = match c.i64(i)? {
        HANDLE_MAIN_SCRIPT | 0 => main_script(c)?,
        HANDLE_SELF => return self_or(c, i),
        _ => {
            let o = existing_object(c, i)?;
            if o.kind == TATU_KIND_SCRIPT { o.id } else { script_of(c, o.id, "child")? }
        }
    };
    if found == 0 {
        Err(Fail::missing("expected the handle of a script or of an object with a script"))
    } else {
        Ok(found)
    }
}

/// Returns the script that argument `i` denotes: a script, or the caller.
pub(crate) fn self_or(c: &Ctx<'_>, i: usize) -> Result<tatu_object> {
    if c.i64(i)? == HANDLE_SELF {
        return match c.caller_script() {
            0 => Err(Fail::missing("the caller is not a script: pass a script's handle instead of sim.handle_self")),
            script => Ok(script),
        };
    }
    of_kind(c, i, TATU_KIND_SCRIPT)
}

/// Returns a script parameter that is set by the scene or the model, as custom data of the script's object under a tag
/// that starts with `parameter.`.
fn scene_parameter(c: &Ctx<'_>, (script, name): &(tatu_object, Vec<u8>)) -> Result<Option<Vec<u8>>> {
    // The main script does not belong to an object.
    let owner = parent(c, *script).unwrap_or(0);
    if owner == 0 { Ok(None) } else { tags::get(c, owner, &[b"parameter.", name.as_slice()].concat()) }
}

/// Returns the scripts that argument 0 selects: one script, all scripts, or those of the caller's object and its
/// descendants or ancestors.
fn with_parameters(c: &Ctx<'_>) -> Result<Vec<tatu_object>> {
    let own = c.caller_object();
    let owners = match c.i64(0)? {
        HANDLE_ALL => return c.world().scripts(0),
        HANDLE_MAIN_SCRIPT => return Ok(vec![main_script(c)?]),
        HANDLE_TREE | HANDLE_CHAIN if own == 0 => return Err(Fail::missing("the caller does not belong to an object")),
        HANDLE_TREE => c.world().list(own, 0, 0)?,
        HANDLE_CHAIN => {
            let mut all = vec![own];
            while let Some(up) = all.last().map(|o| parent(c, *o)).transpose()?.filter(|up| *up != 0) {
                all.push(up);
            }
            all
        }
        _ => return Ok(vec![self_or(c, 0)?]),
    };
    let mut scripts = Vec::new();
    for owner in owners {
        scripts.extend(c.world().scripts(owner)?);
    }
    Ok(scripts)
}

/// Converts the text of a parameter to nil, a boolean or a number if it spells one, otherwise to a string.
fn parse_value(text: Vec<u8>) -> Value {
    match text.as_slice() {
        b"nil" => Value::Nil,
        b"true" => Value::Bool(true),
        b"false" => Value::Bool(false),
        t => match std::str::from_utf8(t).ok().and_then(|t| t.trim().parse::<f64>().ok()) {
            Some(x) if x.is_finite() => Value::Float(x),
            _ => Value::Text(text),
        },
    }
}

fn call(c: &mut Ctx<'_>) -> Result {
    let text = c.text(0)?;
    let (function, owner) = text.split_once('@').unwrap_or((&text, ""));
    let which = c.i64(1)?;
    let script = match (owner.is_empty(), kind_of(which)) {
        (true, Some("main")) => main_script(c)?,
        (true, _) if which == HANDLE_MAIN_SCRIPT => main_script(c)?,
        (false, Some(kind)) => script_of(c, names::find(c, owner)?, kind)?,
        _ => self_or(c, 1)?,
    };
    if script == 0 {
        return Err(Fail::missing(format!("there is no script `{text}`")));
    }
    let args = c.args().get(2..).unwrap_or_default();
    let args: Vec<Value> = args.iter().map(|v| v.to_value()).collect::<Result<_>>()?;
    for value in c.world().call_function(script, function, &args)? {
        c.ret(value);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameter_texts_are_converted_to_values() {
        assert_eq!(parse_value(b"0.5".to_vec()), Value::Float(0.5));
        assert_eq!(parse_value(b"true".to_vec()), Value::Bool(true));
        assert_eq!(parse_value(b"nil".to_vec()), Value::Nil);
        assert_eq!(parse_value(b"left".to_vec()), Value::text("left"));
        assert_eq!(parse_value(b"inf".to_vec()), Value::text("inf"));
    }
}
