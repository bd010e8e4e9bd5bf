//! Commands that subscribe to events and publish them.

use tatu_plugin_api::safe::{Fail, Offer, Param, ValueRef};

use crate::plugin::{Cmd, Tatu};

pub(crate) fn offer(offer: &mut Offer<Tatu>) {
    offer.command(
        Cmd::new("tatu.on", |c| {
            let name = c.text(0)?;
            let handler = c.arg(1).as_func().ok_or_else(|| Fail::argument("argument 2: expected a function"))?;
            let id = c.world().subscribe(&name, handler)?;
            c.ret(id as i64);
            Ok(())
        })
        .param(Param::string("event").text("its name, or * for all except collision, contact and separation"))
        .param(Param::func("handler").text("called with the table of the event's fields and its name"))
        .returns(Param::int("id").text("for tatu.off"))
        .text("Calls a function for each event with this name, until the script ends.")
        .example(
            "local heard = 0\n\
             function sysCall_init()\n  \
               tatu.on('mine.ping', function(e) heard = heard + e.x end)\n\
             end\n\
             function sysCall_actuation()\n  \
               tatu.emit('mine.ping', {x = 2})\n\
             end\n\
             function sysCall_sensing()\n  \
               assert(heard > 0 and heard % 2 == 0)\n\
             end",
        ),
    );
    offer.command(
        Cmd::new("tatu.off", |c| {
            let id = c.i64(0)?;
            c.world().unsubscribe(u64::try_from(id).unwrap_or(0))
        })
        .param(Param::int("id").text("the number that tatu.on returned"))
        .text("Cancels a subscription made by tatu.on.")
        .example(
            "function sysCall_init()\n  \
               local id = tatu.on('mine.gone', function() error('nobody should call this') end)\n  \
               tatu.off(id)\n  \
               tatu.emit('mine.gone')\n\
             end",
        ),
    );
    offer.command(
        Cmd::new("tatu.emit", |c| {
            let name = c.text(0)?;
            let payload = if c.has(1) { c.arg(1) } else { ValueRef::NIL };
            c.world().publish(&name, payload)
        })
        .param(Param::string("event").text("its name, which must contain a dot: mine.name"))
        .param(Param::any("fields").optional().text("a table with string keys"))
        .text("Publishes an event, which is delivered after the current stage.")
        .example(
            "local got\n\
             function sysCall_init()\n  \
               tatu.on('mine.ready', function(e, name) got = name .. e.of end)\n  \
               tatu.emit('mine.ready', {of = 1})\n\
             end\n\
             function sysCall_sensing()\n  \
               assert(got == 'mine.ready1')\n\
             end",
        ),
    );
}
