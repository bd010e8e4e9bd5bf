//! Results of a plugin's own threads, for commands that wait for them. They enter the world at the barrier, and the input
//! log records them, so that a replay needs no thread.

use std::{
    cell::{Cell, RefCell},
    collections::BTreeMap,
    sync::Arc,
};

use tatu_plugins::Mailbox;

use super::{Due, WorldCell, input_log::Input, inputs::record_of};

/// The kind of these records in the input log.
const KIND: &str = "wake";

/// The waits for a plugin's threads.
#[derive(Default)]
pub(crate) struct Wakes {
    mailbox: Arc<Mailbox>,
    /// Number of the last wait for which a ticket was issued.
    last: Cell<u64>,
    /// The wait for which the running command took a ticket.
    pub issued: Cell<Option<u64>>,
    /// Results that have entered the world, by the number of their wait.
    arrived: RefCell<BTreeMap<u64, Vec<u8>>>,
    /// The result for the command that is being resumed.
    pub current: RefCell<Vec<u8>>,
}

impl Wakes {
    /// Issues a ticket for a wait of the running command; 0 in a replay, where no thread may be started.
    pub fn ticket(&self, world: &WorldCell) -> u64 {
        let number = self.last.get() + 1;
        self.last.set(number);
        self.issued.set(Some(number));
        if world.run.outside.replay.borrow().is_some() {
            return 0;
        }
        world.model.registry.host().ticket(&self.mailbox, number)
    }
    /// Returns whether the result for a wait has entered the world.
    pub fn has_arrived(&self, number: u64) -> bool {
        self.arrived.borrow().contains_key(&number)
    }
    /// Prepares for a command whose wait has ended: it gets the result.
    pub fn resume(&self, due: &Due) {
        let result = if let Due::Wake(number) = due { self.arrived.borrow_mut().remove(number) } else { None };
        *self.current.borrow_mut() = result.unwrap_or_default();
    }
    /// Returns the number of the last wait, for snapshots.
    pub fn last(&self) -> u64 {
        self.last.get()
    }
    /// Restores the number of the last wait. Results on their way from threads are lost.
    pub fn restore(&self, last: u64) {
        self.last.set(last);
        self.arrived.borrow_mut().clear();
        self.mailbox.take();
    }
}

impl WorldCell {
    /// Returns whether a wait has ended.
    pub fn is_over(&self, due: &Due) -> bool {
        match due {
            Due::Step(s) => self.state.clock.pass.get() >= *s,
            Due::Time(t) => self.state.clock.time.get() >= *t - 1e-9,
            Due::Signal(name) => self.state.signals.borrow().keys().any(|(_, n)| n == name),
            Due::Poll => true,
            Due::Wake(number) => self.run.calls.wakes.has_arrived(*number),
        }
    }
}

/// Takes in the results that have arrived since the last barrier, or those that arrived at this barrier of a replayed
/// run.
pub(crate) fn take_in(world: &WorldCell) {
    let wakes = &world.run.calls.wakes;
    let is_replay = world.run.outside.replay.borrow().is_some();
    let mut found = Vec::new();
    if is_replay {
        let step = world.state.clock.step.get();
        while let Some(text) = replayed(world, step) {
            found.extend(parse(&text));
        }
    } else {
        found = wakes.mailbox.take();
    }
    for (number, result) in found {
        let waits = world.run.calls.waits.borrow().all().iter().any(|w| w.due == Due::Wake(number));
        if !waits && !is_replay {
            // The script that waited has ended.
            continue;
        }
        record_of(world, String::new(), Input::Observed { kind: KIND.into(), text: text(number, &result) });
        wakes.arrived.borrow_mut().insert(number, result);
    }
}

fn replayed(world: &WorldCell, step: u64) -> Option<String> {
    world.run.outside.replay.borrow_mut().as_mut()?.observed_now(step, KIND)
}

fn text(number: u64, result: &[u8]) -> String {
    use std::fmt::Write;
    result.iter().fold(format!("{number} "), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

fn parse(text: &str) -> Option<(u64, Vec<u8>)> {
    let (number, hex) = text.split_once(' ')?;
    let digits =
        hex.as_bytes().chunks_exact(2).map(|pair| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok());
    Some((number.parse().ok()?, digits.collect::<Option<_>>()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_comes_back_from_its_text() {
        for result in [&b""[..], b"\x00\xff done"] {
            assert_eq!(parse(&text(3, result)), Some((3, result.to_vec())));
        }
        assert_eq!(parse("3"), None);
        assert_eq!(parse("x 00"), None);
        assert_eq!(parse("3 zz"), None);
    }
}
