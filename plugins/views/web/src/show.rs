//! Queues messages to clients: the scene when it is new, then changes.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use serde_json::json;
use tatu_plugin_api::{
    abi::*,
    safe::{Result, Turn},
};
use tatu_services_common::outbox::Message;

use crate::{
    frames::{Now, object},
    readings, scene,
    service::State,
};

/// Intervals of frames and of readings.
const FRAMES: Duration = Duration::from_millis(50);
const READINGS: Duration = Duration::from_millis(100);

impl State {
    /// Queues all messages that are due.
    pub(crate) fn show(&mut self, turn: &Turn<'_>, p: &crate::plugin::Props, step: u64) -> Result {
        if self.guests.is_empty() {
            return Ok(());
        }
        let now = Instant::now();
        let fresh = self.guests.iter().any(|g| !g.whole);
        if !fresh && now - self.last_frame < FRAMES {
            return Ok(());
        }
        self.last_frame = now;
        let ids = turn.list(0, 0, 0)?;
        if self.world != turn.raw().ptr().addr() || self.whole.ids != ids {
            self.whole = scene::read(turn, p)?;
            self.world = turn.raw().ptr().addr();
            if let Some(file) = turn.get(0, p.file)?.as_str() {
                self.recent.shown(Path::new(&*file));
            }
            self.guests.iter_mut().for_each(|g| g.whole = false);
            self.sent = readings::Sent::default();
        }
        for guest in self.guests.iter_mut().filter(|g| !g.whole) {
            self.whole.messages.iter().for_each(|m| guest.client.out.send(m.clone()));
            guest.known.clear();
            guest.whole = true;
        }
        self.tell(turn, p)?;
        if self.guests.iter().any(|g| g.client.out.wants_frame()) {
            let (all, time) = (Now::read(turn, p, &self.whole)?, turn.f64(0, p.time)?);
            for guest in self.guests.iter_mut().filter(|g| g.client.out.wants_frame()) {
                guest.client.out.frame(all.since(&mut guest.known, step, time));
            }
        }
        if now - self.last_readings >= READINGS {
            self.last_readings = now;
            self.show_readings(turn, p)?;
        }
        Ok(())
    }

    /// Publishes the state of the world, if it has changed.
    fn tell(&mut self, turn: &Turn<'_>, p: &crate::plugin::Props) -> Result {
        let state = match turn.state() {
            TATU_STOPPED => "stopped",
            TATU_PAUSED => "paused",
            _ if self.held => "paused",
            _ => "running",
        };
        let text = json!({ "state": state, "speed": self.pace.speed, "dt": turn.f64(0, p.dt)? }).to_string();
        if text != self.told {
            self.guests.iter().for_each(|g| g.client.out.send(Message::Text(text.clone().into())));
            self.told = text;
        }
        Ok(())
    }

    fn show_readings(&mut self, turn: &Turn<'_>, p: &crate::plugin::Props) -> Result {
        let new = readings::new(turn, p, &self.whole, &mut self.sent);
        let any = new.as_object().is_some_and(|m| !m.is_empty());
        let readings = json!({ "readings": new }).to_string();
        let drawn = json!({ "drawings": readings::drawings(turn)? }).to_string();
        let redrawn = drawn != self.drawn;
        for guest in &self.guests {
            let out = &guest.client.out;
            // A client that has not received the last messages yet is skipped until it has.
            if out.waits() {
                continue;
            }
            if any {
                out.send(Message::Text(readings.clone().into()));
            }
            if redrawn {
                out.send(Message::Text(drawn.clone().into()));
            }
            let image = (guest.eye != 0).then(|| readings::image(turn, p, object(guest.eye))).flatten();
            image.into_iter().for_each(|m| out.send(m));
            if guest.graph != 0
                && let Ok(graph) = readings::graph(turn, object(guest.graph))
            {
                out.send(Message::Text(graph.to_string().into()));
            }
        }
        self.drawn = drawn;
        Ok(())
    }
}
