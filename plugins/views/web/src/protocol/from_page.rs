//! Requests from a client.

use serde::Deserialize;
use serde_json::{Map, Value as Json};

/// A request to the program.
// The JSON has the variant in the key `type`, but `parse` converts it to an externally tagged enum before
// deserializing, because only then can an error name the invalid field.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(ts_rs::TS), ts(tag = "type"))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum FromPage {
    /// Starts, pauses, stops or steps the simulation, or quits the program.
    Run { action: RunAction },
    /// Sets the speed of the simulation as a multiple of real time; 0: as fast as possible.
    Speed { speed: f64 },
    /// Passes a pressed key to the simulation: a character, or a name such as `up`.
    Key { key: String },
    /// Sends a part of a dropped file, in base64. The answer to the last part is the path by which commands open the
    /// file.
    Drop {
        id: u32,
        file: String,
        part: String,
        last: bool,
        /// The folder for the file: the answer to a `folder` request. Omitted if the file was dropped alone.
        #[serde(default)]
        #[cfg_attr(test, ts(optional))]
        folder: Option<String>,
    },
    /// Creates a folder for several dropped files. The answer is its path.
    Folder { id: u32, name: String },
    /// Replaces the source of a script, unless another client has changed it since `version`.
    SaveScript { id: u32, script: u32, text: String, version: u32 },
    /// Opens a scene of the gallery, or any file that the command `tatu.open` accepts.
    Open { id: u32, file: String },
    /// Stores a picture of a recent scene, a PNG in base64.
    Picture { scene: String, png: String },
    /// Requests the picture of a model. The answer is a PNG in base64, or null.
    ModelPicture { id: u32, model: String },
    /// Calls a command. The answer is its results.
    Call {
        id: u32,
        name: String,
        #[cfg_attr(test, ts(type = "Array<unknown>"))]
        args: Vec<Json>,
    },
    /// Requests the properties of an object. If `follow` is set, they are sent again whenever they have changed, until
    /// the next such request; an `object` of 0 ends this.
    Details {
        object: u32,
        #[serde(default)]
        #[cfg_attr(test, ts(optional, as = "Option<bool>"))]
        follow: bool,
    },
    /// Requests the source of a script.
    Script { script: u32 },
    /// Requests the custom data of an object, or of the scene if `object` is 0.
    Data { object: u32 },
    /// Requests the images of these sensors from now on, instead of those requested before: of `objects` the colors, or the
    /// depths if they have no colors; of `depths` the depths.
    Images {
        objects: Vec<u32>,
        #[serde(default)]
        #[cfg_attr(test, ts(optional, as = "Option<Vec<u32>>"))]
        depths: Vec<u32>,
    },
    /// Requests the streams of these graphs from now on, instead of those requested before.
    Graphs { objects: Vec<u32> },
    /// Requests the values of properties and of fields of readings in each step from now on, instead of those requested
    /// before. Messages with the values repeat `of`.
    Watch { of: u32, values: Vec<WatchedValue> },
    /// Requests data for overlays from now on: contacts, and the masses, inertias and velocities of bodies.
    Overlays { contacts: bool, bodies: bool },
    /// If `on` is set, starts to record a film at the next start of the simulation, or immediately during a run.
    /// Otherwise ends the recording; the answer is the film as a page in base64, or null if the simulation has not run,
    /// and the simulation time at which the film became too large, or null.
    Film { id: u32, on: bool },
    /// Requests the list of all commands.
    Commands {},
    /// Requests the list of scenes that can be opened.
    Files {},
}

/// A watched value of an object: a property, or a field of its readings.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub(crate) struct WatchedValue {
    pub(crate) object: u32,
    pub(crate) key: String,
}

/// The action of a `run` request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub(crate) enum RunAction {
    Start,
    Pause,
    Stop,
    Step,
    Quit,
}

/// A request that could not be parsed.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct RefusedRequest {
    /// The error message.
    pub(crate) text: String,
    /// The `id` of the request, if it has one.
    pub(crate) of: Option<u32>,
}

