//! Commands on communication tubes, which transfer packets between two scripts in order.

use crate::{kit::*, state::state};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.tubeOpen", |c| {
            let (header, name, room) = (c.i64(0)?, c.bytes(1)?.to_vec(), int_or(c, 2, 1)?);
            let tube = state(c)?.channels.tubes.open(header, name, room);
            c.ret(tube.unwrap_or(-1));
            Ok(())
        })
        .old_name("simTubeOpen", MINUS_ONE)
        .param(Param::int("header").text("any number, which identifies the tube together with the name"))
        .param(Param::string("name"))
        .param(
            Param::int("readBufferSize")
                .default(1)
                .optional()
                .text("maximum number of packets waiting at this end; the oldest is dropped"),
        )
        .param(Param::any("unused").optional())
        .returns(Param::int("tube").text("-1: both ends are already open"))
        .text("Opens one end of a tube; the second script that opens it gets the other end.")
        .example("tube = sim.tubeOpen(0, 'robot_2D_SCANNER_DATA', 1)"),
    );
    offer.command(
        Cmd::new("sim.tubeWrite", |c| {
            let (tube, data) = (c.i64(0)?, c.bytes(1)?.to_vec());
            let sent = state(c)?.channels.tubes.write(tube, data);
            c.ret(i64::from(sent));
            Ok(())
        })
        .old_name("simTubeWrite", MINUS_ONE)
        .param(Param::int("tube"))
        .param(Param::string("data").text("any bytes"))
        .returns(Param::int("sent").text("1; 0: the other end is not open"))
        .text("Sends a packet to the other end of a tube; without a partner, the packet is silently lost.")
        .example("sim.tubeWrite(tube, sim.packFloatTable(points))"),
    );
    offer.command(
        Cmd::new("sim.tubeRead", read)
            .old_name("simTubeRead", NIL)
            .param(Param::int("tube"))
            .param(Param::any("blocking").optional().text("true: waits for a packet if the caller can wait"))
            .returns(Param::string("data").text("no value if no packet is available"))
            .text("Removes and returns the oldest packet at this end of a tube.")
            .example("data = sim.tubeRead(tube)"),
    );
    offer.command(
        Cmd::new("sim.tubeStatus", |c| {
            let tube = c.i64(0)?;
            let status = state(c)?.channels.tubes.status(tube);
            if let Some((connected, here, there)) = status {
                c.ret(i64::from(connected));
                c.ret(here as i64);
                c.ret(there as i64);
            }
            Ok(())
        })
        .old_name("simTubeStatus", NIL)
        .param(Param::int("tube"))
        .returns(Param::int("connected").text("1 or 0; no value if there is no such tube"))
        .returns(Param::int("readable").text("packets waiting at this end"))
        .returns(Param::int("written").text("packets waiting at the other end"))
        .text("Returns whether a tube has a partner, and how many packets are waiting.")
        .example("connected = sim.tubeStatus(tube)"),
    );
    offer.command(
        Cmd::new("sim.tubeClose", |c| {
            let tube = c.i64(0)?;
            let was_open = state(c)?.channels.tubes.close(tube);
            c.ret(i64::from(was_open));
            Ok(())
        })
        .old_name("simTubeClose", MINUS_ONE)
        .param(Param::int("tube"))
        .returns(Param::int("closed").text("1 or 0"))
        .text("Closes one end of a tube.")
        .example("sim.tubeClose(tube)"),
    );
}

fn read(c: &mut Ctx<'_>) -> Result<Outcome> {
    // When the thread resumes, the command is called again with the resume word, which is the tube's number plus 1,
    // because 0 means that this is the first call.
    let tube = match c.resumed() {
        0 => c.i64(0)?,
        word => word as i64 - 1,
    };
    let blocking = c.resumed() != 0 || c.arg(1).truthy();
    let packet = state(c)?.channels.tubes.read(tube);
    match packet {
        Some(data) => c.ret(data.as_slice()),
        None if blocking && tube >= 0 && c.can_wait() => return c.wait_poll(tube as u64 + 1),
        None => {}
    }
    Ok(Outcome::Done)
}
