//! The pace of simulation time in a world that is shown. The clock only decides when a step is run, and never affects
//! its results.

use std::{
    sync::mpsc::{self, RecvTimeoutError, Sender},
    thread::JoinHandle,
    time::{Duration, Instant},
};

use tatu_plugin_api::safe::Session;

/// Slowest and fastest pace, as multiples of real time.
pub const SPEEDS: (f64, f64) = (0.125, 40.0);
/// Delays longer than this, s, are not caught up.
const LATE: f64 = 0.25;

/// The pace, and a thread that wakes the session when the next step is due.
pub struct Pace {
    /// Multiple of real time; 0: as fast as possible.
    pub speed: f64,
    from: Option<(Instant, f64)>,
    alarm: Option<Sender<Instant>>,
    thread: Option<JoinHandle<()>>,
}

impl Pace {
    /// Creates a pace that begins now.
    pub fn new(speed: f64, session: Session) -> Self {
        let (alarm, due) = mpsc::channel::<Instant>();
        let ring = move || {
            let mut next: Option<Instant> = None;
            loop {
                let left = next.map_or(Duration::from_secs(3600), |n| n.saturating_duration_since(Instant::now()));
                match due.recv_timeout(left) {
                    Ok(at) => next = Some(next.map_or(at, |n| n.min(at))),
                    Err(RecvTimeoutError::Timeout) => {
                        next = None;
                        session.wake();
                    }
                    Err(RecvTimeoutError::Disconnected) => return,
                }
            }
        };
        let thread = std::thread::Builder::new().name("pace".into()).spawn(ring).ok();
        Pace { speed, from: None, alarm: Some(alarm), thread }
    }
    /// Restarts the measurement of time: after a pause, a start, or a change of the speed.
    pub fn again(&mut self) {
        self.from = None;
    }
    /// Returns whether the next step is due; if not, the session is woken when it is.
    pub fn is_due(&mut self, time: f64) -> bool {
        if self.speed <= 0.0 {
            return true;
        }
        let now = Instant::now();
        let (began, at) = *self.from.get_or_insert((now, time));
        let ahead = (time - at) / self.speed - (now - began).as_secs_f64();
        if ahead < -LATE {
            self.from = Some((now, time));
        }
        if ahead <= 0.0 {
            return true;
        }
        if let Some(alarm) = &self.alarm {
            let _ = alarm.send(now + Duration::from_secs_f64(ahead.min(1.0)));
        }
        false
    }
}

impl Drop for Pace {
    fn drop(&mut self) {
        self.alarm = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
