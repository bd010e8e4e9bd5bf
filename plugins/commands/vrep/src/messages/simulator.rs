//! Commands on simulator messages such as key presses. Each script that reads messages receives its own copy.

use super::keys;
use crate::{kit::*, state::state};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.getSimulatorMessage", |c| {
            let script = c.caller_script();
            send_pressed_keys(c)?;
            let message = state(c)?.channels.messages.next(script);
            match message {
                Some((kind, aux)) => {
                    c.ret(kind);
                    c.ret(&aux[..]);
                }
                None => c.ret(-1_i64),
            }
            Ok(())
        })
        .old_name("simGetSimulatorMessage", MINUS_ONE)
        .returns(Param::int("message").text("sim.message_...; -1 alone: no message is pending"))
        .returns(Param::list("auxiliary").text("4 integers; for a key press: code, and 1 for Ctrl plus 2 for Shift"))
        .text("Removes and returns the oldest pending message of the calling script.")
        .example("message, aux = sim.getSimulatorMessage()"),
    );
    offer.command(
        Cmd::new("vrep.sendMessage", |c| {
            let kind = c.i64(0)?;
            let v = c.arg(1);
            let aux = [0, 1, 2, 3].map(|i| v.number(i).unwrap_or(0.0) as i64);
            state(c)?.channels.messages.send(kind, aux);
            Ok(())
        })
        .param(Param::int("message").text("sim.message_..."))
        .param(Param::list("auxiliary").optional().text("up to 4 integers"))
        .text("Sends a message to all scripts, as a view does when a key is pressed. An addition to V-REP's API.")
        .example("vrep.sendMessage(sim.message_keypress, {2007})"),
    );
}

/// Converts the keys pressed since the last call to messages.
fn send_pressed_keys(c: &Ctx<'_>) -> Result {
    loop {
        let seen = state(c)?.channels.messages.inputs;
        let Some((kind, text)) = c.world().input(seen) else { return Ok(()) };
        state(c)?.channels.messages.inputs = seen + 1;
        match (kind.as_str(), keys::code(&text)) {
            ("key", Some((code, modifiers))) => state(c)?.channels.messages.send(KEY_PRESS, [code, modifiers, 0, 0]),
            ("key", None) => {
                let text = format!("there is no key `{text}`: expected a character, a name such as `up`, or a code");
                c.world().log(TATU_LOG_WARNING, text.as_bytes());
            }
            _ => {}
        }
    }
}

/// `sim.message_keypress`.
const KEY_PRESS: i64 = 6;
