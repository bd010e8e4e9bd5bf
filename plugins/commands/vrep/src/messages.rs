//! Simulator messages: key presses and the like. Each script that asks gets its own copy.

use std::collections::{BTreeMap, VecDeque};

use serde::{Deserialize, Serialize};

use crate::{Vrep, keys, kit::*, state::state};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.getSimulatorMessage", |c| {
            let script = c.caller_script();
            pressed(c)?;
            let message = state(c)?.messages.next(script);
            match message {
                Some((kind, aux)) => {
                    c.ret(kind);
                    c.ret(&aux[..]);
                }
                None => c.ret(-1_i64),
            }
            Ok(())
        })
        .old_name("simGetSimulatorMessage", MINUS)
        .returns(Param::int("message").text("sim.message_...; -1 alone: none waits"))
        .returns(Param::list("auxiliary").text("4 integers; of a key press its code, and 1 for Ctrl plus 2 for Shift"))
        .text("Takes the oldest message that waits for this script.")
        .example("message, aux = sim.getSimulatorMessage()"),
    );
    offer.command(
        Cmd::new("vrep.sendMessage", |c| {
            let kind = c.i64(0)?;
            let v = c.arg(1);
            let aux = [0, 1, 2, 3].map(|i| v.number(i).unwrap_or(0.0) as i64);
            state(c)?.messages.send(kind, aux);
            Ok(())
        })
        .param(Param::int("message").text("sim.message_..."))
        .param(Param::list("auxiliary").optional().text("up to 4 integers"))
        .text(
            "Sends a message to all scripts, as a view does when a key is pressed \
            over it; not of V-REP.",
        )
        .example("vrep.sendMessage(sim.message_keypress, {2007})"),
    );
}

/// Keys that came in since the last look become messages.
fn pressed(c: &Ctx<'_>) -> Result {
    loop {
        let seen = state(c)?.messages.inputs;
        let Some((kind, text)) = c.world().input(seen) else { return Ok(()) };
        state(c)?.messages.inputs = seen + 1;
        match (kind.as_str(), keys::code(&text)) {
            ("key", Some((code, modifiers))) => state(c)?.messages.send(KEY_PRESS, [code, modifiers, 0, 0]),
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

/// A queue per script holds this many messages; the oldest are dropped.
const ROOM: usize = 64;

/// The last messages, and how many each script has taken.
#[derive(Default, Clone, PartialEq, Debug, Serialize, Deserialize)]
pub(crate) struct Messages {
    last: VecDeque<(i64, [i64; 4])>,
    sent: u64,
    taken: BTreeMap<tatu_object, u64>,
    /// How much of what came in from outside has been looked at.
    inputs: u64,
}

impl Messages {
    fn send(&mut self, kind: i64, aux: [i64; 4]) {
        if self.last.len() == ROOM {
            self.last.pop_front();
        }
        self.last.push_back((kind, aux));
        self.sent += 1;
    }
    fn next(&mut self, script: tatu_object) -> Option<(i64, [i64; 4])> {
        let oldest = self.sent - self.last.len() as u64;
        let taken = self.taken.entry(script).or_default();
        *taken = (*taken).max(oldest);
        let message = *self.last.get((*taken - oldest) as usize)?;
        *taken += 1;
        Some(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_script_gets_a_copy() {
        let mut m = Messages::default();
        assert_eq!(m.next(1), None);
        m.send(6, [115, 0, 0, 0]);
        for script in [1, 2] {
            assert_eq!(m.next(script), Some((6, [115, 0, 0, 0])));
            assert_eq!(m.next(script), None);
        }
    }

    #[test]
    fn old_messages_are_dropped() {
        let mut m = Messages::default();
        for i in 0..100 {
            m.send(6, [i, 0, 0, 0]);
        }
        assert_eq!(m.next(1), Some((6, [36, 0, 0, 0])));
        assert_eq!(std::iter::from_fn(|| m.next(1)).count(), 63);
    }
}
