//! Commands for contexts and sockets.

use tatu_plugin_api::safe::{Command, Fail, Offer, Param, Result, Value};

use crate::{
    endpoint::{self, Endpoint, Refusal},
    errors::Errno,
    links::Socket,
    options::{self, EVENTS, LAST_ENDPOINT, MAXMSGSIZE, RCVMORE, ROUTING_ID, SUBSCRIBE, TYPE, UNSUBSCRIBE},
    recording::{SocketOutcome, denial, observe},
    transfer::{events_of, socket_param},
    world::{Ctx, Zmq, allowed, fail, state, status},
};

fn result() -> Param {
    Param::int("result").text("0; -1: failed")
}

fn context() -> Param {
    Param::string("context")
}

fn option() -> Param {
    Param::int("option_name").text("a constant, such as `simZMQ.RCVTIMEO`")
}

/// Returns a handle to the script, or an empty string after a failure.
fn handle(c: &mut Ctx<'_>, found: Result<String, Errno>) -> Result {
    if let Err(errno) = found {
        fail(c, errno)?;
    }
    c.ret(Value::text(found.unwrap_or_default()));
    Ok(())
}

/// Builds a command that binds, unbinds, connects or disconnects a socket.
fn attaching(
    name: &'static str,
    bind: bool,
    f: impl Fn(&mut Socket, &Endpoint) -> Result<(), Errno> + Send + Sync + 'static,
) -> Command<Zmq> {
    let run = move |c: &mut Ctx<'_>| {
        let (socket, text) = (c.text(0)?, c.text(1)?);
        let found = observe(c, name, |c, world| {
            let endpoint = match endpoint::open(&text, bind, &allowed(c)?) {
                Ok(endpoint) => endpoint,
                Err(Refusal::Error(errno)) => return Ok(errno.into()),
                Err(Refusal::Denied(text, help)) => return Ok(SocketOutcome::Denied(text, help)),
            };
            let done = world.socket(&socket).and_then(|socket| f(socket, &endpoint));
            Ok(done.map_or_else(SocketOutcome::Failed, |()| SocketOutcome::Values(Vec::new())))
        })?;
        match found {
            SocketOutcome::Denied(text, help) => Err(denial(text, help)),
            SocketOutcome::Failed(errno) => status(c, Err(errno)),
            SocketOutcome::Values(_) | SocketOutcome::Waits => status(c, Ok(())),
        }
    };
    Command::new(name, run).param(socket_param()).returns(result())
}

/// Returns the value of an option in argument `i` as bytes. A number is encoded as in ZeroMQ.
fn option_bytes(c: &Ctx<'_>, i: usize) -> Result<Vec<u8>> {
    let value = c.arg(i);
    if let Some(bytes) = value.as_bytes() {
        return Ok(bytes.to_vec());
    }
    value.as_i64().map(|n| n.to_le_bytes().to_vec()).ok_or_else(|| {
        Fail::argument(format!("argument {}: expected bytes, such as `sim.packInt32Table{{100}}`, or a number", i + 1))
    })
}

/// Returns the value of an option for the script.
fn read_option(socket: &Socket, option: i64) -> Result<Value, Errno> {
    socket.with(|state| {
        Ok(match option {
            ROUTING_ID => Value::Bytes(state.options.identity.clone()),
            LAST_ENDPOINT => Value::text(&state.last_endpoint),
            TYPE => Value::Int(state.kind.names().1),
            RCVMORE => Value::Int(i64::from(state.more)),
            EVENTS => Value::Int(events_of(state)),
            _ => Value::Int(state.options.get(option)?),
        })
    })
}

fn get_option(c: &mut Ctx<'_>, name: &'static str, bytes: bool) -> Result {
    let (socket, option) = (c.text(0)?, c.i64(1)?);
    let found = observe(c, name, |_, world| {
        let value = world.socket(&socket).and_then(|socket| read_option(socket, option));
        Ok(value.map_or_else(SocketOutcome::Failed, |value| SocketOutcome::Values(vec![value])))
    })?;
    let value = match found {
        SocketOutcome::Values(values) => values.into_iter().next().ok_or(Errno::INVALID),
        SocketOutcome::Failed(errno) => Err(errno),
        _ => Err(Errno::INVALID),
    };
    let value = match value {
        Ok(Value::Int(n)) if bytes && option == MAXMSGSIZE => Ok(Value::Bytes(n.to_le_bytes().to_vec())),
        Ok(Value::Int(n)) if bytes => Ok(Value::Bytes((n as i32).to_le_bytes().to_vec())),
        Ok(value @ Value::Int(_)) => Ok(value),
        Ok(value) if bytes => Ok(value),
        Ok(_) => Err(Errno::INVALID),
        Err(errno) => Err(errno),
    };
    status(c, value.as_ref().map(drop).map_err(|errno| *errno))?;
    match value {
        Ok(value) => c.ret(value),
        Err(_) if bytes => c.ret(Value::text("")),
        Err(_) => c.ret(0_i64),
    }
    Ok(())
}

