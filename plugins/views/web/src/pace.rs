//! Slows the simulation down to a multiple of real time. The clock only determines when a step is run; it never affects
//! the results of the step.

use std::{
    sync::mpsc::{self, RecvTimeoutError, Sender},
    thread::JoinHandle,
    time::{Duration, Instant},
};

use tatu_plugin_api::safe::Session;

/// Minimum and maximum speed, as multiples of real time.
pub const SPEED_RANGE: (f64, f64) = (0.125, 40.0);
/// Maximum delay that is caught up by running faster, in seconds of real time.
const MAX_CATCH_UP_S: f64 = 0.25;

/// The speed of the simulation, and a thread that wakes the session when the next step is due.
pub struct RealTimePacer {
    /// Speed as a multiple of real time; 0: as fast as possible.
    pub speed: f64,
    /// Reference for the pace: a real time, and the simulation time at that moment, s.
    reference: Option<(Instant, f64)>,
    /// Sends the thread the time at which it must wake the session; `None` ends the thread.
    alarm: Option<Sender<Instant>>,
    thread: Option<JoinHandle<()>>,
}

impl RealTimePacer {
    /// Creates a pacer and starts its thread.
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
        RealTimePacer { speed, reference: None, alarm: Some(alarm), thread }
    }
    /// Resets the reference time. Must be called after a pause, a start, or a change of the speed.
    pub fn reset(&mut self) {
        self.reference = None;
    }
    /// Returns whether the step at this simulation time, s, is due. If it is not, the session is woken later.
    pub fn is_due(&mut self, time: f64) -> bool {
        if self.speed <= 0.0 {
            return true;
        }
        let now = Instant::now();
        let (began, at) = *self.reference.get_or_insert((now, time));
        let ahead = (time - at) / self.speed - (now - began).as_secs_f64();
        if ahead < -MAX_CATCH_UP_S {
            self.reference = Some((now, time));
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

impl Drop for RealTimePacer {
    fn drop(&mut self) {
        self.alarm = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
