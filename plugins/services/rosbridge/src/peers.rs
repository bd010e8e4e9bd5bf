//! The state of clients and their subscriptions, and serialization of messages of topics.

use std::{
    collections::{BTreeMap, BTreeSet},
    time::{Duration, Instant},
};

use ciborium::Value as Cbor;
use serde_json::{Value as Json, json};
use tatu_services_common::{
    listener::WebSocketClient,
    outbox::{Bytes, OutgoingMessage, Utf8Bytes},
};

use crate::{
    convert::MessageNode,
    protocol::{FragmentBuffer, SubscriptionOptions, split_message},
    types::RosVersion,
};

/// Maximum total size of the messages queued for a client, bytes. If there are more, the client reads too slowly, and
/// messages of topics are skipped.
const MAX_QUEUED_BYTES: usize = 8 << 20;

/// A client's subscription to a topic.
pub struct Subscription {
    /// The options that the client has requested.
    pub options: SubscriptionOptions,
    /// The version of ROS that determines the field names and times in messages.
    pub ros: RosVersion,
    /// Time at which a message was queued last; `None` if none has been queued.
    last: Option<Instant>,
}

impl Subscription {
    /// Returns whether the requested interval since the last message has passed.
    fn is_due(&self, now: Instant) -> bool {
        let pause = Duration::from_secs_f64((self.options.throttle_ms / 1e3).clamp(0.0, 3600.0));
        self.last.is_none_or(|last| now.duration_since(last) >= pause)
    }
}

/// The state of a client.
pub struct BridgeClient {
    /// The connection of the client, with its queues of messages.
    pub client: WebSocketClient,
    /// The client's subscriptions, by topic.
    pub subscriptions: BTreeMap<String, Vec<Subscription>>,
    /// Topics that the client has advertised.
    pub publishes: BTreeSet<String>,
    /// Fragments of incomplete messages from the client.
    pub fragments: FragmentBuffer,
    /// Whether errors are reported to the client.
    pub reports_errors: bool,
    /// Number of fragmented messages sent to the client.
    fragmented_count: u64,
}

impl BridgeClient {
    /// Creates the state of a new client.
    pub fn new(client: WebSocketClient) -> Self {
        BridgeClient {
            client,
            subscriptions: BTreeMap::new(),
            publishes: BTreeSet::new(),
            fragments: FragmentBuffer::default(),
            reports_errors: true,
            fragmented_count: 0,
        }
    }
    /// Queues a message for the client. Unlike messages of topics, it is never skipped.
    pub fn send(&self, message: &Json) {
        self.client.out.send(OutgoingMessage::Text(message.to_string().into()));
    }
    /// Reports an error to the client, unless it has switched reports off. `id` is that of the failed request.
    pub fn report_error(&self, id: Option<&str>, text: &str) {
        if self.reports_errors {
            let mut message = json!({ "op": "status", "level": "error", "msg": text });
            if let Some(id) = id {
                message["id"] = json!(id);
            }
            self.send(&message);
        }
    }
    /// Adds a subscription. It replaces one with the same id.
    pub fn subscribe(&mut self, topic: String, wish: SubscriptionOptions, ros: RosVersion) {
        let all = self.subscriptions.entry(topic).or_default();
        all.retain(|s| s.options.id.is_none() || s.options.id != wish.id);
        all.push(Subscription { options: wish, ros, last: None });
    }
    /// Removes the subscription with an id, or all subscriptions of the topic if `id` is `None`.
    pub fn unsubscribe(&mut self, topic: &str, id: Option<&str>) {
        if let Some(all) = self.subscriptions.get_mut(topic) {
            all.retain(|s| id.is_some() && s.options.id.as_deref() != id);
            if all.is_empty() {
                self.subscriptions.remove(topic);
            }
        }
    }
    /// Returns the topics for which at least one subscription is due to receive a message.
    pub fn due_topics(&self, now: Instant) -> impl Iterator<Item = &str> {
        self.subscriptions
            .keys()
            .map(String::as_str)
            .filter(move |topic| self.due_subscriptions(topic, now).next().is_some())
    }
    /// Returns the subscriptions of a topic for which a message is due: the index, the version of ROS, and whether the
    /// client has requested CBOR.
    pub fn due_subscriptions(&self, topic: &str, now: Instant) -> impl Iterator<Item = (usize, RosVersion, bool)> {
        let all = self.subscriptions.get(topic).filter(|_| self.client.out.bytes() <= MAX_QUEUED_BYTES);
        all.into_iter()
            .flatten()
            .enumerate()
            .filter(move |(_, s)| s.is_due(now))
            .map(|(i, s)| (i, s.ros, s.options.cbor))
    }
    /// Queues a message of a topic for the subscription with index `n`.
    pub fn publish(&mut self, topic: &str, n: usize, written: &EncodedMessage, now: Instant) {
        let Some(subscription) = self.subscriptions.get_mut(topic).and_then(|all| all.get_mut(n)) else { return };
        subscription.last = Some(now);
        let fragment = subscription.options.fragment;
        match written {
            EncodedMessage::Text(text) if fragment > 0 && text.len() > fragment => {
                self.fragmented_count += 1;
                for part in split_message(text, fragment, &format!("fragment:{}", self.fragmented_count)) {
                    self.client.out.send(OutgoingMessage::Text(part.into()));
                }
            }
            EncodedMessage::Text(text) => self.client.out.send(OutgoingMessage::Text(text.clone())),
            EncodedMessage::Bytes(bytes) => self.client.out.send(OutgoingMessage::Binary(bytes.clone())),
        }
    }
}

/// A serialized message of a topic.
pub enum EncodedMessage {
    /// JSON.
    Text(Utf8Bytes),
    /// CBOR.
    Bytes(Bytes),
}

impl EncodedMessage {
    /// Serializes a message of a topic.
    pub fn new(topic: &str, node: &MessageNode, cbor: bool) -> EncodedMessage {
        if !cbor {
            return EncodedMessage::Text(
                json!({ "op": "publish", "topic": topic, "msg": node.json() }).to_string().into(),
            );
        }
        let text = |t: &str| Cbor::Text(t.to_owned());
        let whole =
            Cbor::Map(vec![(text("op"), text("publish")), (text("topic"), text(topic)), (text("msg"), node.cbor())]);
        let mut out = Vec::new();
        // Writing into memory cannot fail.
        let _ = ciborium::into_writer(&whole, &mut out);
        EncodedMessage::Bytes(out.into())
    }
}
