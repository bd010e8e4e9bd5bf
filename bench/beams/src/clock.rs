//! Measures wall and processor time of code. On a shared machine, processor time is the meaningful measure.

use std::time::Instant;

/// Accumulated times, in seconds.
#[derive(Default, Clone, Copy)]
pub struct Clock {
    /// Wall time, s.
    pub wall: f64,
    /// Processor time of all threads of this process, s.
    pub cpu: f64,
}

impl Clock {
    /// Runs `work`, and adds its times.
    pub fn time<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let (wall, cpu) = (Instant::now(), cpu_now());
        let out = work();
        self.wall += wall.elapsed().as_secs_f64();
        self.cpu += cpu_now() - cpu;
        out
    }
}

/// The measured times of a loop.
pub struct LoopTimes {
    pub frames: u64,
    /// Total times of all frames.
    pub clock: Clock,
    /// Median wall time of a frame, s, which is insensitive to interruptions by other processes.
    pub median: f64,
}

/// Calls `frame` until its total wall time reaches `seconds`, after one warm-up call that is not timed.
///
/// `prepare(k)` creates the argument of frame `k` and is not timed.
pub fn loop_for<T>(seconds: f64, mut prepare: impl FnMut(u64) -> T, mut frame: impl FnMut(T)) -> LoopTimes {
    frame(prepare(0));
    let (mut clock, mut walls) = (Clock::default(), Vec::new());
    while clock.wall < seconds || walls.len() < 3 {
        let (ready, before) = (prepare(walls.len() as u64), clock.wall);
        clock.time(|| frame(ready));
        walls.push(clock.wall - before);
    }
    walls.sort_by(f64::total_cmp);
    LoopTimes { frames: walls.len() as u64, clock, median: walls[walls.len() / 2] }
}

fn cpu_now() -> f64 {
    let mut t = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `t` is a valid `timespec`, to which the call writes.
    unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &mut t) };
    t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64
}
