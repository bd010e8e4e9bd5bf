//! Limits the time for which a client that controls the stepping may hold the simulation without sending a message, for
//! example because it was stopped in a debugger. After this time, the simulation continues without the client.

use std::time::{Duration, Instant};

use tatu_plugin_api::{
    abi::TATU_LOG_WARNING,
    safe::{Param, Params, Result, Session},
};

/// Name of the service parameter that sets the limit.
const KEY: &str = "hold_timeout";
/// Default limit, s; the same as in V-REP.
const DEFAULT_S: f64 = 600.0;

/// The limit that the user has set; `None` if there is no limit.
#[derive(Debug, Clone, Copy)]
pub struct HoldLimit(Option<Duration>);

impl HoldLimit {
    /// Returns the declaration of the parameter.
    pub fn param() -> Param {
        Param::float(KEY).unit("s").range(0.0, 1e6).default(DEFAULT_S).text(
            "time without a message after which a client that controls the stepping loses this control; 0: unlimited",
        )
    }
    /// Reads the limit from the parameters of the service.
    pub fn read(params: &Params<'_>) -> Result<Self> {
        let seconds = params.f64(KEY)?;
        Ok(HoldLimit((seconds > 0.0).then(|| Duration::from_secs_f64(seconds))))
    }
}

/// Measures how long a client has held the simulation without sending a message.
#[derive(Debug, Default)]
pub struct HoldTimer {
    since: Option<Instant>,
}

impl HoldTimer {
    /// Restarts the timer, because the client has sent a message.
    pub fn restart(&mut self) {
        self.since = None;
    }
    /// Returns whether the client has held the simulation for longer than the limit. `holds` is whether it holds the
    /// simulation now; if not, the timer is reset.
    pub fn is_over(&mut self, holds: bool, limit: HoldLimit) -> bool {
        let Some(limit) = limit.0.filter(|_| holds) else {
            self.since = None;
            return false;
        };
        self.since.get_or_insert_with(Instant::now).elapsed() >= limit
    }
}

/// Logs a warning that the simulation continues without waiting for a client.
pub fn report(session: &Session, service: &str, client: u64, limit: HoldLimit) {
    let seconds = limit.0.unwrap_or_default().as_secs_f64();
    session.log(
        TATU_LOG_WARNING,
        &format!(
            "{service}: client {client} held the simulation for {seconds} s without sending a message, so it no longer \
             controls the stepping; the parameter `{KEY}_s` of the service sets this limit"
        ),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_runs_out_while_a_holding_client_is_silent() {
        let (limit, mut timer) = (HoldLimit(Some(Duration::from_millis(30))), HoldTimer::default());
        assert!(!timer.is_over(true, limit));
        std::thread::sleep(Duration::from_millis(40));
        timer.restart();
        assert!(!timer.is_over(true, limit), "a message restarts the time");
        std::thread::sleep(Duration::from_millis(40));
        assert!(!timer.is_over(false, limit), "the client does not hold the simulation");
        assert!(!timer.is_over(true, limit));
        std::thread::sleep(Duration::from_millis(40));
        assert!(timer.is_over(true, limit) && !timer.is_over(true, HoldLimit(None)));
    }
}
