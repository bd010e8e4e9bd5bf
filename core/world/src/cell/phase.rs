//! The phases that a run passes through.
//!
//! ```text
//! stopped -> first -> running -> stopping -> last -> stopped
//!                     running -> last before pause -> paused -> first after pause -> running
//! ```
//!
//! Stops and pauses are requests. The phase changes only after a pass, so the pass in which a script makes the request
//! ends like any other, and readers of the phase see a stop two passes in advance.

use serde::{Deserialize, Serialize};
use tatu_plugin_api::abi::*;

/// The phase of a run, with the values of `TATU_PHASE_*`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Phase {
    /// The simulation has not been started, or has been stopped.
    #[default]
    Stopped = TATU_PHASE_STOPPED as isize,
    /// The first pass of a run.
    First = TATU_PHASE_FIRST as isize,
    /// Any pass between the first and the last ones.
    Running = TATU_PHASE_RUNNING as isize,
    /// A pause was requested; simulation time does not advance after this pass.
    LastBeforePause = TATU_PHASE_LAST_BEFORE_PAUSE as isize,
    /// The simulation is paused.
    Paused = TATU_PHASE_PAUSED as isize,
    /// The first pass after a pause.
    FirstAfterPause = TATU_PHASE_FIRST_AFTER_PAUSE as isize,
    /// A stop was requested; one more pass follows.
    Stopping = TATU_PHASE_STOPPING as isize,
    /// The last pass, at the end of which the scripts of the run clean up.
    Last = TATU_PHASE_LAST as isize,
}

impl Phase {
    /// Returns the phase after a pass in this phase.
    pub(crate) fn after(self, stop: bool, pause: bool) -> Phase {
        match self {
            Phase::First | Phase::FirstAfterPause => Phase::Running,
            Phase::Running if stop => Phase::Stopping,
            Phase::Running if pause => Phase::LastBeforePause,
            Phase::LastBeforePause => Phase::Paused,
            Phase::Stopping => Phase::Last,
            Phase::Last => Phase::Stopped,
            Phase::Running | Phase::Paused | Phase::Stopped => self,
        }
    }

    /// Returns whether a pause may be requested.
    pub(crate) fn accepts_pause(self) -> bool {
        matches!(self, Phase::First | Phase::Running | Phase::FirstAfterPause)
    }

    /// Returns whether the run is about to end.
    pub(crate) fn is_ending(self) -> bool {
        matches!(self, Phase::Stopping | Phase::Last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the phases of the passes from `from` to `to`, with the requests pending throughout.
    fn passes(mut from: Phase, to: Phase, stop: bool, pause: bool) -> Vec<Phase> {
        let mut out = Vec::new();
        while from != to {
            out.push(from);
            from = from.after(stop, pause);
        }
        out
    }

    // See tests/facts/call-order.md, section 1, for a stop, a pause, and a pause at a script error. After the first
    // step, there is one ordinary step in between.
    #[test]
    fn stop_and_pause_requests_need_the_observed_number_of_passes() {
        use Phase::*;
        assert_eq!(passes(Running, Stopped, true, false), [Running, Stopping, Last]);
        assert_eq!(passes(Running, Paused, false, true), [Running, LastBeforePause]);
        assert_eq!(passes(First, Paused, false, true), [First, Running, LastBeforePause]);
        assert_eq!(passes(FirstAfterPause, Stopped, true, false), [FirstAfterPause, Running, Stopping, Last]);
        // A stop takes precedence over a pause.
        assert_eq!(passes(Running, Stopped, true, true), [Running, Stopping, Last]);
    }
}
