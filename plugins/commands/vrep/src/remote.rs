//! Commands with which scripts open ports for remote clients. They only notify the service that listens on the ports.

use crate::kit::*;

const NOTES: &str =
    "Requires the service `legacy_remote`; without it, no port is opened. A port is closed when the simulation stops.";
/// The events that notify the service.
const OPEN_EVENT: &str = "remote_api.open";
const CLOSE_EVENT: &str = "remote_api.close";

/// Publishes an event that requests that the service open or close the port in argument 0.
fn publish_port_event(c: &Ctx<'_>, event: &str) -> Result {
    let port = c.i64(0)?;
    if !(1..=65535).contains(&port) {
        return Err(Fail::unsupported(format!(
            "argument 1: expected a port from 1 to 65535, found {port}; shared memory is not supported"
        )));
    }
    c.world().publish_value(event, &Value::Map(vec![(Value::text("port"), Value::Int(port))]))
}

fn return_success(c: &mut Ctx<'_>) -> Result {
    c.ret(1_i64);
    Ok(())
}

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let port = || Param::int("port");
    let result = || Param::int("result").text("1");
    offer.command(
        Cmd::new("simRemoteApi.start", |c| {
            publish_port_event(c, OPEN_EVENT)?;
            return_success(c)
        })
        .old_name("simExtRemoteApiStart", MINUS_ONE)
        .param(port())
        .param(Param::any("options").rest().text("packet size, debug, trigger: ignored; a client can always step"))
        .returns(result())
        .text("Opens a port for clients of the legacy remote API.")
        .example("simRemoteApi.start(19999)")
        .partial(NOTES),
    );
    offer.command(
        Cmd::new("simRemoteApi.stop", |c| {
            publish_port_event(c, CLOSE_EVENT)?;
            return_success(c)
        })
        .old_name("simExtRemoteApiStop", MINUS_ONE)
        .param(port())
        .returns(result())
        .text("Closes a port that a script opened.")
        .example("simRemoteApi.stop(19999)")
        .partial(NOTES),
    );
    offer.command(
        Cmd::new("simRemoteApi.reset", |c| {
            publish_port_event(c, CLOSE_EVENT)?;
            publish_port_event(c, OPEN_EVENT)?;
            return_success(c)
        })
        .old_name("simExtRemoteApiReset", MINUS_ONE)
        .param(port())
        .returns(result())
        .text("Closes a port that a script opened, and opens it again.")
        .example("simRemoteApi.reset(19999)")
        .partial(NOTES),
    );
    for (name, text) in [(OPEN_EVENT, "A script requests a port."), (CLOSE_EVENT, "A script closes a port.")] {
        offer.event(Event::new(name).text(text).field(Param::int("port").text("its TCP port")));
    }
}
