//! The cost of commands for the script that calls them, in instructions, and the time at which a script must return.
//!
//! A command runs outside the script's language, which cannot count its work. The host therefore counts it, by amounts
//! that depend only on what the command does, never on time. All amounts are estimates: a script in a release build
//! executes about 50 instructions in a microsecond, so each amount is 50 times the duration of the work in
//! microseconds.

use std::{
    cell::Cell,
    time::{Duration, Instant},
};

/// Cost of each call of a command.
pub const COMMAND_COST: u64 = 20;
/// Cost of an object that is created, copied or removed.
pub const OBJECT_COST: u64 = 100;
/// Cost of an object that is examined during a search.
pub const LOOKUP_COST: u64 = 5;
/// Cost of two forms whose distance is computed.
pub const PAIR_COST: u64 = 200;
/// Cost of a file that is read or written.
pub const FILE_COST: u64 = 5000;
/// Cost of a stage that a driver runs.
pub const STAGE_COST: u64 = 5000;

/// Time within which a script must return after a stop was requested from outside, such as by Ctrl-C.
const STOP_GRACE_PERIOD: Duration = Duration::from_secs(1);

/// The work of the commands that a script calls, in the innermost call into a script that is running.
#[derive(Default)]
pub struct CommandCost {
    spent: Cell<u64>,
    /// Maximum of `spent`; 0 if no script is running or there is no limit.
    limit: Cell<u64>,
    /// Time at which the script was first observed to be still running after a stop had been requested.
    stop_noticed_at: Cell<Option<Instant>>,
}

/// The cost of the surrounding call, which [`CommandCost::end`] restores.
pub struct OuterCost(u64, u64);

impl CommandCost {
    /// Begins a call into a script whose commands may cost `limit`; 0 means no limit. `is_outermost` is set if no other
    /// script is running.
    pub fn begin(&self, limit: u64, is_outermost: bool) -> OuterCost {
        if is_outermost {
            self.stop_noticed_at.set(None);
        }
        OuterCost(self.spent.replace(0), self.limit.replace(limit))
    }

    /// Ends a call into a script, and returns what its commands have cost.
    pub fn end(&self, outer: OuterCost) -> u64 {
        self.limit.set(outer.1);
        self.spent.replace(outer.0)
    }

    /// Adds the cost of work.
    #[inline]
    pub fn charge(&self, cost: u64) {
        self.spent.set(self.spent.get().saturating_add(cost));
    }

    /// Returns the limit if the running script's commands have cost more.
    #[inline]
    pub fn exceeded(&self) -> Option<u64> {
        let limit = self.limit.get();
        (limit > 0 && self.spent.get() > limit).then_some(limit)
    }

    /// Returns whether the running script must return, because it has not done so for a second after a stop was
    /// requested. Must be called only while a stop is requested.
    pub fn is_overdue(&self) -> bool {
        match self.stop_noticed_at.get() {
            Some(since) => since.elapsed() >= STOP_GRACE_PERIOD,
            None => {
                self.stop_noticed_at.set(Some(Instant::now()));
                false
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nested_calls_are_charged_separately() {
        let cost = CommandCost::default();
        cost.charge(1_000_000);
        assert_eq!(cost.exceeded(), None, "without a script, there is no limit");
        let outer = cost.begin(100, true);
        cost.charge(100);
        assert_eq!(cost.exceeded(), None);
        let inner = cost.begin(10, false);
        assert_eq!(cost.exceeded(), None);
        cost.charge(11);
        assert_eq!(cost.exceeded(), Some(10));
        assert_eq!(cost.end(inner), 11);
        assert_eq!(cost.exceeded(), None);
        cost.charge(u64::MAX);
        assert_eq!(cost.exceeded(), Some(100));
        assert_eq!(cost.end(outer), u64::MAX);
        assert_eq!(cost.exceeded(), None);
    }
}
