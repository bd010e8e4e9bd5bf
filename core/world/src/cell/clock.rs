//! Time and step counters of a world.

use std::cell::Cell;

/// Simulation time and step counters.
pub(crate) struct Clock {
    /// Simulation time, s. It equals `step * dt` if no step has run more than one physics stage, nor one of a different
    /// duration.
    pub time: Cell<f64>,
    pub step: Cell<u64>,
    /// Number of passes since the world was created, including those while it is stopped. A command that waits for a
    /// number of steps counts passes.
    pub pass: Cell<u64>,
    pub dt: Cell<f64>,
    /// Number of physics stages in this step that took a whole `dt`, or 1 for a step without physics.
    full_stages: Cell<u32>,
    /// Total duration of the other physics stages of this step, s.
    partial_s: Cell<f64>,
}

impl Clock {
    /// Creates a clock at time 0.
    pub fn new(dt: f64) -> Self {
        Clock {
            time: Cell::new(0.0),
            step: Cell::new(0),
            pass: Cell::new(0),
            dt: Cell::new(dt),
            full_stages: Cell::new(0),
            partial_s: Cell::new(0.0),
        }
    }
    /// Copies the time, the counters and `dt` of another clock.
    pub fn copy_from(&self, other: &Clock) {
        self.time.set(other.time.get());
        self.step.set(other.step.get());
        self.pass.set(other.pass.get());
        self.dt.set(other.dt.get());
    }
    /// Records a physics stage of duration `dt`; time advances by it at the end of the step.
    pub fn record_stage(&self, dt: f64) {
        if dt == self.dt.get() {
            self.full_stages.set(self.full_stages.get() + 1);
        } else {
            self.partial_s.set(self.partial_s.get() + dt);
        }
    }
    /// Returns whether time advances at the end of this step.
    pub fn has_stages(&self) -> bool {
        self.elapsed_in_step() > 0.0
    }
    /// Returns the total duration of the physics stages of this step so far, s.
    pub fn elapsed_in_step(&self) -> f64 {
        f64::from(self.full_stages.get()) * self.dt.get() + self.partial_s.get()
    }
    /// Ends a step. If the time is a multiple of `dt`, it is computed as a product, so that rounding errors do not
    /// accumulate.
    pub fn advance(&self) {
        let (dt, time) = (self.dt.get(), self.time.get());
        let (whole, rest) = (self.full_stages.replace(0), self.partial_s.replace(0.0));
        let counted = (time / dt).round();
        let from_count = counted * dt == time && rest == 0.0;
        let passed = f64::from(whole) * dt + rest;
        self.time.set(if from_count { (counted + f64::from(whole)) * dt } else { time + passed });
        self.step.set(self.step.get() + 1);
        self.count_pass();
    }
    /// Counts a step whose pass was skipped. Time does not advance.
    pub fn skip(&self) {
        self.step.set(self.step.get() + 1);
        self.count_pass();
    }
    /// Counts a completed pass.
    pub fn count_pass(&self) {
        self.pass.set(self.pass.get() + 1);
    }
}

#[cfg(test)]
mod tests {
    use super::Clock;

    #[test]
    fn full_steps_are_multiplied_and_partial_steps_summed() {
        let clock = Clock::new(0.05);
        for n in 1..=10_000_u32 {
            clock.record_stage(0.05);
            clock.advance();
            // The result has the bits of a product, not of a sum.
            assert_eq!(clock.time.get(), f64::from(n) * 0.05);
        }
        clock.advance();
        assert_eq!((clock.time.get(), clock.step.get()), (500.0, 10_001), "without a recorded stage time stands");
        clock.record_stage(0.05);
        clock.record_stage(0.05);
        assert_eq!(clock.elapsed_in_step(), 0.1);
        clock.advance();
        assert_eq!(clock.time.get(), 10_002.0 * 0.05);
        clock.record_stage(0.013);
        clock.advance();
        assert!((clock.time.get() - 500.113).abs() < 1e-9);
        clock.record_stage(0.05);
        clock.advance();
        assert!((clock.time.get() - 500.163).abs() < 1e-9);
    }
}
