//! Commands for message objects, errors, versions and capabilities; and the constants.

use tatu_plugin_api::safe::{Command, Constant, Offer, Param, Value};

use crate::{
    errors::{ERRORS, Errno},
    kinds::KINDS,
    routing::MAX_MESSAGE_BYTES,
    sockets::option_constants,
    transfer::{DONTWAIT, POLLIN, POLLOUT, SNDMORE},
    world::{ScriptMessage, Zmq, fail, state, status},
};

/// The version of libzmq whose behaviour the commands reproduce.
const VERSION: [i64; 3] = [4, 3, 5];

fn msg(key: &str) -> Param {
    Param::string(key).text("handle of a message")
}

fn result() -> Param {
    Param::int("result").text("0; -1: failed")
}

/// Builds a command that modifies a message and returns 0, or -1 after a failure.
fn change(
    name: &'static str,
    f: impl Fn(&mut ScriptMessage, i64) -> Result<(), Errno> + Send + Sync + 'static,
) -> Command<Zmq> {
    Command::new(name, move |c| {
        let (message, number) = (c.text(0)?, c.arg(1).as_i64().unwrap_or(0));
        let done = state(c)?.message(&message).and_then(|m| f(m, number));
        status(c, done)
    })
    .param(msg("msg"))
    .returns(result())
}

/// Builds a command that copies or moves the data of a message.
fn transfer(name: &'static str, moves: bool) -> Command<Zmq> {
    Command::new(name, move |c| {
        let (to, from) = (c.text(0)?, c.text(1)?);
        let done = {
            let mut world = state(c)?;
            let source = world.message(&from).map(|m| if moves { std::mem::take(m) } else { m.clone() });
            source.and_then(|source| world.message(&to).map(|place| *place = source))
        };
        status(c, done)
    })
    .param(msg("dest"))
    .param(msg("src"))
    .returns(result())
}

/// Builds a command that returns a numeric property of a message.
fn number(name: &'static str, f: impl Fn(&ScriptMessage) -> i64 + Send + Sync + 'static) -> Command<Zmq> {
    Command::new(name, move |c| {
        let message = c.text(0)?;
        let found = state(c)?.message(&message).map(|m| f(m));
        if let Err(errno) = found {
            fail(c, errno)?;
        }
        c.ret(found.unwrap_or(-1));
        Ok(())
    })
    .param(msg("msg"))
}

pub(crate) fn offer(offer: &mut Offer<Zmq>) {
    offer.command(
        Command::new("simZMQ.msg_new", |c| {
            let found = state(c)?.new_message();
            if let Err(errno) = found {
                fail(c, errno)?;
            }
            c.ret(Value::text(found.unwrap_or_default()));
            Ok(())
        })
        .returns(msg("msg"))
        .text("Creates an empty message.")
        .example("local m = simZMQ.msg_new()\nassert(simZMQ.msg_size(m) == 0)\nsimZMQ.msg_destroy(m)"),
    );
    offer.command(
        Command::new("simZMQ.msg_destroy", |c| {
            let message = c.text(0)?;
            state(c)?.saved.messages.remove(&message);
            Ok(())
        })
        .param(msg("msg"))
        .text("Removes a message.")
        .example("simZMQ.msg_destroy('none')"),
    );
    let empty = |m: &mut ScriptMessage, _: i64| {
        *m = ScriptMessage::default();
        Ok(())
    };
    offer.command(
        change("simZMQ.msg_init", empty)
            .text("Empties a message.")
            .example("assert(simZMQ.msg_init(simZMQ.msg_new()) == 0)"),
    );
    offer.command(
        change("simZMQ.msg_close", empty).text("Empties a message.").example("assert(simZMQ.msg_close('none') == -1)"),
    );
    offer.command(
        change("simZMQ.msg_init_size", |m, size| {
            let size = usize::try_from(size).map_err(|_| Errno::INVALID)?;
            if size > MAX_MESSAGE_BYTES {
                return Err(Errno::TOO_LONG);
            }
            *m = ScriptMessage { data: vec![0; size], more: false };
            Ok(())
        })
        .param(Param::int("size").unit("B"))
        .text("Fills a message with zeros.")
        .example("local m = simZMQ.msg_new()\nsimZMQ.msg_init_size(m, 3)\nassert(simZMQ.msg_data(m) == '\\0\\0\\0')"),
    );
    offer.command(
        transfer("simZMQ.msg_copy", false)
            .text("Copies the data of a message.")
            .example("assert(simZMQ.msg_copy(simZMQ.msg_new(), simZMQ.msg_new()) == 0)"),
    );
    offer.command(
        transfer("simZMQ.msg_move", true)
            .text("Moves the data of a message, which is then empty.")
            .example("assert(simZMQ.msg_move(simZMQ.msg_new(), simZMQ.msg_new()) == 0)"),
    );
    offer.command(
        Command::new("simZMQ.msg_data", |c| {
            let message = c.text(0)?;
            let found = state(c)?.message(&message).map(|m| m.data.clone());
            if let Err(errno) = found {
                fail(c, errno)?;
            }
            c.ret(found.map_or(Value::Nil, Value::Bytes));
            Ok(())
        })
        .param(msg("msg"))
        .returns(Param::string("data").optional())
        .text("Returns the data of a message.")
        .example("assert(simZMQ.msg_data(simZMQ.msg_new()) == '')"),
    );
    offer.command(
        number("simZMQ.msg_size", |m| m.data.len() as i64)
            .returns(Param::int("result").unit("B").text("-1: failed"))
            .text("Returns the size of a message.")
            .example("assert(simZMQ.msg_size('none') == -1)"),
    );
    offer.command(
        number("simZMQ.msg_more", |m| i64::from(m.more))
            .returns(Param::int("result").text("1: further parts follow"))
            .text("Returns whether further parts follow the part that was received last.")
            .example("assert(simZMQ.msg_more(simZMQ.msg_new()) == 0)"),
    );
    properties(offer);
    errors(offer);
    constants(offer);
}

