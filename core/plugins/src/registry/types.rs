//! The host's representation of what plugins offer.

use std::{
    ffi::c_void,
    path::{Path, PathBuf},
};

use tatu_plugin_api::{abi::*, safe::Value};

use crate::Declared;

/// A field of a sensor kind.
#[derive(Debug, Clone, Default)]
pub struct FieldInfo {
    /// `<schema>.<field>`
    pub name: String,
    /// `TATU_ELEM_*`
    pub elem: u32,
    /// Shape; 0: the number of beams.
    pub dims: [u32; 3],
    /// Unit.
    pub unit: Option<String>,
    /// Description, one sentence.
    pub text: String,
    /// The field that is 0 where this one has no value, if it differs from its schema.
    pub valid: Option<String>,
    /// The values that mean "nothing", if they differ from its schema.
    pub nothing: Option<String>,
}

/// A preset of a sensor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PresetInfo {
    /// Its name in scene files.
    pub id: String,
    /// Description, one sentence.
    pub text: String,
    /// TOML lines as in a scene file, parsed when the preset is used.
    pub settings: String,
}

/// A kind of sensor.
pub struct SensorKind {
    /// Index of the plugin.
    pub plugin: usize,
    /// Its name in scene files.
    pub id: String,
    /// Description, one sentence.
    pub text: String,
    /// Schemas of its readings.
    pub schemas: Vec<String>,
    /// Its parameters.
    pub params: Vec<Declared>,
    /// The fields that it fills.
    pub fields: Vec<FieldInfo>,
    /// Presets.
    pub presets: Vec<PresetInfo>,
    /// The interned keys of its fields.
    pub field_props: Vec<u32>,
    /// The table of its functions.
    pub raw: tatu_sensor,
    /// Functions to create, configure, save and destroy its instances.
    pub life: tatu_life,
    /// Whether this is not a sensor, but the readings of the kind of actuator with this id.
    pub of_actuator: bool,
}

impl SensorKind {
    /// Returns whether its sensors measure after each physics step.
    pub fn in_physics(&self) -> bool {
        !self.of_actuator && self.raw.flags & TATU_SENSOR_EVERY_PHYSICS_STEP != 0
    }
}

/// A model.
pub struct Model {
    /// Index of the plugin.
    pub plugin: usize,
    /// Its name in scene files.
    pub id: String,
    /// Description, one sentence.
    pub text: String,
    /// Its parameters.
    pub params: Vec<Declared>,
    /// Its category in lists; may be empty.
    pub category: String,
    /// Its licence, if it is not that of the plugin.
    pub licence: String,
    /// The mounts by which it fits slots of other models; if empty, it fits every slot.
    pub mounts: Vec<String>,
    /// Objects that others can be attached to.
    pub slots: Vec<Slot>,
    /// Its constants and their sources.
    pub numbers: Vec<ModelNumber>,
    /// The file that describes it, if it was read from text.
    pub file: Option<PathBuf>,
    /// The plugin's own table, by whose address it identifies the model.
    pub given: *const tatu_model,
    /// The table of its functions.
    pub raw: tatu_model,
}

/// A function that reads a model from text.
pub(super) type ReadModel =
    unsafe extern "C" fn(*mut c_void, tatu_str, tatu_str, *mut *const tatu_model, *mut tatu_error) -> tatu_status;

/// A slot of a model, to which other models can be attached.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Slot {
    /// Alias of the object.
    pub alias: String,
    /// The mount that fits; if empty, any.
    pub mount: String,
    /// Its location, one sentence; may be empty.
    pub text: String,
    /// Greatest mass that may be attached, kg; 0 if it is not stated.
    pub payload: f64,
}

/// A constant of a model, with the source of its value.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelNumber {
    /// Its name.
    pub name: String,
    /// Its value, in SI units.
    pub value: Value,
    /// Its unit; may be empty.
    pub unit: String,
    /// Its source; may be empty.
    pub source: String,
}

