//! Messages to a client.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value as Json;
use tatu_services_common::outbox::OutgoingMessage;

use super::{
    object::{SceneEntry, SceneObject, Script},
    sensor_data::{BodyMark, ContactMark, CurvePoints, Drawing, ReadingMap, StreamSamples, WatchSample},
};

/// A message to the page.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS), ts(optional_fields))]
#[serde(tag = "type", rename_all = "snake_case")]
pub(crate) enum ToPage {
    /// The first message of a connection.
    Hello {
        version: u32,
        /// Whether the client has control rights.
        acts: bool,
        /// An address that grants view rights, for the user to share; sent only to clients with control rights.
        #[serde(skip_serializing_if = "Option::is_none")]
        look: Option<String>,
        /// The working folder, to which relative paths of scenes refer; sent only to clients with control rights.
        #[serde(skip_serializing_if = "Option::is_none")]
        folder: Option<String>,
        speed: f64,
    },
    /// The complete scene.
    Scene {
        file: String,
        /// Number of the scene among those opened so far. It differs if the same file is opened again.
        opened: u32,
        dt: f64,
        objects: Vec<SceneEntry>,
        scripts: Vec<Script>,
        /// Notes from loading the scene, such as the features that an importer does not support.
        notes: Vec<String>,
        /// The description of the scene in the first comment of its file.
        about: String,
        /// The suggestion of what to try, from the same comment.
        #[serde(rename = "try")]
        to_try: String,
    },
    /// Objects that have changed in other ways than by moving.
    Objects {
        objects: Vec<SceneObject>,
    },
    State {
        state: RunState,
        speed: f64,
        dt: f64,
        #[serde(flatten)]
        edits: EditState,
    },
    Event {
        name: String,
        #[cfg_attr(test, ts(type = "any"))]
        payload: Json,
    },
    /// The events with output of the simulation, such as `message` and `console`, since the last frame.
    Output {
        lines: Vec<OutputLine>,
    },
    Readings {
        readings: ReadingMap,
    },
    Drawings {
        drawings: Vec<Drawing>,
    },
    Streams {
        graph: u32,
        streams: Vec<StreamSamples>,
        /// The curves that the graph declares, each a stream over another.
        curves: Vec<CurvePoints>,
    },
    /// The watched values in each step since the last such message.
    Values {
        of: u32,
        samples: Vec<WatchSample>,
    },
    /// The custom data of an object, or of the scene if `object` is 0: strings by tag. Binary data is omitted.
    Data {
        object: u32,
        data: BTreeMap<String, String>,
    },
    /// The requested data for overlays.
    Overlays {
        contacts: Vec<ContactMark>,
        bodies: Vec<BodyMark>,
    },
    /// The properties of an object, and the fields of its last reading that have at most 16 elements.
    Details {
        object: u32,
        rows: Vec<PropertyRow>,
    },
    /// The source of a script.
    Script {
        script: u32,
        text: String,
        version: u32,
    },
    Commands {
        commands: Vec<Command>,
    },
    Files {
        files: Vec<SceneFile>,
        /// The name of the working folder.
        folder: String,
    },
    /// The results of the request with this number.
    Result {
        of: u32,
        #[cfg_attr(test, ts(type = "Array<any>"))]
        results: Vec<Json>,
    },
    /// An error. `of` is the number of the request that failed, if the request has one.
    Error {
        error: String,
        #[serde(skip_serializing_if = "Option::is_none")]
        help: Option<String>,
        #[serde(skip_serializing_if = "Option::is_none")]
        of: Option<u32>,
    },
}

/// An event with output of the simulation.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct OutputLine {
    /// The name of the event.
    pub(crate) name: String,
    #[cfg_attr(test, ts(type = "any"))]
    pub(crate) payload: Json,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub(crate) enum RunState {
    Stopped,
    Running,
    Paused,
}

/// The state of undo and redo, and of unsaved edits.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct EditState {
    /// Label of the edit that the next undo reverts; `redo` is that of the edit that the next redo applies.
    pub(crate) undo: Option<String>,
    pub(crate) redo: Option<String>,
    /// Whether the scene has changes that are not saved in its file.
    pub(crate) unsaved: bool,
    /// Path of the scene's file; `on_disk` is whether the file exists and may be overwritten.
    pub(crate) file: String,
    pub(crate) on_disk: bool,
    /// Unix time, s, of a copy of unsaved edits that a crashed program has left; null if there is none.
    #[cfg_attr(test, ts(type = "number | null"))]
    pub(crate) recovery: Option<i64>,
}

/// A property of an object, or a field of its last reading that has at most 16 elements.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct PropertyRow {
    pub(crate) key: String,
    /// The type of the value, one of the constants `TATU_*`; `count` is its number of elements, or 0 for any number.
    #[serde(rename = "type")]
    #[cfg_attr(test, ts(type = "number"))]
    pub(crate) kind: i64,
    #[cfg_attr(test, ts(type = "number"))]
    pub(crate) count: i64,
    pub(crate) unit: String,
    pub(crate) text: String,
    pub(crate) settable: bool,
    pub(crate) choices: Vec<String>,
    /// The minimum value, if one is declared.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, ts(optional))]
    pub(crate) min: Option<f64>,
    /// The maximum value, if one is declared.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, ts(optional))]
    pub(crate) max: Option<f64>,
    #[cfg_attr(test, ts(type = "unknown"))]
    pub(crate) value: Json,
}

/// A command, for completion in the editor.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct Command {
    pub(crate) name: String,
    /// The parameters, separated by commas.
    pub(crate) params: String,
    pub(crate) text: String,
}

/// A scene that can be opened.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct SceneFile {
    #[serde(rename = "in")]
    pub(crate) section: GallerySection,
    /// The path by which an `open` request opens the scene.
    pub(crate) file: String,
    /// The first paragraph of the comment at the beginning of the file, up to "Try:".
    pub(crate) about: String,
    /// The suggestion in that comment: the text after "Try:".
    #[serde(rename = "try")]
    pub(crate) to_try: String,
    /// A picture of the scene as a PNG in base64.
    pub(crate) picture: Option<String>,
}

/// The section of the gallery: recently opened scenes, those in the working folder, or those of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub(crate) enum GallerySection {
    Recent,
    Own,
    Program,
}

impl ToPage {
    /// Returns the message as JSON text.
    pub(crate) fn text(&self) -> String {
        // This cannot fail: non-finite numbers become null, and all map keys are strings or integers.
        serde_json::to_string(self).unwrap_or_default()
    }
    /// Returns the message in the form in which it is queued for a client.
    pub(crate) fn message(&self) -> OutgoingMessage {
        OutgoingMessage::Text(self.text().into())
    }
}
