//! UDP sockets: commands that open them, and send and receive datagrams.

use std::net::SocketAddr;

use tatu_commands_common::permission;
use tatu_plugin_api::safe::{Offer, Param, Value};

use crate::{
    plugin::LuaSocket,
    recording::{address, address_values, allowed, command, failure, or_wrong, port, socket, timeout},
    sockets::{self, CallDeadline},
};

pub(crate) fn offer(offer: &mut Offer<LuaSocket>) {
    offer.command(
        command("luasocket.bindDatagrams", |c, s, _| {
            let n = c.i64(0)?;
            // Neither `*` nor port 0 names a particular address, so any permission suffices.
            let at = match (c.text(1)?.as_str(), port(c, 2)?) {
                ("*", 0) if permission::allows_any(&allowed(c)?) => Ok(SocketAddr::from(([0, 0, 0, 0], 0))),
                _ => address(c, 1)?,
            };
            Ok(or_wrong(at.and_then(sockets::datagrams).map(|socket| {
                if n == 0 {
                    return vec![Value::Int(s.insert(socket))];
                }
                s.replace(n, socket);
                vec![Value::Int(n)]
            })))
        })
        .param(Param::int("socket").text("its number; 0: opens a new socket"))
        .param(Param::string("host").text("`*`: any address of this machine"))
        .param(Param::int("port").text("0: any free port"))
        .returns(Param::int("number").optional())
        .returns(failure())
        .text("Opens a UDP socket, or binds an open one to another address.")
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
        .text("Connects a UDP socket to an address: the socket then sends to this address and receives only from it.")
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
            let done = s.receive_from(c.i64(0)?, most, &CallDeadline::new(c.f64(2)?, ends));
            Ok(or_wrong(done.map(|(bytes, from)| {
                std::iter::once(Value::Bytes(bytes)).chain(from.into_iter().flat_map(address_values)).collect()
            })))
        })
        .param(socket())
        .param(Param::int("most").unit("B").text("longer datagrams are truncated"))
        .param(timeout())
        .returns(Param::string("data").optional())
        .returns(Param::string("address").optional().text("or an error"))
        .returns(Param::int("port").optional())
        .text("Receives a datagram.")
        .example("local data, e = luasocket.receiveFrom(0, 8192, 0)\nassert(e == 'closed')"),
    );
}