pub(crate) fn offer(offer: &mut Offer<Zmq>) {
    contexts(offer);
    offer.command(
        Command::new("simZMQ.socket", |c| {
            let (context, kind) = (c.text(0)?, c.i64(1)?);
            let found = state(c)?.new_socket(&context, kind);
            handle(c, found)
        })
        .param(context())
        .param(Param::int("type").text("`PUB`, `SUB`, `REQ`, `REP`, `DEALER`, `ROUTER`, `PULL` or `PUSH`"))
        .returns(Param::string("socket").text("its handle; empty: failed"))
        .text("Creates a socket.")
        .example("local socket = simZMQ.socket(simZMQ.ctx_new(), simZMQ.REQ)\nassert(simZMQ.close(socket) == 0)"),
    );
    offer.command(
        Command::new("simZMQ.close", |c| {
            let socket = c.text(0)?;
            let done = state(c)?.close_socket(&socket);
            status(c, done)
        })
        .param(socket_param())
        .returns(result())
        .text("Closes a socket. Messages that it has sent are still transferred, for at most half a second.")
        .example("assert(simZMQ.close('none') == -1)"),
    );
    const LOCAL: &str = "`tcp://127.0.0.1:PORT` or `ipc://FILE`";
    offer.command(
        attaching("simZMQ.bind", true, Socket::bind)
            .param(Param::string("endpoint").text(
                "`tcp://127.0.0.1:PORT` or `ipc://FILE`; `*` as the host means 127.0.0.1, as the port any free one",
            ))
            .text("Binds a socket to an endpoint, to which peers can connect. Raises an error if the run is not permitted to use this address.")
            .example("assert(not pcall(simZMQ.bind, 'none', 'tcp://*:5555'))"),
    );
    offer.command(
        attaching("simZMQ.connect", false, Socket::connect)
            .param(Param::string("endpoint").text(LOCAL))
            .text(
                "Connects to a peer as soon as it is available, and reconnects whenever the connection ends. Raises \
                 an error if the run is not permitted to use this address.",
            )
            .example("assert(not pcall(simZMQ.connect, 'none', 'tcp://localhost:5555'))"),
    );
    offer.command(
        attaching("simZMQ.unbind", true, Socket::unbind)
            .param(Param::string("endpoint"))
            .text("Stops listening on an endpoint. Existing connections remain open.")
            .example("assert(not pcall(simZMQ.unbind, 'none', 'tcp://*:5555'))"),
    );
    offer.command(
        attaching("simZMQ.disconnect", false, Socket::disconnect)
            .param(Param::string("endpoint"))
            .text("Ends the connection to an endpoint when all messages that were sent have been transferred.")
            .example("assert(not pcall(simZMQ.disconnect, 'none', 'tcp://localhost:5555'))"),
    );
    options(offer);
}

fn options(offer: &mut Offer<Zmq>) {
    offer.command(
        Command::new("simZMQ.setsockopt", |c| {
            let (socket, option, value) = (c.text(0)?, c.i64(1)?, option_bytes(c, 2)?);
            let done = state(c)?.socket(&socket).and_then(|socket| {
                socket.with(|state| match option {
                    SUBSCRIBE => state.subscribe(&value),
                    UNSUBSCRIBE => state.unsubscribe(&value),
                    _ => state.options.set(option, &value),
                })
            });
            status(c, done)
        })
        .param(socket_param())
        .param(option())
        .param(Param::any("option_value").text("bytes, such as `sim.packInt32Table{n}`, or a number"))
        .returns(result())
        .text("Sets an option of a socket. Options that affect only connections between machines have no effect.")
        .example("assert(simZMQ.setsockopt('none', simZMQ.SUBSCRIBE, '') == -1)"),
    );
    offer.command(
        Command::new("simZMQ.getsockopt", |c| get_option(c, "simZMQ.getsockopt", true))
            .param(socket_param())
            .param(option())
            .param(Param::int("option_len").unit("B").optional().text("ignored"))
            .returns(result())
            .returns(Param::string("value").text("a number has four bytes, and MAXMSGSIZE has eight"))
            .text("Returns the value of an option as bytes.")
            .example("assert(simZMQ.getsockopt('none', simZMQ.LAST_ENDPOINT, 256) == -1)"),
    );
    offer.command(
        Command::new("simZMQ.getsockopt_int", |c| get_option(c, "simZMQ.getsockopt_int", false))
            .param(socket_param())
            .param(option())
            .returns(result())
            .returns(Param::int("value"))
            .text("Returns the value of a numeric option.")
            .example("assert(simZMQ.getsockopt_int('none', simZMQ.RCVMORE) == -1)"),
    );
}

