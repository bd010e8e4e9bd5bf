//! What scripts do with sockets. What each call finds is an input of the run: a run that is repeated opens nothing.

use std::{
    cell::RefMut,
    io,
    net::{Shutdown, SocketAddr},
    time::{Duration, SystemTime, UNIX_EPOCH},
};

use serde_json::{Value as Json, json};
use tatu_plugin_api::{
    abi::*,
    safe::{Call, Command, Fail, Offer, Outcome, Param, Result, Value},
};
use tatu_services_common::json;

use crate::{
    LuaSocket, permission,
    sockets::{self, Patience, Sockets, Want, addresses, words},
};

type Ctx<'a> = Call<'a, LuaSocket>;

/// What a look outside is called in the log of inputs.
const KIND: &str = "socket";
/// How long a refused connection of a thread waits, before the thread goes on in the next step: a program that was started
/// just now needs some time until it listens, and scripts try again at once.
const REFUSED: Duration = Duration::from_millis(20);
/// Commands whose first result is the number of a socket.
const OPENS: [&str; 3] = ["luasocket.listen", "luasocket.accept", "luasocket.bindDatagrams"];

fn text(text: impl AsRef<str>) -> Value {
    Value::text(text.as_ref())
}
/// nil, and what was wrong.
fn wrong(e: &io::Error) -> Vec<Value> {
    vec![Value::Nil, text(words(e))]
}
fn or_wrong(result: io::Result<Vec<Value>>) -> Vec<Value> {
    result.unwrap_or_else(|e| wrong(&e))
}
fn place(at: SocketAddr) -> [Value; 2] {
    [text(at.ip().to_string()), Value::Int(i64::from(at.port()))]
}

fn open<'a>(c: &Ctx<'a>) -> Result<RefMut<'a, Sockets>> {
    c.instance().sockets.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "the sockets are in use"))
}

/// What the person who runs this allows.
fn allowed(c: &Ctx<'_>) -> Result<String> {
    Ok(c.world().get(0, c.plugin().allow)?.as_str().unwrap_or_default().into_owned())
}

/// The address of argument `i`, a host, and the one behind it, a port, if the run may reach it.
fn address(c: &Ctx<'_>, i: usize) -> Result<io::Result<SocketAddr>> {
    let (host, port) = (c.text(i)?, port(c, i + 1)?);
    let allowed = allowed(c)?;
    // Without any permission no name is asked for either.
    let found = if permission::any(&allowed) { addresses(&host, port) } else { Ok(Vec::new()) };
    let found = match found {
        Ok(found) => found,
        Err(e) => return Ok(Err(e)),
    };
    if let Some(at) = found.into_iter().find(|at| permission::allows(&allowed, &host, *at)) {
        return Ok(Ok(at));
    }
    if !c.instance().told.replace(true) {
        let host = if host == "*" { "0.0.0.0" } else { &host };
        let port = if port == 0 { "*".to_owned() } else { port.to_string() };
        let text = format!("a script wants a socket of {host}:{port}, which you may allow: --allow net={host}:{port}");
        c.world().log(TATU_LOG_WARNING, text.as_bytes());
    }
    Ok(Err(io::ErrorKind::PermissionDenied.into()))
}

fn port(c: &Ctx<'_>, i: usize) -> Result<u16> {
    let of_text = || c.text(i).ok().and_then(|t| t.trim().parse::<f64>().ok());
    let number = c.arg(i).as_f64().or_else(of_text).filter(|n| n.fract() == 0.0 && (0.0..65536.0).contains(n));
    number.map(|n| n as u16).ok_or_else(|| Fail::argument(format!("argument {}: expected a port, 0 to 65535", i + 1)))
}

/// Does `look`, unless this run repeats another one; what it finds are the command's results.
fn observe(c: &Ctx<'_>, name: &str, look: impl FnOnce(&Ctx<'_>) -> Result<Vec<Value>>) -> Result<Vec<Value>> {
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
    let strange = || Fail::new(format!("the run that is repeated did something else with its sockets here: {found}"));
    let (then, found): (String, Vec<Json>) = serde_json::from_str(&found).map_err(|_| strange())?;
    if then != name {
        return Err(strange());
    }
    found.iter().map(json::read).collect()
}

fn give(c: &mut Ctx<'_>, values: Vec<Value>) {
    values.into_iter().for_each(|v| c.ret::<Value>(v));
}

