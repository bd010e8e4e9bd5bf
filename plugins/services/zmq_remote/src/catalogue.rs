//! Lists the members of a namespace that clients can access.

use ciborium::Value as Cbor;
use tatu_plugin_api::safe::{Fail, Result, Turn};

use crate::cbor;

/// Names of the functions in the namespace `sim` that the service itself provides.
pub const SERVICE_FUNCTIONS: &[&str] =
    &["sim.setStepping", "sim.step", "sim.switchThread", "sim.yield", "sim.acquireLock", "sim.releaseLock"];

/// Returns the namespace of a module. The part of the module name after `-` is a version: `sim-2` has the namespace
/// `sim`.
fn namespace(name: &str) -> &str {
    name.split('-').next().unwrap_or(name)
}

/// Returns the names of all commands.
fn names(turn: &Turn<'_>) -> Vec<String> {
    turn.commands().into_iter().flat_map(|c| c.names).collect()
}

/// Checks that the namespace of a module exists.
pub fn require(turn: &Turn<'_>, name: &str) -> Result {
    let begin = format!("{}.", namespace(name));
    if namespace(name) == "zmqRemoteApi" || names(turn).iter().any(|n| n.starts_with(&begin)) {
        return Ok(());
    }
    Err(Fail::missing(format!("there is no module `{name}`: the name of no command begins with `{begin}`")))
}

/// Returns the members of a module: functions, constants, and nested namespaces of these.
pub fn info(turn: &Turn<'_>, name: &str) -> Result<Cbor> {
    require(turn, name)?;
    let begin = format!("{}.", namespace(name));
    let mut root = Vec::new();
    for own in names(turn).iter().map(String::as_str).chain(SERVICE_FUNCTIONS.iter().copied()) {
        if let Some(rest) = own.strip_prefix(&begin) {
            add_member(&mut root, rest, "func", Cbor::Map(Vec::new()));
        }
    }
    for (own, value) in turn.constants()? {
        if let Some(rest) = own.strip_prefix(&begin) {
            // A table of constants becomes a nested namespace.
            match cbor::write(value) {
                Cbor::Map(entries) => {
                    for (key, value) in entries {
                        if let Cbor::Text(key) = key {
                            add_member(&mut root, &format!("{rest}.{key}"), "const", value);
                        }
                    }
                }
                value => add_member(&mut root, rest, "const", value),
            }
        }
    }
    Ok(Cbor::Map(root))
}

type MemberEntries = Vec<(Cbor, Cbor)>;

/// Adds a member with a name such as `a.b`, and the namespaces that contain it. Keeps a member that exists already.
fn add_member(entries: &mut MemberEntries, name: &str, kind: &str, value: Cbor) {
    let (first, rest) = name.split_once('.').map_or((name, None), |(f, r)| (f, Some(r)));
    let at = entries.iter().position(|(k, _)| k.as_text() == Some(first));
    match rest {
        None if at.is_none() => {
            let entry = Cbor::Map(vec![(Cbor::Text(kind.to_owned()), value)]);
            entries.push((Cbor::Text(first.to_owned()), entry));
        }
        None => {}
        Some(rest) => {
            let at = at.unwrap_or_else(|| {
                entries.push((Cbor::Text(first.to_owned()), Cbor::Map(Vec::new())));
                entries.len() - 1
            });
            if let Cbor::Map(inner) = &mut entries[at].1 {
                add_member(inner, rest, kind, value);
            }
        }
    }
}
