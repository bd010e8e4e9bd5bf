//! Wall and processor time of a region; processor time is what counts on a shared machine.

use std::time::Instant;

/// Sums of time, in seconds.
#[derive(Default, Clone, Copy)]
pub struct Clock {
    /// Of the world.
    pub wall: f64,
    /// Of all threads of this process.
    pub cpu: f64,
}

impl Clock {
    /// Adds what `work` takes.
    pub fn time<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let (wall, cpu) = (Instant::now(), cpu_now());
        let out = work();
        self.wall += wall.elapsed().as_secs_f64();
        self.cpu += cpu_now() - cpu;
        out
    }
}

/// What a loop took.
pub struct Took {
    pub frames: u64,
    /// In all.
    pub clock: Clock,
    /// Wall time of the median frame, s: what else the machine does in between does not show.
    pub median: f64,
}

/// Calls `frame(k)` until it took `seconds` of wall time in all, after one call that does not count.
///
/// `prepare(k)` comes before each frame and is not timed.
pub fn loop_for<T>(seconds: f64, mut prepare: impl FnMut(u64) -> T, mut frame: impl FnMut(T)) -> Took {
    frame(prepare(0));
    let (mut clock, mut walls) = (Clock::default(), Vec::new());
    while clock.wall < seconds || walls.len() < 3 {
        let (ready, before) = (prepare(walls.len() as u64), clock.wall);
        clock.time(|| frame(ready));
        walls.push(clock.wall - before);
    }
    walls.sort_by(f64::total_cmp);
    Took { frames: walls.len() as u64, clock, median: walls[walls.len() / 2] }
}

fn cpu_now() -> f64 {
    let mut t = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `t` is a place for the answer.
    unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &mut t) };
    t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64
}