/// A script language.
pub struct Language {
    /// Index of the plugin.
    pub plugin: usize,
    /// Its id.
    pub id: String,
    /// Description, one sentence.
    pub text: String,
    /// File suffixes.
    pub suffixes: Vec<String>,
    /// The table of its functions.
    pub raw: tatu_language,
    /// Functions to create, configure, save and destroy its instances.
    pub life: tatu_life,
}

/// A name of a command.
pub struct NameEntry {
    /// The name.
    pub name: String,
    /// The values that are returned instead of an error, if it is an old-style name.
    pub on_error: Option<Vec<Value>>,
    /// The first dialect for which an error is raised nevertheless.
    pub until: Option<Vec<u32>>,
}

/// The degree to which a command is implemented.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Fully implemented.
    Full,
    /// Partly implemented.
    Partial,
    /// Not implemented: it returns a neutral value.
    Stub,
}

impl Status {
    /// Returns the status as a name for lists and pages.
    pub fn name(self) -> &'static str {
        match self {
            Status::Full => "full",
            Status::Partial => "partial",
            Status::Stub => "stub",
        }
    }
}

impl NameEntry {
    /// Returns the values that callers with this dialect get instead of an error, if any.
    pub fn instead_of_error(&self, dialect: &[u8]) -> Option<&Vec<Value>> {
        let modern = self.until.as_ref().is_some_and(|until| !dialect.is_empty() && version(dialect) >= *until);
        self.on_error.as_ref().filter(|_| !modern)
    }
}

/// Parses the numbers of a version such as "4.10.0". For a text that is not a version, the result is empty, which is
/// older than any version.
pub fn version(dialect: &[u8]) -> Vec<u32> {
    let text = String::from_utf8_lossy(dialect);
    text.split('.').map_while(|part| part.trim().parse().ok()).collect()
}

/// A command.
pub struct CommandEntry {
    /// Index of the plugin.
    pub plugin: usize,
    /// Its names.
    pub names: Vec<NameEntry>,
    /// Its parameters.
    pub params: Vec<Declared>,
    /// Its results.
    pub returns: Vec<Declared>,
    /// Description, one sentence.
    pub text: String,
    /// An example that fails if the command has no effect.
    pub example: String,
    /// The degree to which it is implemented.
    pub status: Status,
    /// What is missing or differs.
    pub notes: String,
    /// Its subject, one word; may be empty.
    pub subject: String,
    /// The hint for callers that cannot wait.
    pub no_wait: Option<String>,
    /// Whether its arguments are passed unchecked.
    pub raw_args: bool,
    /// Whether parallel scripts may call it.
    pub side_by_side: bool,
    /// The table of its functions.
    pub raw: tatu_command,
}

impl CommandEntry {
    /// Returns the command's first name.
    pub fn name(&self) -> &str {
        self.names.first().map_or("", |n| n.name.as_str())
    }
}

/// A named value for scripts.
pub struct Constant {
    /// Index of the plugin.
    pub plugin: usize,
    /// The value as declared by its plugin; valid as long as the plugin.
    pub raw: tatu_value,
}

/// A script source that a plugin provides for a language.
pub struct Prelude {
    /// Index of the plugin.
    pub plugin: usize,
    /// Language.
    pub language: String,
    /// Module name; if it is empty, the prelude runs in every new state.
    pub module: String,
    /// Its source.
    pub text: Vec<u8>,
}

/// A kind of actuator.
pub struct ActuatorKind {
    /// Index of the plugin.
    pub plugin: usize,
    /// Its name in scene files.
    pub id: String,
    /// Description, one sentence.
    pub text: String,
    /// Its parameters.
    pub params: Vec<Declared>,
    /// Its commands: one number each, in the order of the command buffer.
    pub commands: Vec<Declared>,
    /// Whether it is called before each physics step, instead of once per advance.
    pub every_substep: bool,
    /// The interned keys `<kind>.<parameter>`.
    pub param_props: Vec<u32>,
    /// The interned keys `<kind>.<command>`.
    pub command_props: Vec<u32>,
    /// Index of its readings among the kinds of sensors, if it reports any.
    pub readings: Option<usize>,
    /// The table of its functions.
    pub raw: tatu_actuator,
    /// Functions to create, configure, save and destroy its instances.
    pub life: tatu_life,
}

