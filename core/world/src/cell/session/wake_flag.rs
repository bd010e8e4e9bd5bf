//! The flag that wakes a session sleeping at its barrier.

use std::{
    sync::{Condvar, Mutex, PoisonError},
    time::Duration,
};

/// A flag that any thread may set. A sleeping thread wakes up and clears it.
#[derive(Default)]
pub(crate) struct WakeFlag {
    is_set: Mutex<bool>,
    condvar: Condvar,
}

impl WakeFlag {
    /// Sets the flag. If no thread is asleep, the next sleep ends immediately, so that no wake-up is lost.
    pub fn wake(&self) {
        *self.is_set.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.condvar.notify_all();
    }

    /// Sleeps until the flag is set, but no longer than `most`.
    pub fn sleep(&self, most: Duration) {
        let word = self.is_set.lock().unwrap_or_else(PoisonError::into_inner);
        let slept = self.condvar.wait_timeout_while(word, most, |set| !*set);
        *slept.unwrap_or_else(PoisonError::into_inner).0 = false;
    }
}

#[cfg(test)]
mod tests {
    use std::{sync::Arc, thread};

    use super::*;

    #[test]
    fn flag_set_before_the_sleep_is_not_lost() {
        let wake = Arc::new(WakeFlag::default());
        for _ in 0..100 {
            let other = wake.clone();
            let thread = thread::spawn(move || other.wake());
            // A lost wake-up would make this hang; the limit is far longer than any delay.
            wake.sleep(Duration::from_secs(600));
            thread.join().unwrap();
        }
    }
}
