//! Parses the lines that clients send.

use serde_json::{Value as Json, json};
use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Result, Value},
};

use tatu_services_common::json;

/// A request from a client.
#[derive(Debug, Clone, PartialEq)]
pub enum JsonlRequest {
    /// Calls a command.
    Call { name: String, args: Vec<Value> },
    /// Switches stepping mode, in which each step requires the permission of the client, on or off.
    Stepping(bool),
    /// Permits this number of steps. The answer is sent when they are complete.
    Step(u64),
    /// Requests a change of the simulation state: one of the constants `TATU_REQUEST_*`.
    Request(u32),
    /// Requests the state of the simulation.
    State,
    /// Switches the sending of events on or off.
    Events(bool),
    /// Selects the world for later requests, by its index from 0.
    World(usize),
    /// Presents the token that the service requires for access.
    Token(String),
}

/// A line that a client has sent, after parsing.
#[derive(Debug, Clone, PartialEq)]
pub struct RequestLine {
    /// The `id` of the line, which the answer repeats; null if it has none.
    pub id: Json,
    /// The request, or the reason why the line is invalid.
    pub request: Result<JsonlRequest>,
    /// Whether the line is not a JSON object.
    pub no_json: bool,
}

/// Maximum number of steps per request.
const MAX_STEPS: u64 = 1_000_000_000;

/// Keys of requests. A message must have exactly one of them, and may also have `id` and `args`.
const REQUEST_KEYS: [&str; 8] = ["call", "stepping", "step", "request", "state", "events", "world", "token"];

impl RequestLine {
    /// Parses a line. If it is invalid, the returned message contains the error.
    pub fn parse(line: &[u8]) -> RequestLine {
        let json: Json = match serde_json::from_slice(line) {
            Ok(json) => json,
            Err(e) => {
                return RequestLine {
                    no_json: true,
                    ..RequestLine::invalid(Fail::argument(format!("the line is not valid JSON: {e}")))
                };
            }
        };
        RequestLine {
            id: json.get("id").cloned().unwrap_or_default(),
            request: parse_request(&json),
            no_json: !json.is_object(),
        }
    }
    /// Returns the error for a client with this first line, or `None` if the client is accepted. The first line must be
    /// a JSON object and, unless `token` is empty, present this token.
    pub fn refusal(&self, token: &str) -> Option<RequestLine> {
        match &self.request {
            Ok(JsonlRequest::Token(said)) if said == token => None,
            Err(fail) if self.no_json => {
                let fail =
                    Fail::argument(format!("the first line is invalid ({}), so the connection is closed", fail.text()));
                Some(RequestLine::invalid(fail.help("send one JSON object per line; this is not a web server")))
            }
            _ if token.is_empty() => None,
            // Objects that are not valid requests are refused, too; otherwise, one could be sent in place of the token.
            _ => {
                let text = "this service requires a valid token in the first line, so the connection is closed";
                let help =
                    "send {\"token\": \"...\"} as the first line, with the token that the service was started with";
                Some(RequestLine { id: self.id.clone(), request: Err(Fail::argument(text).help(help)), no_json: false })
            }
        }
    }
    /// Creates the message for an invalid line whose `id` is not known.
    pub fn invalid(fail: Fail) -> RequestLine {
        RequestLine { id: Json::Null, request: Err(fail), no_json: false }
    }
}

