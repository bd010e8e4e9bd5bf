//! Access to the network and the clock: checks permissions, and records the results as inputs of the run.

use std::{cell::RefMut, io, net::SocketAddr};

use serde_json::{Value as Json, json};
use tatu_commands_common::permission;
use tatu_plugin_api::{
    abi::*,
    safe::{Call, Command, Fail, Param, Result, Value},
};
use tatu_services_common::json;

use crate::{
    plugin::LuaSocket,
    sockets::{Sockets, addresses, error_message},
};

pub(crate) type Ctx<'a> = Call<'a, LuaSocket>;

/// Kind of this plugin's entries in the input log.
const KIND: &str = "socket";
/// Commands whose first result is the number of a new socket.
const OPENING_COMMANDS: [&str; 4] =
    ["luasocket.connect", "luasocket.listen", "luasocket.accept", "luasocket.bindDatagrams"];

pub(crate) fn text(text: impl AsRef<str>) -> Value {
    Value::text(text.as_ref())
}
/// Converts an error to the return values nil and a message.
pub(crate) fn error_values(e: &io::Error) -> Vec<Value> {
    vec![Value::Nil, text(error_message(e))]
}
pub(crate) fn or_wrong(result: io::Result<Vec<Value>>) -> Vec<Value> {
    result.unwrap_or_else(|e| error_values(&e))
}
pub(crate) fn address_values(at: SocketAddr) -> [Value; 2] {
    [text(at.ip().to_string()), Value::Int(i64::from(at.port()))]
}

pub(crate) fn borrow_sockets<'a>(c: &Ctx<'a>) -> Result<RefMut<'a, Sockets>> {
    c.instance()
        .sockets
        .try_borrow_mut()
        .map_err(|_| Fail::with_code(TATU_ERR_BUSY, "another command is using the sockets"))
}

/// Returns the permissions that the user granted with `--allow`, separated by commas.
pub(crate) fn allowed(c: &Ctx<'_>) -> Result<String> {
    Ok(c.world().get(0, c.plugin().allow)?.as_str().unwrap_or_default().into_owned())
}

/// Resolves argument `i`, a host, and the argument after it, a port. The inner result is an error if the host is
/// unknown or the run may not access the address.
pub(crate) fn address(c: &Ctx<'_>, i: usize) -> Result<io::Result<SocketAddr>> {
    let (host, port) = (c.text(i)?, port(c, i + 1)?);
    let allowed = allowed(c)?;
    // Resolving a host name is network access, so it requires a permission.
    let found = if permission::allows_any(&allowed) { addresses(&host, port) } else { Ok(Vec::new()) };
    let found = match found {
        Ok(found) => found,
        Err(e) => return Ok(Err(e)),
    };
    if let Some(at) = found.into_iter().find(|at| permission::allows(&allowed, &host, *at)) {
        return Ok(Ok(at));
    }
    if !c.instance().denial_reported.replace(true) {
        let host = if host == "*" { "0.0.0.0" } else { &host };
        let port = if port == 0 { "*".to_owned() } else { port.to_string() };
        let text =
            format!("a script was denied access to {host}:{port}; to allow it, pass `--allow net={host}:{port}`");
        c.world().log(TATU_LOG_WARNING, text.as_bytes());
    }
    Ok(Err(io::ErrorKind::PermissionDenied.into()))
}

pub(crate) fn port(c: &Ctx<'_>, i: usize) -> Result<u16> {
    let of_text = || c.text(i).ok().and_then(|t| t.trim().parse::<f64>().ok());
    let number = c.arg(i).as_f64().or_else(of_text).filter(|n| n.fract() == 0.0 && (0.0..65536.0).contains(n));
    number.map(|n| n as u16).ok_or_else(|| Fail::argument(format!("argument {}: expected a port, 0 to 65535", i + 1)))
}

/// Runs `look` and records its result in the input log. In a replay, returns the recorded result instead. The result is
/// the list of values that the command returns.
pub(crate) fn observe(
    c: &Ctx<'_>,
    name: &str,
    look: impl FnOnce(&Ctx<'_>) -> Result<Vec<Value>>,
) -> Result<Vec<Value>> {
    let mut failed = None;
    let found = c.world().observe(KIND, || {
        let found = look(c).map(|values| values.iter().map(json::write).collect::<Vec<_>>());
        let found = found.unwrap_or_else(|fail| {
            failed = Some(fail);
            Vec::new()
        });
        json!([name, found]).to_string()
    })?;
    if let Some(fail) = failed {
        return Err(fail);
    }
    let strange = || {
        Fail::new(format!(
            "the recorded run made a different socket call here: {found}; replay it with the scene it was recorded with"
        ))
    };
    let (then, found): (String, Vec<Json>) = serde_json::from_str(&found).map_err(|_| strange())?;
    if then != name {
        return Err(strange());
    }
    let found = found.iter().map(json::read).collect::<Result<Vec<_>>>()?;
    if let Some(Value::Int(n)) = found.first().filter(|_| OPENING_COMMANDS.contains(&name)) {
        // A replay does not open sockets, but must assign the same numbers as the recorded run.
        let mut sockets = borrow_sockets(c)?;
        sockets.last = sockets.last.max(*n);
    }
    Ok(found)
}

pub(crate) fn return_values(c: &mut Ctx<'_>, values: Vec<Value>) {
    values.into_iter().for_each(|v| c.ret(v));
}

/// Builds a command whose results are recorded as inputs of the run.
pub(crate) fn command(
    name: &'static str,
    look: impl Fn(&Ctx<'_>, &mut Sockets, &dyn Fn() -> bool) -> Result<Vec<Value>> + Send + Sync + 'static,
) -> Command<LuaSocket> {
    Command::new(name, move |c| {
        let found = observe(c, name, |c| look(c, &mut *borrow_sockets(c)?, &|| c.world().is_interrupted()))?;
        return_values(c, found);
        Ok(())
    })
}
pub(crate) fn socket() -> Param {
    Param::int("socket").text("its number")
}
pub(crate) fn timeout() -> Param {
    Param::float("timeout").unit("s").text("negative: no limit")
}
pub(crate) fn failure() -> Param {
    Param::string("error").optional().text("as in LuaSocket: timeout, closed, connection refused")
}
