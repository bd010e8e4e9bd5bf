//! Determines when the next step is run, and passes input to the world before each step: keys and, in real time, the
//! clock.

use std::{
    sync::atomic::{AtomicBool, Ordering},
    time::{Duration, Instant, SystemTime, UNIX_EPOCH},
};

use tatu_core::{Phase, World, errors::Error};

use super::{
    keys::KeyPresses,
    terminal::{Terminal, TerminalKey},
};
use tatu_terminal::report;

use crate::args::RunArgs;

/// Speeds that `+` and `-` select, as multiples of real time.
const SPEEDS: [f64; 14] = [0.125, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 15.0, 20.0, 40.0];
/// Longest wait without checking for input.
const MAX_WAIT: Duration = Duration::from_millis(20);

/// Delays the steps of a run to a multiple of real time, and handles the keys that pause it or change its speed.
pub struct RunPace {
    keys: KeyPresses,
    terminal: Option<Terminal>,
    /// Keys from the terminal that have not been passed on.
    pressed: Vec<String>,
    /// Multiple of real time; `None`: as fast as possible.
    speed: Option<f64>,
    /// The start time of the run, if scripts read the real clock.
    real: Option<Instant>,
    epoch_sent: bool,
    /// Whether the run is held between two steps.
    is_held: bool,
    /// Whether one step is requested although the run is held.
    single_step: bool,
    /// Real time and simulation time when the speed was last set.
    from: (Instant, f64),
}

impl RunPace {
    /// Creates the pace requested on the command line, and takes over the terminal if needed. Fails with E105 if there
    /// is no terminal or the keys cannot be read.
    pub fn new(args: &RunArgs, world: &World) -> Result<Self, Error> {
        let mut keys = args.pace.keys.as_deref().map(KeyPresses::read).transpose()?.unwrap_or_default();
        // Earlier keys were already received by the run that wrote the snapshot.
        if args.snapshots.from.is_some() {
            while keys.due(world.time() - world.dt()).is_some() {}
        }
        world.set_interactive(args.pace.interactive);
        let real = args.pace.realtime || args.pace.speed.is_some();
        let now = Instant::now();
        Ok(RunPace {
            keys,
            terminal: args.pace.interactive.then(Terminal::open).transpose()?,
            pressed: Vec::new(),
            speed: args.pace.speed.or((real || args.pace.interactive).then_some(1.0)),
            real: real.then_some(now),
            epoch_sent: false,
            is_held: false,
            single_step: false,
            from: (now, world.time()),
        })
    }

    /// Waits until the next step is due, and passes on input that has arrived. Returns `false` if the user has
    /// requested the end of the run at the terminal, or if `interrupted` is set.
    pub fn before_step(&mut self, world: &World, interrupted: &AtomicBool) -> bool {
        loop {
            while let Some(button) = self.terminal.as_mut().and_then(|t| t.next(Duration::ZERO)) {
                if !self.handle_button(button, world) {
                    return false;
                }
            }
            if interrupted.load(Ordering::Relaxed) {
                return false;
            }
            // During a pause, scripts are still called at intervals, but keys are held back.
            if world.phase() == Phase::Paused {
                self.from = (Instant::now(), world.time());
                std::thread::sleep(MAX_WAIT);
                return true;
            }
            let left = self.time_left(world);
            if left.is_zero() {
                break;
            }
            let wait = left.min(MAX_WAIT);
            match &mut self.terminal {
                None => std::thread::sleep(wait),
                Some(terminal) => {
                    if let Some(button) = terminal.next(wait)
                        && !self.handle_button(button, world)
                    {
                        return false;
                    }
                }
            }
        }
        self.single_step = false;
        self.pass_input(world);
        true
    }

    fn pass_input(&mut self, world: &World) {
        if let Some(began) = self.real {
            if !std::mem::replace(&mut self.epoch_sent, true) {
                let epoch = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
                world.put_in("epoch", &epoch.to_string());
            }
            world.put_in("clock", &began.elapsed().as_secs_f64().to_string());
        }
        while let Some(key) = self.keys.due(world.time()) {
            world.put_in("key", &key);
        }
        for key in self.pressed.drain(..) {
            world.put_in("key", &key);
        }
    }

    /// Returns how long to wait before the next step.
    fn time_left(&self, world: &World) -> Duration {
        match self.speed {
            _ if self.single_step => Duration::ZERO,
            _ if self.is_held => MAX_WAIT,
            None => Duration::ZERO,
            Some(speed) => {
                let due = (world.time() - self.from.1) / speed;
                Duration::from_secs_f64((due - self.from.0.elapsed().as_secs_f64()).max(0.0))
            }
        }
    }

    /// Handles a key of the terminal; returns `false` if the run must end.
    fn handle_button(&mut self, button: TerminalKey, world: &World) -> bool {
        match button {
            TerminalKey::Stop => return false,
            TerminalKey::Play => {
                self.from = (Instant::now(), world.time());
                if std::mem::take(&mut self.is_held) {
                    report::note("resumed");
                } else if world.phase() == Phase::Paused {
                    world.request_start();
                    report::note("resumed");
                } else {
                    world.request_pause();
                    report::note("paused: F5 continues, F6 runs one step, F7 stops");
                }
            }
            TerminalKey::Step => {
                if world.phase() == Phase::Paused {
                    world.request_start();
                }
                (self.is_held, self.single_step) = (true, true);
                self.from = (Instant::now(), world.time());
            }
            TerminalKey::Faster | TerminalKey::Slower => {
                let now = self.speed.unwrap_or(1.0);
                let speed = next_speed(now, button == TerminalKey::Faster);
                self.speed = Some(speed);
                self.from = (Instant::now(), world.time());
                report::note(&format!("{speed} x real time"));
            }
            TerminalKey::Key(key) => self.pressed.push(key),
        }
        true
    }
}

fn next_speed(now: f64, faster: bool) -> f64 {
    let next = match faster {
        true => SPEEDS.iter().find(|s| **s > now).or(SPEEDS.last()),
        false => SPEEDS.iter().rev().find(|s| **s < now).or(SPEEDS.first()),
    };
    next.copied().unwrap_or(now)
}

#[cfg(test)]
mod tests {
    use super::next_speed;

    #[test]
    fn speed_steps_stay_between_an_eighth_and_forty() {
        assert_eq!(next_speed(1.0, true), 1.5);
        assert_eq!(next_speed(1.0, false), 0.5);
        assert_eq!(next_speed(0.125, false), 0.125);
        assert_eq!(next_speed(40.0, true), 40.0);
        assert_eq!(next_speed(100.0, false), 40.0);
    }
}
