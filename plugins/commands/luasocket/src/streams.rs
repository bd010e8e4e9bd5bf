//! Commands for TCP connections, and those that apply to sockets of any kind.

use std::{io, net::Shutdown, time::Duration};

use tatu_plugin_api::safe::{Command, Fail, Offer, Outcome, Param, Result, Value};

use crate::{
    plugin::LuaSocket,
    recording::{
        Ctx, address, address_values, borrow_sockets, command, error_values, failure, observe, or_wrong, return_values,
        socket, text, timeout,
    },
    sockets::{self, CallDeadline, ReceivePattern, error_message},
};

/// Wall-clock delay after a refused connection attempt of a script thread, which then resumes in the next step. A
/// program that has just been started needs some time before it listens, but scripts retry immediately.
const REFUSED_DELAY: Duration = Duration::from_millis(20);

fn connect(c: &mut Ctx<'_>) -> Result<Outcome> {
    if c.resumed() != 0 {
        return_values(c, error_values(&io::ErrorKind::ConnectionRefused.into()));
        return Ok(Outcome::Done);
    }
    let found = observe(c, "luasocket.connect", |c| {
        let ends = || c.world().is_interrupted();
        let deadline = CallDeadline::new(c.f64(2)?, &ends);
        let done = address(c, 0)?.and_then(|to| sockets::connect(to, &deadline));
        if done.as_ref().is_err_and(|e| e.kind() == io::ErrorKind::ConnectionRefused) && c.can_wait() {
            std::thread::sleep(REFUSED_DELAY);
        }
        Ok(match done {
            Ok(socket) => vec![Value::Int(borrow_sockets(c)?.insert(socket))],
            Err(e) => error_values(&e),
        })
    })?;
    let refused = error_values(&io::ErrorKind::ConnectionRefused.into());
    if found == refused && c.can_wait() {
        return c.wait_steps(1, 1);
    }
    return_values(c, found);
    Ok(Outcome::Done)
}

fn receive_pattern(c: &Ctx<'_>, i: usize) -> Result<ReceivePattern> {
    Ok(match c.arg(i).as_i64() {
        Some(n) => ReceivePattern::Count(usize::try_from(n).unwrap_or(0)),
        None => match c.text(i)?.as_str() {
            "*l" => ReceivePattern::Line,
            "*a" => ReceivePattern::All,
            other => {
                return Err(Fail::argument(format!(
                    "argument 2: expected \"*l\", \"*a\" or a number of bytes, found `{other}`"
                )));
            }
        },
    })
}

fn numbers(c: &Ctx<'_>, i: usize) -> Vec<i64> {
    c.arg(i).numbers().unwrap_or_default().into_iter().map(|n| n as i64).collect()
}