/// A command that looks outside.
fn command(
    name: &'static str,
    look: impl Fn(&Ctx<'_>, &mut Sockets, &dyn Fn() -> bool) -> Result<Vec<Value>> + 'static,
) -> Command<LuaSocket> {
    Command::new(name, move |c| {
        let found = observe(c, name, |c| look(c, &mut *open(c)?, &|| c.world().is_interrupted()))?;
        if OPENS.contains(&name) {
            count(c, &found)?;
        }
        give(c, found);
        Ok(())
    })
}

fn connect(c: &mut Ctx<'_>) -> Result<Outcome> {
    if c.resumed() != 0 {
        give(c, wrong(&io::ErrorKind::ConnectionRefused.into()));
        return Ok(Outcome::Done);
    }
    let found = observe(c, "luasocket.connect", |c| {
        let ends = || c.world().is_interrupted();
        let patience = Patience::new(c.f64(2)?, &ends);
        let done = address(c, 0)?.and_then(|to| sockets::connect(to, &patience));
        if done.as_ref().is_err_and(|e| e.kind() == io::ErrorKind::ConnectionRefused) && c.can_wait() {
            std::thread::sleep(REFUSED);
        }
        Ok(or_wrong(done.and_then(|socket| Ok(vec![Value::Int(open_now(c)?.keep(socket))]))))
    })?;
    let refused = wrong(&io::ErrorKind::ConnectionRefused.into());
    if found == refused && c.can_wait() {
        return c.wait_steps(1, 1);
    }
    count(c, &found)?;
    give(c, found);
    Ok(Outcome::Done)
}

/// A run that is repeated opens nothing, and counts as the other one did.
fn count(c: &Ctx<'_>, found: &[Value]) -> Result {
    if let Some(Value::Int(n)) = found.first() {
        let mut sockets = open(c)?;
        sockets.last = sockets.last.max(*n);
    }
    Ok(())
}

fn open_now<'a>(c: &Ctx<'a>) -> io::Result<RefMut<'a, Sockets>> {
    open(c).map_err(|_| io::Error::other("the sockets are in use"))
}

fn want(c: &Ctx<'_>, i: usize) -> Result<Want> {
    Ok(match c.arg(i).as_i64() {
        Some(n) => Want::Count(usize::try_from(n).unwrap_or(0)),
        None => match c.text(i)?.as_str() {
            "*l" => Want::Line,
            "*a" => Want::All,
            other => return Err(Fail::argument(format!("`{other}`: expected \"*l\", \"*a\" or a number of bytes"))),
        },
    })
}

fn numbers(c: &Ctx<'_>, i: usize) -> Vec<i64> {
    c.arg(i).numbers().unwrap_or_default().into_iter().map(|n| n as i64).collect()
}

fn socket() -> Param {
    Param::int("socket").text("its number")
}
fn timeout() -> Param {
    Param::float("timeout").unit("s").text("negative: for ever")
}
fn failure() -> Param {
    Param::string("error").optional().text("as LuaSocket says it: timeout, closed, connection refused")
}

