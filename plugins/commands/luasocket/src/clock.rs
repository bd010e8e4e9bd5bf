//! Commands that resolve host names and read this machine's clock.

use std::{
    io,
    time::{SystemTime, UNIX_EPOCH},
};

use tatu_commands_common::permission;
use tatu_plugin_api::safe::{Command, Offer, Param, Value};

use crate::{
    plugin::LuaSocket,
    recording::{allowed, command, error_values, failure, text},
    sockets::{CallDeadline, addresses},
};

pub(crate) fn offer(offer: &mut Offer<LuaSocket>) {
    offer.command(
        command("luasocket.addresses", |c, _, _| {
            if !permission::allows_any(&allowed(c)?) {
                return Ok(error_values(&io::ErrorKind::PermissionDenied.into()));
            }
            Ok(match addresses(&c.text(0)?, 0) {
                Ok(all) => vec![Value::List(all.iter().map(|at| text(at.ip().to_string())).collect())],
                Err(_) => vec![Value::Nil, text("host not found")],
            })
        })
        .param(Param::string("host"))
        .returns(Param::list("addresses").optional())
        .returns(failure())
        .text("Returns the addresses of a host name.")
        .example("local all, e = luasocket.addresses('localhost')"),
    );
    offer.command(
        command("luasocket.time", |c, _, _| {
            let now = if permission::allows_any(&allowed(c)?) {
                SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64()
            } else {
                let epoch = c.world().get(0, c.plugin().epoch)?.as_i64().unwrap_or(0);
                epoch as f64 + c.world().f64(0, c.plugin().clock)?
            };
            Ok(vec![Value::Float(now)])
        })
        .returns(Param::float("time").unit("s"))
        .text(
            "Returns the Unix time. If the run may open sockets, it is read from the clock of this machine and \
             recorded as an input of the run; otherwise it is the start date of the run plus the time elapsed since, \
             which is the same in each run that is not in real time.",
        )
        .example("assert(luasocket.time() >= 0)"),
    );
    offer.command(
        Command::new("luasocket.sleep", |c| {
            let seconds = c.f64(0)?.max(0.0);
            if permission::allows_any(&allowed(c)?) {
                CallDeadline::new(seconds, &|| c.world().is_interrupted()).wait();
            }
            Ok(())
        })
        .param(Param::float("seconds").unit("s"))
        .text("Blocks the whole run for a wall-clock time if the run may open sockets; otherwise does nothing.")
        .example("luasocket.sleep(0.01)"),
    );
}
