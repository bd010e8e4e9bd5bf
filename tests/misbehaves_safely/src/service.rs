//! A service whose thread outlives it.

use std::{
    sync::{Mutex, PoisonError, mpsc},
    time::{Duration, Instant},
};

use tatu_plugin_api::{abi::*, safe::*};

use crate::MisbehavesPlugin;

/// Leaves a thread running that wakes the session and writes to the log.
pub struct LingeringService;

static SESSIONS: Mutex<Vec<Session>> = Mutex::new(Vec::new());

impl Service for LingeringService {
    type Plugin = MisbehavesPlugin;
    const ID: &'static str = "misbehaves_safely";
    const TEXT: &'static str = "For tests.";

    fn params() -> Vec<Param> {
        Vec::new()
    }
    fn start(_: &MisbehavesPlugin, host: &Host, session: Session, _: &Params<'_>) -> Result<Self> {
        SESSIONS.lock().unwrap_or_else(PoisonError::into_inner).push(session);
        let host = *host;
        let (logged, first_log) = mpsc::channel();
        std::thread::spawn(move || {
            let begin = Instant::now();
            host.log(TATU_LOG_INFO, "a thread of its own");
            let _ = logged.send(());
            while begin.elapsed() < Duration::from_secs(5) {
                for session in SESSIONS.lock().unwrap_or_else(PoisonError::into_inner).iter() {
                    session.wake();
                }
                host.prop("misbehaves_safely.grown");
                host.log(TATU_LOG_DEBUG, "still here");
            }
        });
        // On a busy machine, a short run could end before the thread begins.
        let _ = first_log.recv_timeout(Duration::from_secs(10));
        Ok(LingeringService)
    }
    fn barrier(&self, _: &Turn<'_>, _: u64) -> Result<Answer> {
        Ok(Answer::Go)
    }
}
