//! Queues messages to clients: the complete scene when they have not received it, then its changes.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use tatu_plugin_api::{
    abi::*,
    safe::{Result, Turn},
};
use tatu_services_common::outbox::OutgoingMessage;

use crate::{
    changes::DetectedChange,
    frames::{EncodedMotion, SentFrame, object_id},
    overlays::{self, OverlayRequest},
    protocol::{RunState, ToPage},
    readings, requests, scene,
    sent::Subject,
    service::WebState,
};

/// Minimum interval between two frames.
const FRAME_INTERVAL: Duration = Duration::from_millis(50);
/// Minimum interval between two messages with readings.
const READINGS_INTERVAL: Duration = Duration::from_millis(100);
/// Minimum interval between two readings of the properties that clients follow.
const DETAILS_INTERVAL: Duration = Duration::from_millis(500);
/// Minimum interval between two rounds of comparisons of all objects.
const COMPARISON_INTERVAL: Duration = Duration::from_millis(200);
/// The world rests if nothing has changed and no client has requested anything for this time.
const REST_DELAY: Duration = Duration::from_secs(1);
/// How many times as long the intervals for frames and comparisons are while the world rests. What other programs and
/// scripts change then is seen later by this factor at most.
const REST_FACTOR: u32 = 5;

impl WebState {
    /// Queues all messages that are due, for all clients.
    pub(crate) fn queue_messages(&mut self, turn: &Turn<'_>, p: &crate::plugin::Props, step: u64) -> Result {
        if self.clients.is_empty() {
            self.unsent_output.clear();
            return Ok(());
        }
        let now = Instant::now();
        let fresh = self.clients.iter().any(|g| !g.scene_sent);
        if turn.state() == TATU_RUNNING {
            self.pacing.last_activity = now;
        }
        if !fresh && now - self.pacing.last_frame < FRAME_INTERVAL * self.rest_factor(now) {
            return Ok(());
        }
        self.pacing.last_frame = now;
        self.queue_output();
        self.clients.iter_mut().for_each(|g| g.has_backlog = g.client.out.has_queued());
        let ids = turn.list(0, 0, 0)?;
        if self.view.world != turn.raw().ptr().addr() || self.view.scene.ids != ids {
            self.read_scene(turn, p)?;
        } else {
            self.queue_changes(turn, p, now)?;
        }
        if self.view.scene_outdated && self.clients.iter().any(|g| !g.scene_sent) {
            self.view.scene = scene::read(turn, p, self.view.scenes_opened)?;
            self.view.scene_outdated = false;
        }
        for guest in self.clients.iter_mut().filter(|g| !g.scene_sent) {
            self.view.scene.messages.iter().for_each(|m| guest.client.out.send(m.clone()));
            guest.sent_frame = SentFrame::default();
            guest.sent.clear();
            guest.scene_sent = true;
        }
        self.queue_state(turn, p)?;
        if self.clients.iter().any(|g| g.client.out.wants_frame()) {
            let (all, time) = (EncodedMotion::read(turn, p, &self.view.scene)?, turn.f64(0, p.time)?);
            for guest in self.clients.iter_mut().filter(|g| g.client.out.wants_frame()) {
                if let Some(frame) = all.frame_since(&mut guest.sent_frame, step, time) {
                    self.pacing.last_activity = now;
                    guest.client.out.set_frame(frame);
                }
                guest.watch.take_message().into_iter().for_each(|m| guest.client.out.send(m.message()));
            }
            self.queue_overlays(turn, p)?;
        }
        if now - self.pacing.last_readings >= READINGS_INTERVAL {
            self.pacing.last_readings = now;
            self.queue_readings(turn, p)?;
        }
        if now - self.pacing.last_details >= DETAILS_INTERVAL {
            self.pacing.last_details = now;
            self.queue_details(turn);
        }
        Ok(())
    }

    /// Returns the factor for the intervals of what must be compared with what was sent.
    fn rest_factor(&self, now: Instant) -> u32 {
        if now - self.pacing.last_activity > REST_DELAY { REST_FACTOR } else { 1 }
    }

    /// Queues the lines of output that have not been sent.
    pub(crate) fn queue_output(&mut self) {
        if self.unsent_output.is_empty() {
            return;
        }
        let message = ToPage::Output { lines: std::mem::take(&mut self.unsent_output) }.message();
        self.clients.iter().for_each(|g| g.client.out.send(message.clone()));
    }

    /// Queues the properties that clients follow and that have changed.
    fn queue_details(&mut self, turn: &Turn<'_>) {
        for guest in self.clients.iter_mut().filter(|g| g.followed != 0 && !g.has_backlog) {
            // The object may have been removed in the meantime.
            let Ok(details) = requests::details(turn, guest.followed) else { continue };
            let message = details.message();
            if guest.sent.is_new(Subject::Details, guest.followed, &message) {
                guest.client.out.send(message);
            }
        }
    }

