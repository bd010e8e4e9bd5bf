//! Queues messages to clients: the complete scene when they have not received it, then its changes.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use tatu_plugin_api::{
    abi::*,
    safe::{Result, Turn},
};
use tatu_services_common::outbox::Message;

use crate::{
    changes::Found,
    frames::{Now, object},
    overlays::{self, Wanted},
    protocol::{RunState, ToPage},
    readings, scene,
    service::State,
};

/// Minimum interval between two frames.
const FRAMES: Duration = Duration::from_millis(50);
/// Minimum interval between two messages with readings.
const READINGS: Duration = Duration::from_millis(100);
/// Minimum interval between two rounds of comparisons of all objects.
const ROUNDS: Duration = Duration::from_millis(200);

impl State {
    /// Queues all messages that are due, for all clients.
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
        self.guests.iter_mut().for_each(|g| g.waits = g.client.out.waits());
        let ids = turn.list(0, 0, 0)?;
        if self.world != turn.raw().ptr().addr() || self.whole.ids != ids {
            self.read_scene(turn, p)?;
        } else {
            self.show_changes(turn, p, now)?;
        }
        if self.is_old && self.guests.iter().any(|g| !g.whole) {
            self.whole = scene::read(turn, p, self.opened_before)?;
            self.is_old = false;
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
                guest.watch.message().into_iter().for_each(|m| guest.client.out.send(m.message()));
            }
            self.show_overlays(turn, p)?;
        }
        if now - self.last_readings >= READINGS {
            self.last_readings = now;
            self.show_readings(turn, p)?;
        }
        Ok(())
    }

    /// Reads the complete scene, which is then sent to all clients again.
    fn read_scene(&mut self, turn: &Turn<'_>, p: &crate::plugin::Props) -> Result {
        if self.world != turn.raw().ptr().addr() {
            self.opened_before += 1;
        }
        self.whole = scene::read(turn, p, self.opened_before)?;
        self.changes.begin(turn, p, &self.whole)?;
        self.edits.look_again();
        if let Some(file) = turn.get(0, p.file)?.as_str() {
            self.recent.shown(Path::new(&*file));
        }
        (self.world, self.is_old) = (turn.raw().ptr().addr(), false);
        self.guests.iter_mut().for_each(|g| g.whole = false);
        self.sent = readings::Sent::default();
        Ok(())
    }

    /// Continues the comparison of objects if it is due, and queues the objects that have changed other than by moving.
    fn show_changes(&mut self, turn: &Turn<'_>, p: &crate::plugin::Props, now: Instant) -> Result {
        if self.changes.is_round() {
            if self.last_round.is_some_and(|last| now - last < ROUNDS) {
                return Ok(());
            }
            self.last_round = Some(now);
        }
        match self.changes.look(turn, p, &mut self.whole)? {
            Found::Nothing => {}
            Found::Scene => self.read_scene(turn, p)?,
            Found::Objects(messages) => {
                self.is_old = true;
                for guest in self.guests.iter().filter(|g| g.whole) {
                    messages.iter().for_each(|m| guest.client.out.send(m.clone()));
                }
            }
        }
        Ok(())
    }

    /// Queues the state of the world for all clients if it has changed.
    fn tell(&mut self, turn: &Turn<'_>, p: &crate::plugin::Props) -> Result {
        let state = match turn.state() {
            TATU_STOPPED => RunState::Stopped,
            TATU_PAUSED => RunState::Paused,
            _ if self.held => RunState::Paused,
            _ => RunState::Running,
        };
        let edits = self.edits.read(turn);
        let text = ToPage::State { state, speed: self.pace.speed, dt: turn.f64(0, p.dt)?, edits }.text();
        if text != self.told {
            self.guests.iter().for_each(|g| g.client.out.send(Message::Text(text.clone().into())));
            self.told = text;
        }
        Ok(())
    }

    /// Queues the data for overlays for clients that have requested them and have received all earlier messages.
    /// Consecutive clients with the same request share a message.
    fn show_overlays(&mut self, turn: &Turn<'_>, p: &crate::plugin::Props) -> Result {
        let mut made: Option<(Wanted, Message)> = None;
        for guest in self.guests.iter().filter(|g| g.overlays.any() && !g.waits) {
            let message = match &made {
                Some((wanted, message)) if *wanted == guest.overlays => message.clone(),
                _ => overlays::message(turn, p, &self.whole.ids, guest.overlays)?.message(),
            };
            guest.client.out.send(message.clone());
            made = Some((guest.overlays, message));
        }
        Ok(())
    }

    /// Queues readings, drawings, images and the streams of graphs.
    fn show_readings(&mut self, turn: &Turn<'_>, p: &crate::plugin::Props) -> Result {
        let new = readings::new(turn, p, &self.whole, &mut self.sent);
        let any = !new.is_empty();
        let readings = ToPage::Readings { readings: new }.message();
        let drawn = readings::drawings(turn)?.text();
        if drawn != self.drawn {
            (self.drawn, self.drawings) = (drawn, self.drawings + 1);
        }
        for guest in &mut self.guests {
            let out = &guest.client.out;
            // A client with queued messages is skipped. Once it has received them, it is sent the readings of all
            // sensors.
            if guest.waits {
                guest.missed |= any;
                continue;
            }
            if guest.missed {
                out.send(ToPage::Readings { readings: self.sent.all(&self.whole) }.message());
                guest.missed = false;
            } else if any {
                out.send(readings.clone());
            }
            if guest.drawings != self.drawings {
                out.send(Message::Text(self.drawn.clone().into()));
                guest.drawings = self.drawings;
            }
            guest.images.iter().filter_map(|id| readings::image(turn, p, object(*id))).for_each(|m| out.send(m));
            guest.graphs.iter().flat_map(|id| readings::graph(turn, object(*id))).for_each(|m| out.send(m.message()));
        }
        Ok(())
    }
}
