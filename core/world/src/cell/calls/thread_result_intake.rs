//! Adds the results of plugins' threads to the world at the barrier, and records them in the input log, so that a
//! replay does not need the threads.

use crate::cell::{WaitCondition, WorldCell, session::input_log::ExternalInput, session::inputs::record_input};

/// The kind of the records of such results in the input log.
const RECORD_KIND: &str = "wake";

impl WorldCell {
    /// Returns whether the condition under which a command is resumed is met.
    pub fn is_condition_met(&self, due: &WaitCondition) -> bool {
        match due {
            WaitCondition::Step(s) => self.state.clock.pass.get() >= *s,
            WaitCondition::Time(t) => self.state.clock.time.get() >= *t - 1e-9,
            WaitCondition::Signal(name) => self.state.signals.borrow().keys().any(|(_, n)| n == name),
            WaitCondition::Poll => true,
            WaitCondition::Wake(number) => self.run.calls.thread_results.has_arrived(*number),
        }
    }
}

/// Adds the results that have arrived since the last barrier or, in a replay, those that arrived at this barrier of the
/// recorded run.
pub(crate) fn collect_results(world: &WorldCell) {
    let wakes = &world.run.calls.thread_results;
    let is_replay = world.run.connections.record.replay.borrow().is_some();
    let mut found = Vec::new();
    if is_replay {
        let step = world.state.clock.step.get();
        while let Some(text) = next_replayed(world, step) {
            found.extend(parse(&text));
        }
    } else {
        wakes.mark_unissued_lost();
        found = wakes.take();
    }
    for (number, result) in found {
        let waits = world.run.calls.waits.borrow().all().iter().any(|w| w.due == WaitCondition::Wake(number));
        if !waits && !is_replay {
            // The script or service that waited for the result has ended.
            continue;
        }
        record_input(
            world,
            String::new(),
            ExternalInput::Observed { kind: RECORD_KIND.into(), text: text(number, &result) },
        );
        wakes.add_result(number, result);
    }
}

fn next_replayed(world: &WorldCell, step: u64) -> Option<String> {
    world.run.connections.record.replay.borrow_mut().as_mut()?.observed_now(step, RECORD_KIND)
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
    fn result_round_trips_through_its_text() {
        for result in [&b""[..], b"\x00\xff done"] {
            assert_eq!(parse(&text(3, result)), Some((3, result.to_vec())));
        }
        assert_eq!(parse("3"), None);
        assert_eq!(parse("x 00"), None);
        assert_eq!(parse("3 zz"), None);
    }
}