pub(crate) fn offer(offer: &mut Offer<LuaSocket>) {
    offer.command(
        Command::new("luasocket.connect", connect)
            .param(Param::string("host"))
            .param(Param::int("port"))
            .param(timeout())
            .returns(Param::int("socket").optional().text("its number"))
            .returns(failure())
            .text("Opens a TCP connection. If it is refused, a thread that calls this resumes in the next step.")
            .example("local n, e = luasocket.connect('127.0.0.1', 9, 1)\nassert(not n and e == 'permission denied')"),
    );
    offer.command(
        command("luasocket.listen", |c, s, _| {
            let done = address(c, 0)?.and_then(sockets::listen);
            Ok(or_wrong(done.map(|socket| vec![Value::Int(s.insert(socket))])))
        })
        .param(Param::string("host").text("`*`: any address of this machine"))
        .param(Param::int("port").text("0: any free port"))
        .returns(Param::int("socket").optional().text("its number"))
        .returns(failure())
        .text("Listens for TCP connections.")
        .example("local n, e = luasocket.listen('127.0.0.1', 0)"),
    );
    offer.command(
        command("luasocket.accept", |c, s, ends| {
            let deadline = CallDeadline::new(c.f64(1)?, ends);
            Ok(or_wrong(s.accept(c.i64(0)?, &deadline).map(|n| vec![Value::Int(n)])))
        })
        .param(socket())
        .param(timeout())
        .returns(Param::int("connection").optional().text("the number of its socket"))
        .returns(failure())
        .text("Accepts the next connection.")
        .example("local n, e = luasocket.accept(0, 0)\nassert(e == 'closed')"),
    );
    offer.command(
        command("luasocket.receive", |c, s, ends| {
            let (n, want, mut out) = (c.i64(0)?, receive_pattern(c, 1)?, c.bytes(2)?.to_vec());
            let done = s.receive(n, want, &mut out, &CallDeadline::new(c.f64(3)?, ends));
            Ok(match done {
                Ok(()) => vec![Value::Bytes(out)],
                Err(e) => vec![Value::Nil, text(error_message(&e)), Value::Bytes(out)],
            })
        })
        .param(socket())
        .param(Param::any("what").text("\"*l\": a line; \"*a\": all bytes until the peer closes; or a number of bytes"))
        .param(Param::string("prefix").text("data that was received before"))
        .param(timeout())
        .returns(Param::string("data").optional())
        .returns(failure())
        .returns(Param::string("partial").optional().text("data received before the error"))
        .text("Receives data from a connection.")
        .example("local data, e, part = luasocket.receive(0, '*l', '', 0)\nassert(e == 'closed' and part == '')"),
    );
    offer.command(
        command("luasocket.send", |c, s, ends| {
            let (sent, done) = s.send(c.i64(0)?, c.bytes(1)?, &CallDeadline::new(c.f64(2)?, ends));
            let mut found = vec![Value::Int(sent as i64)];
            found.extend(done.err().map(|e| text(error_message(&e))));
            Ok(found)
        })
        .param(socket())
        .param(Param::string("data"))
        .param(timeout())
        .returns(Param::int("sent").unit("B"))
        .returns(failure())
        .text("Sends data over a connection.")
        .example("local sent, e = luasocket.send(0, 'x', 0)\nassert(sent == 0 and e == 'closed')"),
    );
    offer.command(
        command("luasocket.select", |c, s, ends| {
            let found = s.select(&numbers(c, 0), &numbers(c, 1), &CallDeadline::new(c.f64(2)?, ends));
            Ok(found.map(Value::Ints).to_vec())
        })
        .param(Param::list("read"))
        .param(Param::list("write"))
        .param(timeout())
        .returns(Param::list("readable"))
        .returns(Param::list("writable"))
        .text("Waits until at least one of the given sockets can be read or written.")
        .example("local readable, writable = luasocket.select({}, {}, 0)"),
    );
    offer.command(
        command("luasocket.name", |c, s, _| {
            Ok(or_wrong(s.name(c.i64(0)?, c.arg(1).truthy()).map(|at| address_values(at).to_vec())))
        })
        .param(socket())
        .param(Param::bool("peer").text("true: the address of the peer"))
        .returns(Param::string("address").optional())
        .returns(Param::any("port").optional().text("or an error"))
        .text("Returns the address of a socket.")
        .example("local ip, e = luasocket.name(0, false)\nassert(e == 'Bad file descriptor')"),
    );
    offer.command(
        command("luasocket.isDirty", |c, s, _| Ok(vec![Value::Bool(s.is_dirty(c.i64(0)?))]))
            .param(socket())
            .returns(Param::bool("dirty"))
            .text("Returns whether the receive buffer contains bytes that no call has returned yet.")
            .example("assert(not luasocket.isDirty(0))"),
    );
    closing(offer);
}

/// Adds the commands that close, shut down and configure a socket. Their calls are not recorded as inputs, because they
/// return nothing, and a replay has no open sockets.
fn closing(offer: &mut Offer<LuaSocket>) {
    offer.command(
        Command::new("luasocket.close", |c| {
            borrow_sockets(c)?.close(c.i64(0)?);
            Ok(())
        })
        .param(socket())
        .text("Closes a socket; closing it again has no effect.")
        .example("luasocket.close(0)"),
    );
    offer.command(
        Command::new("luasocket.shutdown", |c| {
            let how = match c.text(1)?.as_str() {
                "send" => Shutdown::Write,
                "receive" => Shutdown::Read,
                "both" => Shutdown::Both,
                other => {
                    return Err(Fail::argument(format!("`{other}`: expected \"send\", \"receive\" or \"both\"")));
                }
            };
            borrow_sockets(c)?.shutdown(c.i64(0)?, how);
            Ok(())
        })
        .param(socket())
        .param(Param::string("how").text("send, receive or both"))
        .text("Shuts down one or both directions of a connection.")
        .example("luasocket.shutdown(0, 'both')"),
    );
    offer.command(
        Command::new("luasocket.setOption", |c| {
            // An option that the system refuses is ignored, because `setoption` always reports success.
            let _ = borrow_sockets(c)?.option(c.i64(0)?, &c.text(1)?, c.arg(2).truthy());
            Ok(())
        })
        .param(socket())
        .param(Param::string("option").text("tcp-nodelay or broadcast; others have no effect"))
        .param(Param::any("value"))
        .text("Sets an option.")
        .example("luasocket.setOption(0, 'tcp-nodelay', true)"),
    );
}
