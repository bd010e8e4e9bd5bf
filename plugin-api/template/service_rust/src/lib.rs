//! my_plugin: a service in Rust. A separate thread waits for external events, queues them, and wakes the session.
//! Between two steps, the service applies the queued events to the world. In this example the thread waits for the
//! clock, and queues a tick every `period`. Replace it with your socket, device or bridge: see `listen`.
//!
//! - signal `my_plugin.ticks`: number of ticks received; the simulation waits until there are `wait_for` of them
//!
//! Build: `tatu plugin build`. Run the demo: `tatu plugin run`. The manual: `cargo doc -p tatu-plugin-api --open`.
#![forbid(unsafe_code)]

use std::{
    cell::Cell,
    sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel},
    thread::JoinHandle,
    time::Duration,
};

use tatu_plugin_api::{safe::*, tatu_plugin};

/// The plugin, which has no data.
struct ThisPlugin;

impl Plugin for ThisPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(ThisPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.service::<Ticks>();
    }
}

/// A running service.
struct Ticks {
    wait_for: i64,
    /// Number of ticks applied to the world.
    ticks: Cell<i64>,
    queue: Receiver<i64>,
    /// Dropped to end the thread.
    alive: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// Runs on the service's own thread, which may use only [`Session::wake`] and the log of the host.
fn listen(session: &Session, period: Duration, queue: &Sender<i64>, ending: &Receiver<()>) {
    for tick in 1.. {
        if ending.recv_timeout(period) != Err(RecvTimeoutError::Timeout) || queue.send(tick).is_err() {
            return;
        }
        session.wake();
    }
}

impl Service for Ticks {
    type Plugin = ThisPlugin;

    const ID: &'static str = "my_plugin";
    const TEXT: &'static str = "Counts ticks of the clock in a signal.";

    fn params() -> Vec<Param> {
        vec![
            Param::float("period").unit("s").range(0.001, 60.0).default(0.01).text("Real time between two ticks."),
            Param::int("wait_for").range(0.0, 1e9).default(1).text("The simulation waits for this many ticks."),
        ]
    }

    fn start(_: &ThisPlugin, _: &Host, session: Session, params: &Params<'_>) -> Result<Self> {
        let period = Duration::from_secs_f64(params.f64("period")?);
        let ((to, queue), (alive, ending)) = (channel(), channel());
        let thread = std::thread::Builder::new().name("my_plugin".into());
        let thread = thread.spawn(move || listen(&session, period, &to, &ending));
        let thread = thread.map_err(|e| Fail::new(format!("cannot start a thread: {e}")))?;
        let wait_for = params.i64("wait_for")?;
        Ok(Ticks { wait_for, ticks: Cell::new(0), queue, alive: Some(alive), thread: Some(thread) })
    }

    /// Runs between two steps, and must never block. Its calls to commands are recorded in the input log, so that a run
    /// can be replayed without the service.
    fn barrier(&self, turn: &Turn<'_>, _: u64) -> Result<Answer> {
        for tick in self.queue.try_iter() {
            self.ticks.set(tick);
            turn.call("sim.setInt32Signal", &["my_plugin.ticks".into(), tick.into()], 0)?;
        }
        Ok(if self.ticks.get() < self.wait_for { Answer::Hold } else { Answer::Go })
    }
}

impl Drop for Ticks {
    /// The session ends: the thread must have ended when this returns.
    fn drop(&mut self) {
        self.alive = None;
        if let Some(thread) = self.thread.take() {
            // It fails only if the thread panicked, which has been reported.
            let _ = thread.join();
        }
    }
}

tatu_plugin! {
    plugin: ThisPlugin, id: "org.example.my_plugin", name: "my_plugin", version: "0.1.0", licence: "MIT",
}