pub(crate) fn offer(offer: &mut Offer<LuaSocket>) {
    offer.command(
        Command::new("luasocket.connect", connect)
            .param(Param::string("host"))
            .param(Param::int("port"))
            .param(timeout())
            .returns(Param::int("socket").optional().text("its number"))
            .returns(failure())
            .text("Connects by TCP. Where nobody listens, a thread goes on in the next step.")
            .example("local n, e = luasocket.connect('127.0.0.1', 9, 1)\nassert(not n and e == 'permission denied')"),
    );
    offer.command(
        command("luasocket.listen", |c, s, _| {
            let done = address(c, 0)?.and_then(sockets::listen);
            Ok(or_wrong(done.map(|socket| vec![Value::Int(s.keep(socket))])))
        })
        .param(Param::string("host").text("`*`: any address of this machine"))
        .param(Param::int("port").text("0: any that is free"))
        .returns(Param::int("socket").optional().text("its number"))
        .returns(failure())
        .text("Waits for connections by TCP.")
        .example("local n, e = luasocket.listen('127.0.0.1', 0)"),
    );
    offer.command(
        command("luasocket.accept", |c, s, ends| {
            let patience = Patience::new(c.f64(1)?, ends);
            Ok(or_wrong(s.accept(c.i64(0)?, &patience).map(|n| vec![Value::Int(n)])))
        })
        .param(socket())
        .param(timeout())
        .returns(Param::int("connection").optional().text("the number of its socket"))
        .returns(failure())
        .text("Takes the next connection.")
        .example("local n, e = luasocket.accept(0, 0)\nassert(e == 'closed')"),
    );
    offer.command(
        command("luasocket.receive", |c, s, ends| {
            let (n, want, mut out) = (c.i64(0)?, want(c, 1)?, c.bytes(2)?.to_vec());
            let done = s.receive(n, want, &mut out, &Patience::new(c.f64(3)?, ends));
            Ok(match done {
                Ok(()) => vec![Value::Bytes(out)],
                Err(e) => vec![Value::Nil, text(words(&e)), Value::Bytes(out)],
            })
        })
        .param(socket())
        .param(Param::any("what").text("\"*l\" a line, \"*a\" all until the end, or a number of bytes"))
        .param(Param::string("prefix").text("what was received before"))
        .param(timeout())
        .returns(Param::string("data").optional())
        .returns(failure())
        .returns(Param::string("partial").optional().text("what came before the error"))
        .text("Receives over a connection.")
        .example("local data, e, part = luasocket.receive(0, '*l', '', 0)\nassert(e == 'closed' and part == '')"),
    );
    offer.command(
        command("luasocket.send", |c, s, ends| {
            let (sent, done) = s.send(c.i64(0)?, c.bytes(1)?, &Patience::new(c.f64(2)?, ends));
            let mut found = vec![Value::Int(sent as i64)];
            found.extend(done.err().map(|e| text(words(&e))));
            Ok(found)
        })
        .param(socket())
        .param(Param::string("data"))
        .param(timeout())
        .returns(Param::int("sent").unit("B"))
        .returns(failure())
        .text("Sends over a connection.")
        .example("local sent, e = luasocket.send(0, 'x', 0)\nassert(sent == 0 and e == 'closed')"),
    );
    offer.command(
        command("luasocket.select", |c, s, ends| {
            let found = s.select(&numbers(c, 0), &numbers(c, 1), &Patience::new(c.f64(2)?, ends));
            Ok(found.map(Value::Ints).to_vec())
        })
        .param(Param::list("read"))
        .param(Param::list("write"))
        .param(timeout())
        .returns(Param::list("readable"))
        .returns(Param::list("writable"))
        .text("Waits until one of some sockets can be read or written.")
        .example("local readable, writable = luasocket.select({}, {}, 0)"),
    );
    offer.command(
        command("luasocket.name", |c, s, _| {
            Ok(or_wrong(s.name(c.i64(0)?, c.arg(1).truthy()).map(|at| place(at).to_vec())))
        })
        .param(socket())
        .param(Param::bool("peer").text("of the other end"))
        .returns(Param::string("address").optional())
        .returns(Param::any("port").optional().text("or an error"))
        .text("Tells where a socket is.")
        .example("local ip, e = luasocket.name(0, false)\nassert(e == 'Bad file descriptor')"),
    );
    offer.command(
        command("luasocket.isDirty", |c, s, _| Ok(vec![Value::Bool(s.is_dirty(c.i64(0)?))]))
            .param(socket())
            .returns(Param::bool("dirty"))
            .text("Tells whether bytes wait that were taken from the system already.")
            .example("assert(not luasocket.isDirty(0))"),
    );
    offer.subject("luasocket");
    closing(offer);
    datagrams(offer);
    names_and_times(offer);
    offer.subject("luasocket");
}

/// What finds nothing is no input: where nothing is open it does nothing.
fn closing(offer: &mut Offer<LuaSocket>) {
    offer.command(
        Command::new("luasocket.close", |c| {
            open(c)?.close(c.i64(0)?);
            Ok(())
        })
        .param(socket())
        .text("Closes a socket; one that is closed stays so.")
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
            open(c)?.shutdown(c.i64(0)?, how);
            Ok(())
        })
        .param(socket())
        .param(Param::string("how").text("send, receive or both"))
        .text("Ends one or both directions of a connection.")
        .example("luasocket.shutdown(0, 'both')"),
    );
    offer.command(
        Command::new("luasocket.setOption", |c| {
            // An option that the system refuses changes nothing, as in most systems.
            let _ = open(c)?.option(c.i64(0)?, &c.text(1)?, c.arg(2).truthy());
            Ok(())
        })
        .param(socket())
        .param(Param::string("option").text("tcp-nodelay or broadcast; others change nothing"))
        .param(Param::any("value"))
        .text("Sets an option.")
        .example("luasocket.setOption(0, 'tcp-nodelay', true)"),
    );
}

