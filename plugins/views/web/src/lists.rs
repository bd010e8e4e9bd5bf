//! Caches long lists that clients request, and limits the rate of requests.

use std::time::{Duration, Instant};

use tatu_plugin_api::safe::Turn;
use tatu_services_common::outbox::Utf8Bytes;

use crate::{gallery, recent::RecentScenes, requests};

/// Time for which a list is reused before it is built again.
const LIST_MAX_AGE: Duration = Duration::from_secs(1);

/// The cached lists, as JSON messages with the time at which they were built.
#[derive(Default)]
pub(crate) struct ListCache {
    commands: Option<(Instant, Utf8Bytes)>,
    /// The list of scenes for clients with view rights only, without recent scenes.
    files: Option<(Instant, Utf8Bytes)>,
}

impl ListCache {
    /// Returns the list of all commands. Rebuilds it if it is too old or if `anew` is set.
    pub(crate) fn commands(&mut self, turn: &Turn<'_>, anew: bool) -> Utf8Bytes {
        cached(&mut self.commands, anew, || requests::commands(turn).text())
    }
    /// Returns the list of scenes. If `recent` is given, as for clients with control rights, the list contains these
    /// scenes and is always rebuilt.
    pub(crate) fn files(&mut self, recent: Option<&RecentScenes>) -> Utf8Bytes {
        match recent {
            Some(recent) => gallery::list(&recent.all()).text().into(),
            None => cached(&mut self.files, false, || gallery::list(&[]).text()),
        }
    }
}

/// Returns the cached list, or builds it again if it is too old or if `anew` is set.
fn cached(list: &mut Option<(Instant, Utf8Bytes)>, anew: bool, make: impl FnOnce() -> String) -> Utf8Bytes {
    match list {
        Some((made, text)) if !anew && made.elapsed() < LIST_MAX_AGE => text.clone(),
        _ => {
            let text = Utf8Bytes::from(make());
            *list = Some((Instant::now(), text.clone()));
            text
        }
    }
}

/// Rate limit of a client with view rights only: the number of small answers per second, and in a burst. Further
/// requests wait in the client's inbox; a client with a full inbox is disconnected.
const REQUESTS_PER_SECOND: f64 = 50.0;
/// Cost of a list, as a number of small answers.
const LIST_COST: f64 = 25.0;

/// The requests that a client may still make.
pub(crate) struct RequestAllowance {
    /// Remaining requests, as a number of small answers; can be negative after an expensive request.
    remaining: f64,
    /// Time at which `remaining` was updated.
    at: Instant,
}

impl RequestAllowance {
    /// Creates an allowance that permits a full burst.
    pub(crate) fn new() -> Self {
        RequestAllowance { remaining: REQUESTS_PER_SECOND, at: Instant::now() }
    }
    /// Returns whether the client may make a request now.
    pub(crate) fn may_request(&mut self) -> bool {
        self.may_request_at(Instant::now())
    }
    fn may_request_at(&mut self, now: Instant) -> bool {
        let gained = now.saturating_duration_since(self.at).as_secs_f64() * REQUESTS_PER_SECOND;
        (self.remaining, self.at) = ((self.remaining + gained).min(REQUESTS_PER_SECOND), now);
        self.remaining > 0.0
    }
    /// Charges a request; `list` is whether its answer is a list.
    pub(crate) fn spend(&mut self, list: bool) {
        self.remaining -= if list { LIST_COST } else { 1.0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn request_rate_is_limited() {
        let mut allowance = RequestAllowance::new();
        let begin = allowance.at;
        let mut ask = |ms: u64, list| {
            let may = allowance.may_request_at(begin + Duration::from_millis(ms));
            if may {
                allowance.spend(list);
            }
            may
        };
        assert_eq!((0..10).filter(|_| ask(0, true)).count(), 2);
        assert!(!ask(0, false));
        assert_eq!((0..10).filter(|_| ask(100, false)).count(), 5);
        assert_eq!((0..100).filter(|_| ask(5000, false)).count(), 50);
    }
}