fn contexts(offer: &mut Offer<Zmq>) {
    offer.command(
        Command::new("simZMQ.ctx_new", |c| {
            let found = state(c)?.new_context();
            handle(c, found)
        })
        .returns(Param::string("context").text("its handle"))
        .text("Creates a context, to which sockets belong.")
        .example("assert(simZMQ.ctx_term(simZMQ.ctx_new()) == 0)"),
    );
    offer.command(
        Command::new("simZMQ.ctx_singleton", |c| {
            let found = state(c)?.singleton();
            handle(c, found)
        })
        .returns(Param::string("context").text("its handle"))
        .text("Returns the context that all scripts share.")
        .example("assert(simZMQ.ctx_singleton() == simZMQ.ctx_singleton())"),
    );
    offer.command(
        Command::new("simZMQ.ctx_term", |c| {
            let context = c.text(0)?;
            let done = state(c)?.end_context(&context);
            status(c, done)
        })
        .param(context())
        .returns(result())
        .text(
            "Ends a context: closes its sockets, and waits until their messages have been transferred, at most half a \
             second.",
        )
        .example("assert(simZMQ.ctx_term('none') == -1)"),
    );
    offer.command(
        Command::new("simZMQ.ctx_shutdown", |c| {
            let context = c.text(0)?;
            let done = {
                let mut world = state(c)?;
                world.check_context(&context).map(|()| world.shut_down(&context))
            };
            status(c, done)
        })
        .param(context())
        .returns(result())
        .text("Closes the sockets of a context.")
        .example("assert(simZMQ.ctx_shutdown(simZMQ.ctx_new()) == 0)"),
    );
    offer.command(
        Command::new("simZMQ.ctx_get", |c| {
            let (context, option) = (c.text(0)?, c.i64(1)?);
            let known = state(c)?.check_context(&context);
            let value = known.and_then(|()| {
                CONTEXT_OPTIONS.iter().find(|(_, n, _)| *n == option).map(|(.., value)| *value).ok_or(Errno::INVALID)
            });
            match value {
                Ok(value) => c.ret(value),
                Err(errno) => status(c, Err(errno))?,
            }
            Ok(())
        })
        .param(context())
        .param(Param::int("option_name"))
        .returns(Param::int("result").text("the value; -1: failed"))
        .text("Returns an option of a context.")
        .example("assert(simZMQ.ctx_get(simZMQ.ctx_new(), simZMQ.MAX_SOCKETS) == 64)"),
    );
    offer.command(
        Command::new("simZMQ.ctx_set", |c| {
            let (context, option) = (c.text(0)?, c.i64(1)?);
            let known = state(c)?.check_context(&context);
            let valid = CONTEXT_OPTIONS.iter().any(|(_, n, _)| *n == option);
            status(c, known.and(if valid { Ok(()) } else { Err(Errno::INVALID) }))
        })
        .param(context())
        .param(Param::int("option_name"))
        .param(Param::int("option_value").text("ignored"))
        .returns(result())
        .partial("The value has no effect, because each connection has its own threads.")
        .text("Sets an option of a context.")
        .example("assert(simZMQ.ctx_set(simZMQ.ctx_new(), simZMQ.IO_THREADS, 2) == 0)"),
    );
}

/// Names, numbers and values of the options of contexts.
pub(crate) const CONTEXT_OPTIONS: &[(&str, i64, i64)] =
    &[("IO_THREADS", 1, 1), ("MAX_SOCKETS", 2, 64), ("SOCKET_LIMIT", 3, 64), ("MAX_MSGSZ", 5, 64 << 20)];

/// Returns the names and numbers of all options.
pub(crate) fn option_constants() -> impl Iterator<Item = (&'static str, i64)> {
    options::NAMES.iter().copied().chain(CONTEXT_OPTIONS.iter().map(|(name, number, _)| (*name, *number)))
}