    /// Reads the complete scene, which is then sent to all clients again.
    fn read_scene(&mut self, turn: &Turn<'_>, p: &crate::plugin::Props) -> Result {
        if self.view.world != turn.raw().ptr().addr() {
            self.view.scenes_opened += 1;
        }
        self.view.scene = scene::read(turn, p, self.view.scenes_opened)?;
        self.view.changes.begin(turn, p, &self.view.scene)?;
        self.edits.invalidate();
        if let Some(file) = turn.get(0, p.file)?.as_str() {
            self.recent.add(Path::new(&*file));
        }
        self.pacing.last_activity = Instant::now();
        (self.view.world, self.view.scene_outdated) = (turn.raw().ptr().addr(), false);
        self.clients.iter_mut().for_each(|g| g.scene_sent = false);
        self.sent_readings = readings::SentReadings::default();
        Ok(())
    }

    /// Continues the comparison of objects if it is due, and queues the objects that have changed other than by moving.
    fn queue_changes(&mut self, turn: &Turn<'_>, p: &crate::plugin::Props, now: Instant) -> Result {
        if self.view.changes.starts_round() {
            let interval = COMPARISON_INTERVAL * self.rest_factor(now);
            if self.view.last_round.is_some_and(|last| now - last < interval) {
                return Ok(());
            }
            self.view.last_round = Some(now);
        }
        match self.view.changes.compare_next(turn, p, &mut self.view.scene)? {
            DetectedChange::Unchanged => {}
            DetectedChange::Scene => self.read_scene(turn, p)?,
            DetectedChange::Objects(messages) => {
                self.pacing.last_activity = now;
                self.view.scene_outdated = true;
                for guest in self.clients.iter().filter(|g| g.scene_sent) {
                    messages.iter().for_each(|m| guest.client.out.send(m.clone()));
                }
            }
        }
        Ok(())
    }

    /// Queues the state of the world for all clients if it has changed.
    fn queue_state(&mut self, turn: &Turn<'_>, p: &crate::plugin::Props) -> Result {
        let state = match turn.state() {
            TATU_STOPPED => RunState::Stopped,
            TATU_PAUSED => RunState::Paused,
            _ if self.pacing.held => RunState::Paused,
            _ => RunState::Running,
        };
        let edits = self.edits.read(turn);
        let text = ToPage::State { state, speed: self.pacing.pace.speed, dt: turn.f64(0, p.dt)?, edits }.text();
        if text != self.last_state {
            self.clients.iter().for_each(|g| g.client.out.send(OutgoingMessage::Text(text.clone().into())));
            self.last_state = text;
        }
        Ok(())
    }

    /// Queues the data for overlays for clients that have requested them and have received all earlier messages.
    /// Consecutive clients with the same request share a message.
    fn queue_overlays(&mut self, turn: &Turn<'_>, p: &crate::plugin::Props) -> Result {
        let mut made: Option<(OverlayRequest, OutgoingMessage)> = None;
        for guest in self.clients.iter_mut().filter(|g| g.overlays.any() && !g.has_backlog) {
            let message = match &made {
                Some((wanted, message)) if *wanted == guest.overlays => message.clone(),
                _ => overlays::message(turn, p, &self.view.scene.ids, guest.overlays)?.message(),
            };
            if guest.sent.is_new(Subject::Overlays, 0, &message) {
                guest.client.out.send(message.clone());
            }
            made = Some((guest.overlays, message));
        }
        Ok(())
    }

    /// Queues readings, drawings, images and the streams of graphs.
    fn queue_readings(&mut self, turn: &Turn<'_>, p: &crate::plugin::Props) -> Result {
        let new = readings::changed_readings(turn, p, &self.view.scene, &mut self.sent_readings);
        let any = !new.is_empty();
        let readings = ToPage::Readings { readings: new }.message();
        let drawn = readings::drawings(turn)?.text();
        if drawn != self.drawings.last_drawings {
            (self.drawings.last_drawings, self.drawings.drawings_version) = (drawn, self.drawings.drawings_version + 1);
        }
        for guest in &mut self.clients {
            let out = &guest.client.out;
            // A client with queued messages is skipped. Once it has received them, it is sent the readings of all
            // sensors.
            if guest.has_backlog {
                guest.missed_readings |= any;
                continue;
            }
            if guest.missed_readings {
                out.send(ToPage::Readings { readings: self.sent_readings.all(&self.view.scene) }.message());
                guest.missed_readings = false;
            } else if any {
                out.send(readings.clone());
            }
            if guest.drawings_version != self.drawings.drawings_version {
                out.send(OutgoingMessage::Text(self.drawings.last_drawings.clone().into()));
                guest.drawings_version = self.drawings.drawings_version;
            }
            let image = |subject, id, depth| Some((subject, id, readings::image(turn, p, object_id(id), depth)?));
            let images = guest.streams.images.iter().filter_map(|id| image(Subject::Image, *id, false));
            let depths = guest.streams.depths.iter().filter_map(|id| image(Subject::Depth, *id, true));
            let graphs =
                guest.streams.graphs.iter().filter_map(|id| {
                    Some((Subject::Graph, *id, readings::graph(turn, object_id(*id)).ok()?.message()))
                });
            for (subject, id, message) in images.chain(depths).chain(graphs) {
                if guest.sent.is_new(subject, id, &message) {
                    out.send(message);
                }
            }
        }
        Ok(())
    }
}