fn datagrams(offer: &mut Offer<LuaSocket>) {
    offer.command(
        command("luasocket.bindDatagrams", |c, s, _| {
            let n = c.i64(0)?;
            // Of no port it is asked of whom datagrams go to.
            let at = match (c.text(1)?.as_str(), port(c, 2)?) {
                ("*", 0) if permission::any(&allowed(c)?) => Ok(SocketAddr::from(([0, 0, 0, 0], 0))),
                _ => address(c, 1)?,
            };
            Ok(or_wrong(at.and_then(sockets::datagrams).map(|socket| {
                if n == 0 {
                    return vec![Value::Int(s.keep(socket))];
                }
                s.replace(n, socket);
                vec![Value::Int(n)]
            })))
        })
        .param(Param::int("socket").text("its number; 0: a new one"))
        .param(Param::string("host").text("`*`: any address of this machine"))
        .param(Param::int("port").text("0: any that is free"))
        .returns(Param::int("number").optional())
        .returns(failure())
        .text("Opens a socket for datagrams (UDP).")
        .example("local n, e = luasocket.bindDatagrams(0, '*', 0)"),
    );
    offer.command(
        command("luasocket.connectDatagrams", |c, s, _| {
            let done = address(c, 1)?.and_then(|to| s.datagram(c.i64(0).unwrap_or(0))?.connect(to));
            Ok(or_wrong(done.map(|()| vec![Value::Int(1)])))
        })
        .param(socket())
        .param(Param::string("host"))
        .param(Param::int("port"))
        .returns(Param::int("done").optional().text("1"))
        .returns(failure())
        .text("Hears datagrams of one place alone, and sends there.")
        .example("local done, e = luasocket.connectDatagrams(0, '127.0.0.1', 9)"),
    );
    offer.command(
        command("luasocket.sendTo", |c, s, _| {
            let done =
                address(c, 2)?.and_then(|to| s.datagram(c.i64(0).unwrap_or(0))?.send_to(c.bytes(1).unwrap_or(b""), to));
            Ok(or_wrong(done.map(|n| vec![Value::Int(n as i64)])))
        })
        .param(socket())
        .param(Param::string("data"))
        .param(Param::string("host"))
        .param(Param::int("port"))
        .returns(Param::int("sent").unit("B").optional())
        .returns(failure())
        .text("Sends a datagram.")
        .example("local sent, e = luasocket.sendTo(0, 'x', '127.0.0.1', 9)"),
    );
    offer.command(
        command("luasocket.receiveFrom", |c, s, ends| {
            let most = usize::try_from(c.i64(1)?).unwrap_or(0);
            let done = s.receive_from(c.i64(0)?, most, &Patience::new(c.f64(2)?, ends));
            Ok(or_wrong(done.map(|(bytes, from)| {
                std::iter::once(Value::Bytes(bytes)).chain(from.into_iter().flat_map(place)).collect()
            })))
        })
        .param(socket())
        .param(Param::int("most").unit("B").text("what is longer is cut"))
        .param(timeout())
        .returns(Param::string("data").optional())
        .returns(Param::string("address").optional().text("or an error"))
        .returns(Param::int("port").optional())
        .text("Receives a datagram.")
        .example("local data, e = luasocket.receiveFrom(0, 8192, 0)\nassert(e == 'closed')"),
    );
}

fn names_and_times(offer: &mut Offer<LuaSocket>) {
    offer.command(
        command("luasocket.addresses", |c, _, _| {
            if !permission::any(&allowed(c)?) {
                return Ok(wrong(&io::ErrorKind::PermissionDenied.into()));
            }
            Ok(match addresses(&c.text(0)?, 0) {
                Ok(all) => vec![Value::List(all.iter().map(|at| text(at.ip().to_string())).collect())],
                Err(_) => vec![Value::Nil, text("host not found")],
            })
        })
        .param(Param::string("host"))
        .returns(Param::list("addresses").optional())
        .returns(failure())
        .text("Gives the addresses of a name.")
        .example("local all, e = luasocket.addresses('localhost')"),
    );
    offer.command(
        command("luasocket.time", |c, _, _| {
            let now = if permission::any(&allowed(c)?) {
                SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64()
            } else {
                let epoch = c.world().get(0, c.plugin().epoch)?.as_i64().unwrap_or(0);
                epoch as f64 + c.world().f64(0, c.plugin().clock)?
            };
            Ok(vec![Value::Float(now)])
        })
        .returns(Param::float("time").unit("s"))
        .text(
            "Gives the seconds since 1970 by the clock of this machine, an input of the run, where a run may open sockets; \
             else the date of the start and what clocks show since, the same in each run that is not in real time.",
        )
        .example("assert(luasocket.time() >= 0)"),
    );
    offer.command(
        Command::new("luasocket.sleep", |c| {
            let seconds = c.f64(0)?.max(0.0);
            if permission::any(&allowed(c)?) {
                Patience::new(seconds, &|| c.world().is_interrupted()).wait();
            }
            Ok(())
        })
        .param(Param::float("seconds").unit("s"))
        .text("Stops the whole run for a time by the clock, where a run may open sockets; else it does nothing.")
        .example("luasocket.sleep(0.01)"),
    );
}
