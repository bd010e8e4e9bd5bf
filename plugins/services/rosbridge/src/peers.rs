//! The state of clients and their subscriptions, and serialization of messages of topics.

use std::{
    collections::{BTreeMap, BTreeSet},
    time::{Duration, Instant},
};

use ciborium::Value as Cbor;
use serde_json::{Value as Json, json};
use tatu_services_common::{
    listener::Client,
    outbox::{Bytes, Message, Utf8Bytes},
};

use crate::{
    convert::Node,
    protocol::{Fragments, Wish, fragments},
    types::Ros,
};

/// Maximum total size of the messages queued for a client, bytes. If there are more, the client reads too slowly, and
/// messages of topics are skipped.
const MOST_LATE: usize = 8 << 20;

/// A client's subscription to a topic.
pub struct Subscription {
    /// The options that the client has requested.
    pub wish: Wish,
    /// The version of ROS that determines the field names and times in messages.
    pub ros: Ros,
    /// Time at which a message was queued last; `None` if none has been queued.
    last: Option<Instant>,
}

impl Subscription {
    /// Returns whether the requested interval since the last message has passed.
    fn is_due(&self, now: Instant) -> bool {
        let pause = Duration::from_secs_f64((self.wish.throttle_ms / 1e3).clamp(0.0, 3600.0));
        self.last.is_none_or(|last| now.duration_since(last) >= pause)
    }
}

/// The state of a client.
pub struct Peer {
    /// The connection of the client, with its queues of messages.
    pub client: Client,
    /// The client's subscriptions, by topic.
    pub listens: BTreeMap<String, Vec<Subscription>>,
    /// Topics that the client has advertised.
    pub publishes: BTreeSet<String>,
    /// Fragments of incomplete messages from the client.
    pub fragments: Fragments,
    /// Whether errors are reported to the client.
    pub told: bool,
    /// Number of fragmented messages sent to the client.
    sent: u64,
}

impl Peer {
    /// Creates the state of a new client.
    pub fn new(client: Client) -> Self {
        Peer {
            client,
            listens: BTreeMap::new(),
            publishes: BTreeSet::new(),
            fragments: Fragments::default(),
            told: true,
            sent: 0,
        }
    }
    /// Queues a message for the client. Unlike messages of topics, it is never skipped.
    pub fn send(&self, message: &Json) {
        self.client.out.send(Message::Text(message.to_string().into()));
    }
    /// Reports an error to the client, unless it has switched reports off. `id` is that of the failed request.
    pub fn status(&self, id: Option<&str>, text: &str) {
        if self.told {
            let mut message = json!({ "op": "status", "level": "error", "msg": text });
            if let Some(id) = id {
                message["id"] = json!(id);
            }
            self.send(&message);
        }
    }
    /// Adds a subscription. It replaces one with the same id.
    pub fn subscribe(&mut self, topic: String, wish: Wish, ros: Ros) {
        let all = self.listens.entry(topic).or_default();
        all.retain(|s| s.wish.id.is_none() || s.wish.id != wish.id);
        all.push(Subscription { wish, ros, last: None });
    }
    /// Removes the subscription with an id, or all subscriptions of the topic if `id` is `None`.
    pub fn unsubscribe(&mut self, topic: &str, id: Option<&str>) {
        if let Some(all) = self.listens.get_mut(topic) {
            all.retain(|s| id.is_some() && s.wish.id.as_deref() != id);
            if all.is_empty() {
                self.listens.remove(topic);
            }
        }
    }
    /// Returns the topics for which at least one subscription is due to receive a message.
    pub fn wants(&self, now: Instant) -> impl Iterator<Item = &str> {
        self.listens.keys().map(String::as_str).filter(move |topic| self.due(topic, now).next().is_some())
    }
    /// Returns the subscriptions of a topic for which a message is due: the index, the version of ROS, and whether the
    /// client has requested CBOR.
    pub fn due(&self, topic: &str, now: Instant) -> impl Iterator<Item = (usize, Ros, bool)> {
        let all = self.listens.get(topic).filter(|_| self.client.out.bytes() <= MOST_LATE);
        all.into_iter().flatten().enumerate().filter(move |(_, s)| s.is_due(now)).map(|(i, s)| (i, s.ros, s.wish.cbor))
    }
    /// Queues a message of a topic for the subscription with index `n`.
    pub fn publish(&mut self, topic: &str, n: usize, written: &Written, now: Instant) {
        let Some(subscription) = self.listens.get_mut(topic).and_then(|all| all.get_mut(n)) else { return };
        subscription.last = Some(now);
        let fragment = subscription.wish.fragment;
        match written {
            Written::Text(text) if fragment > 0 && text.len() > fragment => {
                self.sent += 1;
                for part in fragments(text, fragment, &format!("fragment:{}", self.sent)) {
                    self.client.out.send(Message::Text(part.into()));
                }
            }
            Written::Text(text) => self.client.out.send(Message::Text(text.clone())),
            Written::Bytes(bytes) => self.client.out.send(Message::Binary(bytes.clone())),
        }
    }
}

/// A serialized message of a topic.
pub enum Written {
    /// JSON.
    Text(Utf8Bytes),
    /// CBOR.
    Bytes(Bytes),
}

impl Written {
    /// Serializes a message of a topic.
    pub fn new(topic: &str, node: &Node, cbor: bool) -> Written {
        if !cbor {
            return Written::Text(json!({ "op": "publish", "topic": topic, "msg": node.json() }).to_string().into());
        }
        let text = |t: &str| Cbor::Text(t.to_owned());
        let whole =
            Cbor::Map(vec![(text("op"), text("publish")), (text("topic"), text(topic)), (text("msg"), node.cbor())]);
        let mut out = Vec::new();
        // Writing into memory cannot fail.
        let _ = ciborium::into_writer(&whole, &mut out);
        Written::Bytes(out.into())
    }
}
