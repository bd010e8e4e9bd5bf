//! Parses requests from clients in version 2 of the rosbridge protocol. Each message is a JSON object with an operation
//! in `op`.

use std::collections::BTreeMap;

use serde_json::{Value as Json, json};
use tatu_plugin_api::safe::{Fail, Result};

/// Maximum total size of the fragments of a client's incomplete messages, bytes.
const MAX_FRAGMENT_BYTES: usize = 64 << 20;

/// A request from a client.
#[derive(Debug, Clone, PartialEq)]
pub enum BridgeRequest {
    /// Announces that the client will publish a topic.
    Advertise { topic: String, kind: String },
    /// Announces that the client will no longer publish a topic.
    Unadvertise { topic: String },
    /// Publishes a message on a topic.
    Publish { topic: String, msg: Json },
    /// Subscribes to a topic; `kind` is the message type, or empty.
    Subscribe { topic: String, kind: String, options: SubscriptionOptions },
    /// Ends the subscription with an id, or all subscriptions of the topic if it has none.
    Unsubscribe { topic: String, id: Option<String> },
    /// Calls a service that a client, a script or this server offers.
    Call { service: String, args: Json },
    /// Offers a service.
    Serve { service: String, kind: String },
    /// Announces that the client no longer offers a service.
    Unserve { service: String },
    /// Answers a call to a service that the client offers.
    Answer { id: String, values: Json, good: bool },
    /// Offers an action.
    OfferAction { action: String, kind: String },
    /// Announces that the client no longer offers an action.
    WithdrawAction { action: String },
    /// Sends a goal. `message` is the complete message, which is forwarded to the server of the action.
    Goal { action: String, message: Json },
    /// Requests that a goal be cancelled, by the id that the client has assigned to it.
    Cancel { id: String },
    /// Reports feedback on a goal, or its result if it has a status.
    Progress { id: String, values: Json, status: Option<i64>, good: bool },
    /// Sets the level of reports: "none" switches reports of errors off, and any other level switches them on.
    Level(String),
}

/// Options of a subscription.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SubscriptionOptions {
    /// Id of the subscription, by which the client can end it.
    pub id: Option<String>,
    /// Minimum interval between two messages, ms.
    pub throttle_ms: f64,
    /// Whether messages are encoded as CBOR instead of JSON.
    pub cbor: bool,
    /// Maximum size of a message, bytes. Larger messages are split into fragments. 0: messages are never split.
    pub fragment: usize,
}

/// Parses a message. Returns its id and the request.
pub fn parse_request(message: &Json) -> Result<(Option<String>, BridgeRequest)> {
    let text = |key: &str| -> Result<String> {
        message
            .get(key)
            .and_then(Json::as_str)
            .map(str::to_owned)
            .ok_or_else(|| Fail::argument(format!("expected a string in `{key}`")))
    };
    let or_empty = |key: &str| message.get(key).and_then(Json::as_str).unwrap_or("").to_owned();
    let any = |key: &str| message.get(key).cloned().unwrap_or_else(|| json!({}));
    let id = message.get("id").and_then(Json::as_str).map(str::to_owned);
    let op = text("op")?;
    let known = || {
        id.clone().ok_or_else(|| {
            Fail::argument(format!(
                "a message with the operation `{op}` must contain the `id` of the message to which it refers"
            ))
        })
    };
    let ask = match op.as_str() {
        "advertise" => BridgeRequest::Advertise { topic: text("topic")?, kind: text("type")? },
        "unadvertise" => BridgeRequest::Unadvertise { topic: text("topic")? },
        "publish" => BridgeRequest::Publish { topic: text("topic")?, msg: any("msg") },
        "subscribe" => {
            let compression = or_empty("compression");
            let wish = SubscriptionOptions {
                id: id.clone(),
                throttle_ms: message.get("throttle_rate").and_then(Json::as_f64).unwrap_or(0.0),
                // Clients that request `png` or `cbor-raw` also accept plain messages.
                cbor: compression == "cbor",
                fragment: message.get("fragment_size").and_then(Json::as_u64).unwrap_or(0) as usize,
            };
            BridgeRequest::Subscribe { topic: text("topic")?, kind: or_empty("type"), options: wish }
        }
        "unsubscribe" => BridgeRequest::Unsubscribe { topic: text("topic")?, id: id.clone() },
        "call_service" => BridgeRequest::Call { service: text("service")?, args: any("args") },
        "advertise_service" => BridgeRequest::Serve { service: text("service")?, kind: or_empty("type") },
        "unadvertise_service" => BridgeRequest::Unserve { service: text("service")? },
        "service_response" => {
            let good = message.get("result").and_then(Json::as_bool).unwrap_or(true);
            BridgeRequest::Answer { id: known()?, values: any("values"), good }
        }
        "advertise_action" => BridgeRequest::OfferAction { action: text("action")?, kind: or_empty("type") },
        "unadvertise_action" => BridgeRequest::WithdrawAction { action: text("action")? },
        "send_action_goal" => BridgeRequest::Goal { action: text("action")?, message: message.clone() },
        "cancel_action_goal" => BridgeRequest::Cancel { id: known()? },
        "action_feedback" => BridgeRequest::Progress { id: known()?, values: any("values"), status: None, good: true },
        "action_result" => {
            let good = message.get("result").and_then(Json::as_bool).unwrap_or(true);
            // If there is no status, `result` determines whether the goal has succeeded (4) or was aborted (6).
            let status = message.get("status").and_then(Json::as_i64).unwrap_or(if good { 4 } else { 6 });
            BridgeRequest::Progress { id: known()?, values: any("values"), status: Some(status.max(0)), good }
        }
        "set_level" | "status_level" => BridgeRequest::Level(text("level")?),
        other => return Err(Fail::unsupported(format!("the operation `{other}` is not supported"))),
    };
    Ok((id, ask))
}