/// Returns the request in a line.
fn parse_request(json: &Json) -> Result<JsonlRequest> {
    let help =
        "send {\"id\": 1, \"call\": \"name\", \"args\": []}, or one of stepping, step, request, state, events, world";
    let object = json.as_object().ok_or_else(|| Fail::argument("a message must be a JSON object").help(help))?;
    if let Some(other) =
        object.keys().find(|k| !REQUEST_KEYS.contains(&k.as_str()) && !["id", "args"].contains(&k.as_str()))
    {
        return Err(Fail::argument(format!("unknown key `{other}`")).help(help));
    }
    let mut found = REQUEST_KEYS.iter().filter_map(|k| object.get(*k).map(|v| (*k, v)));
    let (Some((key, value)), None) = (found.next(), found.next()) else {
        return Err(
            Fail::argument(format!("a message must have exactly one of {}", REQUEST_KEYS.join(", "))).help(help)
        );
    };
    let wrong = |what: &str| Fail::argument(format!("`{key}`: expected {what}, found {value}"));
    let truth = || value.as_bool().ok_or_else(|| wrong("true or false"));
    Ok(match key {
        "call" => {
            let name = value.as_str().ok_or_else(|| wrong("the name of a command"))?.to_owned();
            let args = match object.get("args") {
                None => Vec::new(),
                Some(Json::Array(args)) => args.iter().map(json::read).collect::<Result<_>>()?,
                Some(_) => return Err(Fail::argument("`args`: expected an array")),
            };
            JsonlRequest::Call { name, args }
        }
        "stepping" => JsonlRequest::Stepping(truth()?),
        "events" => JsonlRequest::Events(truth()?),
        "token" => JsonlRequest::Token(value.as_str().ok_or_else(|| wrong("a string"))?.to_owned()),
        "state" => {
            truth()?;
            JsonlRequest::State
        }
        "step" => {
            let count = value.as_u64().filter(|n| (1..=MAX_STEPS).contains(n));
            JsonlRequest::Step(count.ok_or_else(|| wrong("a number of steps from 1 to 1000000000"))?)
        }
        "world" => JsonlRequest::World(value.as_u64().ok_or_else(|| wrong("the index of a world, from 0"))? as usize),
        _ => JsonlRequest::Request(match value.as_str() {
            Some("stop") => TATU_REQUEST_STOP,
            Some("pause") => TATU_REQUEST_PAUSE,
            Some("start") => TATU_REQUEST_START,
            Some("quit") => TATU_REQUEST_QUIT,
            _ => return Err(wrong("\"stop\", \"pause\", \"start\" or \"quit\"")),
        }),
    })
}

/// Builds the answer that reports an error to the client.
pub fn error(id: &Json, fail: &Fail) -> Json {
    let mut error = json!({ "code": fail.code(), "text": fail.text() });
    if let Some(help) = fail.help_text() {
        error["help"] = json!(help);
    }
    json!({ "id": id, "error": error })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(line: &str) -> JsonlRequest {
        RequestLine::parse(line.as_bytes()).request.unwrap()
    }

    #[test]
    fn each_request_kind_is_parsed() {
        let call = JsonlRequest::Call { name: "f".into(), args: vec![Value::Int(1), Value::text("a")] };
        assert_eq!(asked(r#"{"id":1,"call":"f","args":[1,"a"]}"#), call);
        assert_eq!(asked(r#"{"call":"f"}"#), JsonlRequest::Call { name: "f".into(), args: vec![] });
        assert_eq!(asked(r#"{"id":1,"stepping":true}"#), JsonlRequest::Stepping(true));
        assert_eq!(asked(r#"{"id":1,"step":3}"#), JsonlRequest::Step(3));
        assert_eq!(asked(r#"{"id":1,"request":"pause"}"#), JsonlRequest::Request(TATU_REQUEST_PAUSE));
        assert_eq!(asked(r#"{"id":1,"world":1}"#), JsonlRequest::World(1));
    }

    #[test]
    fn clients_are_refused_unless_the_first_line_is_the_token() {
        let refused = |line: &str, token| RequestLine::parse(line.as_bytes()).refusal(token).is_some();
        let others = ["{}", r#"{"id":1}"#, r#"{"call":"f"}"#, r#"{"kall":"f"}"#, r#"{"token":1}"#, r#"{"token":"b"}"#];
        for line in others {
            assert!(refused(line, "a"), "{line}");
            assert!(!refused(line, ""), "{line}");
        }
        assert!(!refused(r#"{"token":"a"}"#, "a"));
        assert!(refused(r#"{"token":"a","call":"f"}"#, "a"));
        for line in ["GET / HTTP/1.1", "[]", "3", ""] {
            assert!(refused(line, "a") && refused(line, ""), "{line}");
        }
    }

    #[test]
    fn invalid_lines_are_reported_with_their_id() {
        let wrong = [
            r#"{"id":7}"#,
            r#"{"id":7,"call":"f","step":1}"#,
            r#"{"id":7,"call":5}"#,
            r#"{"id":7,"call":"f","args":3}"#,
            r#"{"id":7,"step":0}"#,
            r#"{"id":7,"step":9223372036854775808}"#,
            r#"{"id":7,"step":-1}"#,
            r#"{"id":7,"request":"dance"}"#,
            r#"{"id":7,"kall":"f"}"#,
        ];
        for line in wrong {
            let message = RequestLine::parse(line.as_bytes());
            assert!(message.request.is_err() && message.id == 7, "{line}");
        }
        for line in ["", "[]", "3", "{", "\u{0}", "{\"id\":1,\"call\":\"f\",\"args\":["] {
            let message = RequestLine::parse(line.as_bytes());
            assert!(message.request.is_err() && message.id == Json::Null, "{line}");
        }
    }
}