fn properties(offer: &mut Offer<Zmq>) {
    offer.command(
        Command::new("simZMQ.msg_get", |c| {
            let (message, property) = (c.text(0)?, c.i64(1)?);
            let found = state(c)?.message(&message).map(|m| m.more);
            // `MORE` (1) is the only supported property.
            let found = found.and_then(|more| if property == 1 { Ok(i64::from(more)) } else { Err(Errno::INVALID) });
            if let Err(errno) = found {
                fail(c, errno)?;
            }
            c.ret(found.unwrap_or(-1));
            Ok(())
        })
        .param(msg("msg"))
        .param(Param::int("property").text("`simZMQ.MORE`"))
        .returns(Param::int("result").text("the value; -1: failed"))
        .text("Returns a property of a message.")
        .example("assert(simZMQ.msg_get(simZMQ.msg_new(), simZMQ.MORE) == 0)"),
    );
    offer.command(
        change("simZMQ.msg_set", |_, _| Err(Errno::INVALID))
            .param(Param::int("property"))
            .param(Param::int("value"))
            .text("Always fails, as in ZeroMQ, whose messages have no property that can be set.")
            .example("assert(simZMQ.msg_set(simZMQ.msg_new(), 1, 0) == -1)"),
    );
}

fn errors(offer: &mut Offer<Zmq>) {
    offer.command(
        Command::new("simZMQ.errnum", |c| {
            let errno = state(c)?.saved.errno;
            c.ret(errno);
            Ok(())
        })
        .returns(Param::int("result").text("a constant, such as `simZMQ.EAGAIN`"))
        .text("Returns the error of the last call that failed.")
        .example("simZMQ.close('none')\nassert(simZMQ.errnum() == simZMQ.ENOTSOCK)"),
    );
    offer.command(
        Command::new("simZMQ.strerror", |c| {
            c.ret(Value::text(Errno(c.i64(0)?).text()));
            Ok(())
        })
        .param(Param::int("errnum"))
        .returns(Param::string("message"))
        .text("Returns the message for an error number.")
        .example("assert(simZMQ.strerror(simZMQ.ETERM) == 'Context was terminated')"),
    );
    offer.command(
        Command::new("simZMQ.__raiseErrors", |c| {
            let script = c.caller_script();
            let mut world = state(c)?;
            if c.arg(0).truthy() {
                world.saved.raising.insert(script);
            } else {
                world.saved.raising.remove(&script);
            }
            Ok(())
        })
        .param(Param::any("enable"))
        .text("Sets whether failed calls of this script raise errors. By default, they return -1.")
        .example("simZMQ.__raiseErrors(true)\nassert(not pcall(simZMQ.close, 'none'))\nsimZMQ.__raiseErrors(false)"),
    );
    offer.command(
        Command::new("simZMQ.version", |c| {
            VERSION.into_iter().for_each(|part| c.ret(part));
            Ok(())
        })
        .returns(Param::int("major"))
        .returns(Param::int("minor"))
        .returns(Param::int("patch"))
        .text("Returns the version of libzmq whose behaviour the module reproduces.")
        .example("assert(simZMQ.version() == 4)"),
    );
    offer.command(
        Command::new("simZMQ.has", |c| {
            let found = c.text(0)? == "ipc";
            c.ret(i64::from(found));
            Ok(())
        })
        .param(Param::string("capability"))
        .returns(Param::int("result").text("1: provided"))
        .text("Returns whether a capability is supported; only `ipc` is.")
        .example("assert(simZMQ.has('ipc') == 1 and simZMQ.has('curve') == 0)"),
    );
    for (name, text) in [
        ("simZMQ.proxy", "a thread that receives and sends does the same"),
        ("simZMQ.proxy_steerable", "a thread that receives and sends does the same"),
        ("simZMQ.socket_monitor", "connections cannot be watched"),
    ] {
        offer.command(
            Command::new(name, |c| status(c, Err(Errno::UNSUPPORTED)))
                .param(Param::any("arguments").rest())
                .returns(Param::int("result").text("-1"))
                .text("Always fails, with ENOTSUP.")
                .stub(text),
        );
    }
}

fn constants(offer: &mut Offer<Zmq>) {
    let kinds = KINDS.iter().map(|(_, name, number)| (*name, *number));
    let others = [("PAIR", 0), ("XPUB", 9), ("XSUB", 10), ("STREAM", 11), ("MORE", 1), ("SHARED", 3)];
    let flags = [
        ("DONTWAIT", DONTWAIT),
        ("NOBLOCK", DONTWAIT),
        ("SNDMORE", SNDMORE),
        ("POLLIN", POLLIN),
        ("POLLOUT", POLLOUT),
        ("POLLERR", 4),
        ("POLLPRI", 8),
    ];
    let errors = ERRORS.iter().map(|(name, number, _)| (*name, *number));
    for (name, number) in kinds.chain(others).chain(flags).chain(errors).chain(option_constants()) {
        offer.constant(Constant::new(format!("simZMQ.{name}"), number));
    }
}
