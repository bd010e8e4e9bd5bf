//! Clocks that show another date and run faster than the clock of the computer.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use libc::{c_int, c_void, clockid_t, time_t, timespec, timeval};

use super::rules::{Rule, report, running_call};

/// Whether the clocks differ from those of the computer.
static IS_OTHER: AtomicBool = AtomicBool::new(false);
/// The speed of the other clocks.
const SPEED: i128 = 5000;
/// The difference of the other date, s: 101 days, 7 hours, 13 minutes and 17 seconds.
const SHIFT_S: i128 = ((101 * 24 + 7) * 60 + 13) * 60 + 17;
/// The difference of the time since the start of the computer and of the process, s.
const UPTIME_SHIFT_S: i128 = 5 * 3600 + 1234;
const NS_PER_S: i128 = 1_000_000_000;

/// From now on, lets the plugin's calls on threads of the host read clocks that show another date and are much faster.
/// What depends on the time of day, or happens only after some time, then differs from a run with the computer's clock.
pub fn use_other_clocks() {
    since_start();
    IS_OTHER.store(true, Relaxed);
}

/// The functions that replace those of the C library, by name.
pub fn doubles() -> [(&'static str, *const c_void); 5] {
    [
        ("clock_gettime", clock_gettime as *const c_void),
        ("gettimeofday", gettimeofday as *const c_void),
        ("time", time as *const c_void),
        ("timespec_get", timespec_get as *const c_void),
        ("clock", clock as *const c_void),
    ]
}

/// Returns the time of a clock, ns.
fn now(id: clockid_t) -> Option<i128> {
    let mut at = timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the function writes only to `at`.
    let status = unsafe { libc::clock_gettime(id, &mut at) };
    let real = i128::from(at.tv_sec) * NS_PER_S + i128::from(at.tv_nsec);
    if status != 0 {
        return None;
    }
    if !IS_OTHER.load(Relaxed) || running_call().is_none() {
        return Some(real);
    }
    let date = if id == libc::CLOCK_REALTIME || id == libc::CLOCK_REALTIME_COARSE { SHIFT_S } else { UPTIME_SHIFT_S };
    Some(real + date * NS_PER_S + (SPEED - 1) * since_start())
}

/// Returns the time since the first call of this function, ns.
fn since_start() -> i128 {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed().as_nanos() as i128
}

fn to_timespec(ns: i128) -> timespec {
    timespec { tv_sec: (ns / NS_PER_S) as time_t, tv_nsec: (ns % NS_PER_S) as _ }
}

extern "C" fn clock_gettime(id: clockid_t, out: *mut timespec) -> c_int {
    report("clock_gettime", Rule::Clock, [0; 6]);
    match now(id) {
        Some(ns) if !out.is_null() => {
            // SAFETY: the plugin passes memory for the result.
            unsafe { out.write(to_timespec(ns)) };
            0
        }
        // SAFETY: the arguments are those that the plugin passes to this function.
        _ => unsafe { libc::clock_gettime(id, out) },
    }
}

extern "C" fn timespec_get(out: *mut timespec, base: c_int) -> c_int {
    report("timespec_get", Rule::Clock, [0; 6]);
    match now(libc::CLOCK_REALTIME) {
        Some(ns) if base == 1 && !out.is_null() => {
            // SAFETY: the plugin passes memory for the result.
            unsafe { out.write(to_timespec(ns)) };
            base
        }
        _ => 0,
    }
}

extern "C" fn gettimeofday(out: *mut timeval, zone: *mut c_void) -> c_int {
    report("gettimeofday", Rule::Clock, [0; 6]);
    let _ = zone;
    let Some(ns) = now(libc::CLOCK_REALTIME) else { return -1 };
    if !out.is_null() {
        let at = to_timespec(ns);
        // SAFETY: the plugin passes memory for the result.
        unsafe { out.write(timeval { tv_sec: at.tv_sec, tv_usec: (at.tv_nsec / 1000) as _ }) };
    }
    0
}

extern "C" fn time(out: *mut time_t) -> time_t {
    report("time", Rule::Clock, [0; 6]);
    let seconds = now(libc::CLOCK_REALTIME).map_or(-1, |ns| (ns / NS_PER_S) as time_t);
    if !out.is_null() {
        // SAFETY: the plugin passes null or memory for the result.
        unsafe { out.write(seconds) };
    }
    seconds
}

extern "C" fn clock() -> libc::clock_t {
    report("clock", Rule::Clock, [0; 6]);
    now(libc::CLOCK_PROCESS_CPUTIME_ID).map_or(-1, |ns| (ns / 1000) as libc::clock_t)
}