/// The declarations of a kind of sensor or actuator.
#[derive(Clone, Copy)]
pub struct DeviceKind<'a> {
    /// Index of the plugin.
    pub plugin: usize,
    /// Its name in scene files.
    pub id: &'a str,
    /// Its parameters.
    pub params: &'a [Declared],
    /// Its commands; a sensor has none.
    pub commands: &'a [Declared],
}

impl<'a> DeviceKind<'a> {
    /// Returns all keys that a scene may set.
    pub fn declared(self) -> impl Iterator<Item = &'a Declared> {
        self.params.iter().chain(self.commands)
    }
}

/// An importer.
pub struct Importer {
    /// Index of the plugin.
    pub plugin: usize,
    /// Its name in scene files.
    pub id: String,
    /// Description, one sentence.
    pub text: String,
    /// Suffixes of file names, including the dot.
    pub suffixes: Vec<String>,
    /// Its parameters.
    pub params: Vec<Declared>,
    /// The table of its functions.
    pub raw: tatu_importer,
}

/// The importer chosen for a file, and notes about the choice.
#[derive(Debug, PartialEq, Eq)]
pub struct Choice {
    /// Index of the importer.
    pub importer: usize,
    /// Notes: other importers that also read the file, and importers whose check failed.
    pub notes: Vec<String>,
}

impl Importer {
    /// Returns whether a file's name ends with one of the importer's suffixes.
    pub(super) fn has_suffix(&self, file: &Path) -> bool {
        let name = file.file_name().map(|n| n.to_string_lossy().to_lowercase()).unwrap_or_default();
        self.suffixes.iter().any(|s| !s.is_empty() && name.ends_with(&s.to_lowercase()))
    }

    /// Returns the importer's confidence that it can read the file, 0 to 100.
    pub(super) fn sniff(&self, me: *mut c_void, head: &[u8]) -> u32 {
        let head = crate::border::raw(head);
        // SAFETY: `f` is from a plugin that is never unloaded, and `me` is that plugin's own pointer. The bytes live
        // until the call has returned.
        self.raw.sniff.map_or(0, |f| unsafe { f(me, head) })
    }
}

/// A word that identifies the kind of a script.
pub struct KindMark {
    /// Language.
    pub language: String,
    /// Kind of script.
    pub kind: String,
    /// The word.
    pub word: String,
    /// Whether the last line must begin with the word; otherwise it may be a name anywhere in the source.
    pub last: bool,
}

impl KindMark {
    pub(super) fn fits(&self, text: &[u8]) -> bool {
        let word = self.word.as_bytes();
        if self.last {
            let last = text.split(|b| *b == b'\n').map(<[u8]>::trim_ascii).rfind(|line| !line.is_empty());
            return last.is_some_and(|line| line.starts_with(word));
        }
        let is_name = |b: &u8| b.is_ascii_alphanumeric() || *b == b'_';
        let begins = |at: usize| at == 0 || !is_name(&text[at - 1]);
        !word.is_empty() && text.windows(word.len()).enumerate().any(|(at, w)| w == word && begins(at))
    }
}

/// A kind of service: a component that runs alongside worlds.
pub struct ServiceKind {
    /// Index of the plugin.
    pub plugin: usize,
    /// Its name in scene files and on the command line.
    pub id: String,
    /// Description, one sentence.
    pub text: String,
    /// Its parameters.
    pub params: Vec<Declared>,
    /// Names of the events that it subscribes to.
    pub events: Vec<String>,
    /// The table of its functions.
    pub raw: tatu_service,
    /// Functions to create, configure, save and destroy its instances.
    pub life: tatu_life,
}
