//! Commands on messages: wireless data between objects, and messages to all scripts.

use std::collections::BTreeSet;

use crate::{
    kit::*,
    state::{state, wireless::WirelessMessage},
};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        both(["sim.sendData", "simSendData"], MINUS_ONE, |c| {
            let (w, p) = (c.world(), &c.plugin().p);
            let (now, dt) = (w.f64(0, p.time)?, w.f64(0, p.dt)?);
            let message = WirelessMessage {
                from: c.caller_script(),
                antenna: antenna_argument(c, 4)?,
                target: c.i64(0)?,
                header: c.i64(1)?,
                name: c.bytes(2)?.to_vec(),
                data: c.bytes(3)?.to_vec(),
                radius: if c.has(5) { c.f64(5)? } else { 100.0 },
                until: now + (if c.has(8) { c.f64(8)? } else { 0.0 }).max(dt),
                read: BTreeSet::new(),
            };
            state(c)?.wireless.messages.push(message);
            c.ret(1_i64);
            Ok(())
        })
        .param(Param::int("target").text("a script, its object, or sim.handle_all"))
        .param(Param::int("header"))
        .param(Param::string("name"))
        .param(Param::string("data"))
        .param(Param::int("antenna").default(HANDLE_SELF).optional().text("an object; sim.handle_self: the script's"))
        .param(Param::float("radius").unit("m").default(100.0).optional())
        .param(Param::any("angle1").optional().text("ignored: data is sent in all directions"))
        .param(Param::any("angle2").optional().text("ignored: data is sent in all directions"))
        .param(Param::float("persistence").unit("s").default(0.0).optional().text("0: one step"))
        .returns(Param::int("done"))
        .text("Sends data to scripts whose antenna is in range.")
        .partial("Data is sent in all directions, regardless of the emission angles."),
    );
    offer.command(
        both(["sim.receiveData", "simReceiveData"], NIL, receive)
            .param(Param::int("header").default(-1).optional().text("-1: any"))
            .param(Param::string("name").optional().text("nil: any"))
            .param(Param::int("antenna").default(HANDLE_SELF).optional())
            .param(Param::int("index").default(-1).optional().text("-1: the first one that has not been read yet"))
            .returns(Param::string("data").text("no values if there is no data"))
            .returns(Param::int("sender").text("the script"))
            .returns(Param::int("header"))
            .returns(Param::string("name"))
            .text("Returns data that was sent by `sim.sendData`."),
    );
    offer.command(
        Cmd::new("sim.broadcastMsg", |c| {
            let me = c.caller_script();
            let message = [c.arg(0), handle_value(handle(me))];
            c.world().broadcast("msg", &message, me)
        })
        .param(Param::map("message").text("a table with string keys; `id` states the subject"))
        .param(Param::int("options").default(0).optional().text("ignored"))
        .text("Immediately calls `sysCall_msg` of all other scripts with a message."),
    );
}

fn handle_value<'a>(n: i64) -> ValueRef<'a> {
    // SAFETY: the tag is `TATU_I64`, so the payload is an integer and not a pointer; the value borrows nothing.
    unsafe { ValueRef::new(tatu_value { tag: TATU_I64, reserved: 0, u: tatu_payload { i: n } }) }
}

fn antenna_argument(c: &Ctx<'_>, i: usize) -> Result<tatu_object> {
    if !c.has(i) || matches!(c.i64(i)?, HANDLE_SELF | -9) {
        return Ok(c.caller_object());
    }
    Ok(existing_object(c, i)?.id)
}

fn receive(c: &mut Ctx<'_>) -> Result {
    let (w, me) = (c.world(), c.caller_script());
    let now = w.f64(0, c.plugin().p.time)?;
    let (header, index) = (int_or(c, 0, -1)?, int_or(c, 3, -1)?);
    let name = if c.has(1) { Some(c.bytes(1)?) } else { None };
    let here = antenna_argument(c, 2)?;
    let place = |o: tatu_object| if o == 0 { Ok([0.0; 7]) } else { w.pose(o, 0) };
    let at = place(here)?;
    let messages = {
        let mut state = state(c)?;
        state.wireless.messages.retain(|l| l.until > now - 1e-9);
        state.wireless.messages.clone()
    };
    let mine = |l: &WirelessMessage| {
        let reach =
            || place(l.antenna).is_ok_and(|p| (0..3).map(|k| (p[k] - at[k]).powi(2)).sum::<f64>().sqrt() <= l.radius);
        let target = l.target == HANDLE_ALL || l.target == handle(me) || l.target == handle(c.caller_object());
        (header == -1 || l.header == header) && name.is_none_or(|n| n == l.name) && target && l.from != me && reach()
    };
    let mut found = messages.iter().enumerate().filter(|(_, l)| mine(l));
    let found = match usize::try_from(index) {
        Ok(n) => found.nth(n),
        Err(_) => found.find(|(_, l)| !l.read.contains(&me)),
    };
    let Some((at, message)) = found else { return Ok(()) };
    if index < 0
        && let Some(l) = state(c)?.wireless.messages.get_mut(at)
    {
        l.read.insert(me);
    }
    c.ret(message.data.as_slice());
    c.ret(handle(message.from));
    c.ret(message.header);
    c.ret(message.name.as_slice());
    Ok(())
}