/// Splits a message into fragment messages with at most `bytes` bytes of data each. A limit below 4 bytes is raised to
/// 4, because a character in UTF-8 has up to 4 bytes.
pub fn split_message(text: &str, bytes: usize, id: &str) -> Vec<String> {
    let mut parts = Vec::new();
    let mut rest = text;
    while !rest.is_empty() {
        let mut end = bytes.max(4).min(rest.len());
        while !rest.is_char_boundary(end) {
            end -= 1;
        }
        let (part, more) = rest.split_at(end);
        parts.push(part);
        rest = more;
    }
    let total = parts.len();
    let one = |(num, data): (usize, &&str)| {
        json!({ "op": "fragment", "id": id, "data": data, "num": num, "total": total }).to_string()
    };
    parts.iter().enumerate().map(one).collect()
}

/// The fragments of incomplete messages from a client.
#[derive(Default)]
pub struct FragmentBuffer {
    /// The data of fragments by their number, by the id of the message.
    parts: BTreeMap<String, BTreeMap<u64, String>>,
    /// Total size of the data, bytes.
    bytes: usize,
}

impl FragmentBuffer {
    /// Adds a fragment. Returns the complete message if this was its last missing fragment.
    pub fn add(&mut self, message: &Json) -> Result<Option<Json>> {
        let id = message.get("id").and_then(Json::as_str).unwrap_or("").to_owned();
        let number = |key: &str| message.get(key).and_then(Json::as_u64);
        let (Some(num), Some(total), Some(data)) =
            (number("num"), number("total"), message.get("data").and_then(Json::as_str))
        else {
            return Err(Fail::argument(
                "a fragment must have the keys `num` and `total` with integers, and `data` with a string",
            ));
        };
        let resent = self.parts.get(&id).and_then(|parts| parts.get(&num)).map_or(0, String::len);
        self.bytes = self.bytes.saturating_sub(resent) + data.len();
        if self.bytes > MAX_FRAGMENT_BYTES {
            *self = FragmentBuffer::default();
            return Err(Fail::argument(format!(
                "the fragments of incomplete messages exceed {MAX_FRAGMENT_BYTES} bytes, so all of them are dropped"
            )));
        }
        let parts = self.parts.entry(id.clone()).or_default();
        parts.insert(num, data.to_owned());
        if parts.len() as u64 != total {
            return Ok(None);
        }
        let whole: String = self.parts.remove(&id).unwrap_or_default().into_values().collect();
        self.bytes = self.bytes.saturating_sub(whole.len());
        serde_json::from_str(&whole)
            .map(Some)
            .map_err(|e| Fail::argument(format!("the joined fragments are not valid JSON: {e}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fragments_are_joined_into_the_message() {
        let whole = json!({ "op": "publish", "topic": "/größe", "msg": { "data": "ä".repeat(50) } });
        let parts = split_message(&whole.to_string(), 7, "1");
        assert!(parts.len() > 10);
        let mut all = FragmentBuffer::default();
        for (i, part) in parts.iter().enumerate().rev() {
            let done = all.add(&serde_json::from_str(part).unwrap()).unwrap();
            assert_eq!(done, (i == 0).then(|| whole.clone()));
        }
        assert!(all.add(&json!({ "op": "fragment", "id": "1" })).is_err());
        // A fragment that is sent again replaces the first one.
        for _ in 0..3 {
            let half = json!({ "id": "3", "num": 0, "total": 2, "data": "x".repeat(MAX_FRAGMENT_BYTES / 2) });
            assert_eq!(all.add(&half).unwrap(), None);
        }
        let big = json!({ "id": "2", "num": 0, "total": 2, "data": "x".repeat(MAX_FRAGMENT_BYTES + 1) });
        assert!(all.add(&big).is_err() && all.parts.is_empty());
    }

    #[test]
    fn requests_are_parsed_or_refused_with_a_reason() {
        let asked = |text: &str| parse_request(&serde_json::from_str(text).unwrap());
        let (id, ask) = asked(r#"{"op": "subscribe", "id": "a", "topic": "/t", "throttle_rate": 100}"#).unwrap();
        let BridgeRequest::Subscribe { options: wish, .. } = ask else { unreachable!() };
        assert_eq!((id.as_deref(), wish.throttle_ms, wish.cbor), (Some("a"), 100.0, false));
        let (_, ask) = asked(r#"{"op": "subscribe", "topic": "/t", "compression": "cbor-raw"}"#).unwrap();
        assert!(matches!(ask, BridgeRequest::Subscribe { options, .. } if !options.cbor), "plain messages are sent");
        for (text, told) in [
            (r#"{"topic": "/t"}"#, "`op`"),
            (r#"{"op": "dance"}"#, "`dance`"),
            (r#"{"op": "advertise", "topic": "/t"}"#, "`type`"),
            (r#"{"op": "service_response", "service": "/s"}"#, "`id`"),
        ] {
            assert!(asked(text).unwrap_err().text().contains(told), "{text}");
        }
    }
}
