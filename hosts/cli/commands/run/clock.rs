//! Measures the duration of a run and of its steps.

use std::time::{Duration, Instant};

use hdrhistogram::Histogram;
use serde_json::{Value, json};

/// Longest step duration that can be recorded, ns: one hour. Longer steps are recorded as this value.
const MAX_STEP_NS: u64 = 3_600_000_000_000;
/// Significant decimal digits of recorded durations.
const SIGNIFICANT_DIGITS: u8 = 3;

/// Measures the real time of a run and of each of its steps.
pub struct RunClock {
    began: Instant,
    /// Histogram of step durations, ns; `None` if there is not enough memory.
    steps: Option<Histogram<u64>>,
}

impl RunClock {
    pub fn start() -> Self {
        RunClock { began: Instant::now(), steps: Histogram::new_with_max(MAX_STEP_NS, SIGNIFICANT_DIGITS).ok() }
    }

    /// Calls `step`, which runs a step or waits at the barrier. If it returns `true`, a step was run and its duration
    /// is recorded.
    pub fn step(&mut self, step: impl FnOnce() -> bool) -> bool {
        let begin = Instant::now();
        let done = step();
        if done && let Some(steps) = &mut self.steps {
            steps.saturating_record(u64::try_from(begin.elapsed().as_nanos()).unwrap_or(MAX_STEP_NS));
        }
        done
    }

    pub fn stop(self) -> RunTimes {
        RunTimes { wall: self.began.elapsed(), steps: self.steps }
    }
}

/// The real times that a [`RunClock`] has measured.
pub struct RunTimes {
    pub wall: Duration,
    steps: Option<Histogram<u64>>,
}

impl RunTimes {
    /// Returns the median, 99th percentile and maximum of step durations in s, or null if no step was recorded.
    pub fn step(&self) -> Value {
        let Some(steps) = self.steps.as_ref().filter(|steps| !steps.is_empty()) else { return Value::Null };
        let seconds = |nanoseconds: u64| nanoseconds as f64 * 1e-9;
        json!({
            "median": seconds(steps.value_at_quantile(0.5)),
            "p99": seconds(steps.value_at_quantile(0.99)),
            "max": seconds(steps.max()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_steps_are_timed_without_barriers() {
        let mut clock = RunClock::start();
        assert!(!clock.step(|| false));
        assert_eq!(clock.stop().step(), Value::Null);
        let mut clock = RunClock::start();
        for nanoseconds in [1_000_000_u64, 2_000_000, 9_000_000] {
            clock.steps.as_mut().unwrap().record(nanoseconds).unwrap();
        }
        let steps = clock.stop().step();
        let of = |name: &str| steps[name].as_f64().unwrap();
        assert!((of("median") - 0.002).abs() < 2e-6 && (of("max") - 0.009).abs() < 9e-6 && of("p99") <= of("max"));
    }
}
