//! Time and steps of a world.

use std::cell::Cell;

/// Time and steps.
pub(crate) struct Clock {
    /// Simulation time, s: step * dt as long as dt does not change.
    pub time: Cell<f64>,
    pub step: Cell<u64>,
    /// Passes since the world was made, those of the stopped world too: what waits for steps counts these.
    pub pass: Cell<u64>,
    pub dt: Cell<f64>,
    /// Physics stages of a whole `dt` in this step,
    whole: Cell<u32>,
    /// and what others of its physics stages took, s.
    rest: Cell<f64>,
}

impl Clock {
    /// At 0.
    pub fn new(dt: f64) -> Self {
        Clock {
            time: Cell::new(0.0),
            step: Cell::new(0),
            pass: Cell::new(0),
            dt: Cell::new(dt),
            whole: Cell::new(0),
            rest: Cell::new(0.0),
        }
    }
    /// Shows what another one shows.
    pub fn like(&self, other: &Clock) {
        self.time.set(other.time.get());
        self.step.set(other.step.get());
        self.pass.set(other.pass.get());
        self.dt.set(other.dt.get());
    }
    /// A physics stage took `dt`: time moves on by it at the end of the step.
    pub fn passed(&self, dt: f64) {
        if dt == self.dt.get() {
            self.whole.set(self.whole.get() + 1);
        } else {
            self.rest.set(self.rest.get() + dt);
        }
    }
    /// What the physics stages of this step have taken so far, s.
    pub fn so_far(&self) -> f64 {
        f64::from(self.whole.get()) * self.dt.get() + self.rest.get()
    }
    /// The end of a step: time is counted in whole steps where it was, so that nothing adds up.
    pub fn advance(&self) {
        let (dt, time) = (self.dt.get(), self.time.get());
        let (whole, rest) = (self.whole.replace(0), self.rest.replace(0.0));
        let counted = (time / dt).round();
        let from_count = counted * dt == time && rest == 0.0;
        let passed = f64::from(whole) * dt + rest;
        self.time.set(if from_count { (counted + f64::from(whole)) * dt } else { time + passed });
        self.step.set(self.step.get() + 1);
        self.count_pass();
    }
    /// A pass that was left out: it counts, and time stands.
    pub fn skip(&self) {
        self.step.set(self.step.get() + 1);
        self.count_pass();
    }
    /// A pass has ended.
    pub fn count_pass(&self) {
        self.pass.set(self.pass.get() + 1);
    }
}

#[cfg(test)]
mod tests {
    use super::Clock;

    #[test]
    fn whole_steps_are_counted_and_others_added() {
        let clock = Clock::new(0.05);
        for n in 1..=10_000_u32 {
            clock.passed(0.05);
            clock.advance();
            // The bits of a product, not of a sum.
            assert_eq!(clock.time.get(), f64::from(n) * 0.05);
        }
        clock.advance();
        assert_eq!((clock.time.get(), clock.step.get()), (500.0, 10_001), "without physics time stands");
        clock.passed(0.05);
        clock.passed(0.05);
        assert_eq!(clock.so_far(), 0.1);
        clock.advance();
        assert_eq!(clock.time.get(), 10_002.0 * 0.05);
        clock.passed(0.013);
        clock.advance();
        assert!((clock.time.get() - 500.113).abs() < 1e-9);
        clock.passed(0.05);
        clock.advance();
        assert!((clock.time.get() - 500.163).abs() < 1e-9);
    }
}