impl FromPage {
    /// Returns the number by which the answer refers to this request, or `None` if the request has no `id`.
    pub(crate) fn id(&self) -> Option<u32> {
        match self {
            FromPage::Drop { id, .. }
            | FromPage::Folder { id, .. }
            | FromPage::SaveScript { id, .. }
            | FromPage::Open { id, .. }
            | FromPage::ModelPicture { id, .. }
            | FromPage::Film { id, .. }
            | FromPage::Call { id, .. } => Some(*id),
            _ => None,
        }
    }
    /// Parses a request. An error names the invalid field, and contains the `id` of the request if it has one.
    pub(crate) fn parse(text: &str) -> Result<FromPage, RefusedRequest> {
        let refuse = |text: String, of| Err(RefusedRequest { text, of });
        let mut fields = match serde_json::from_str(text) {
            Ok(Json::Object(fields)) => fields,
            Ok(_) => return refuse("expected a JSON object with the key `type`".to_owned(), None),
            Err(e) => return refuse(format!("expected a JSON object with the key `type`: {e}"), None),
        };
        let of = fields.get("id").and_then(Json::as_u64).and_then(|n| n.try_into().ok());
        let kind = match fields.remove("type") {
            Some(Json::String(kind)) => kind,
            Some(other) => return refuse(format!("`type` of a request: expected a string, found {other}"), of),
            None => return refuse("a request lacks the key `type`".to_owned(), of),
        };
        let whole = Json::Object(Map::from_iter([(kind.clone(), Json::Object(fields))]));
        serde_path_to_error::deserialize(whole).or_else(|e| {
            let path = e.path().to_string();
            let field = path.strip_prefix(&kind).map_or("", |rest| rest.trim_start_matches('.'));
            let place = if field.is_empty() { String::new() } else { format!("`{field}` of ") };
            refuse(format!("{place}a request of type `{kind}`: {}", e.inner()), of)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_read() {
        let read = |text| FromPage::parse(text).unwrap();
        assert_eq!(read(r#"{"type": "run", "action": "step"}"#), FromPage::Run { action: RunAction::Step });
        assert_eq!(read(r#"{"speed": 2, "type": "speed"}"#), FromPage::Speed { speed: 2.0 });
        assert_eq!(read(r#"{"type": "files"}"#), FromPage::Files {});
        let call = FromPage::Call { id: 3, name: "tatu.get".into(), args: vec![1.into(), "object.pose".into()] };
        assert_eq!(read(r#"{"type": "call", "id": 3, "name": "tatu.get", "args": [1, "object.pose"]}"#), call);
    }

    #[test]
    fn errors_name_the_field_and_the_expected_value() {
        for (text, parts, of) in [
            ("no JSON", &["JSON object", "`type`", "line 1"][..], None),
            ("[1]", &["JSON object", "`type`"], None),
            (r#"{"speed": 1}"#, &["lacks the key `type`"], None),
            (r#"{"type": 7}"#, &["`type`", "expected a string, found 7"], None),
            (r#"{"type": "fly", "id": 9}"#, &["unknown variant `fly`", "`speed`"], Some(9)),
            (r#"{"type": "speed", "speed": "fast"}"#, &["`speed` of", "\"fast\"", "expected f64"], None),
            (r#"{"type": "details", "object": -1}"#, &["`object` of", "`-1`", "expected u32"], None),
            (r#"{"type": "call", "id": 4, "name": "x"}"#, &["`call`", "missing field `args`"], Some(4)),
            (r#"{"type": "call", "id": 4, "name": "x", "args": 1}"#, &["`args` of", "expected a sequence"], Some(4)),
            (r#"{"type": "run", "action": "fly"}"#, &["`action` of", "`fly`", "`start`"], None),
            (r#"{"type": "key", "key": "a", "kee": 1}"#, &["unknown field `kee`", "expected `key`"], None),
        ] {
            let refused = FromPage::parse(text).unwrap_err();
            assert!(parts.iter().all(|p| refused.text.contains(p)), "{text}: {refused:?}");
            assert_eq!(refused.of, of, "{text}");
        }
    }
}
