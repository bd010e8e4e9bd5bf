//! What a plugin can offer, as the host keeps it.

use std::{ffi::c_void, path::Path};

use tatu_plugin_api::{abi::*, safe::Value};

use crate::Declared;

/// One field of a sensor kind.
#[derive(Debug, Clone, Default)]
pub struct FieldInfo {
    /// `<schema>.<field>`
    pub name: String,
    /// `TATU_ELEM_*`
    pub elem: u32,
    /// Shape; 0: as many as there are beams.
    pub dims: [u32; 3],
    /// Unit.
    pub unit: Option<String>,
    /// One sentence.
    pub text: String,
    /// The field that is 0 where this one has nothing, if not as its schema says.
    pub valid: Option<String>,
    /// The numbers that mean nothing, likewise.
    pub nothing: Option<String>,
}

/// A preset of a sensor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PresetInfo {
    /// Its name in scene files.
    pub id: String,
    /// One sentence.
    pub text: String,
    /// Lines of TOML as a scene would have them; they are read where the preset is used.
    pub settings: String,
}

/// A kind of sensor.
pub struct SensorKind {
    /// Index of the plugin.
    pub plugin: usize,
    /// Its name in scene files.
    pub id: String,
    /// One sentence.
    pub text: String,
    /// The schema of its readings.
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
    /// How its instances are made, configured, saved and ended.
    pub life: tatu_life,
}

/// A model.
pub struct Model {
    /// Index of the plugin.
    pub plugin: usize,
    /// Its name in scene files.
    pub id: String,
    /// One sentence.
    pub text: String,
    /// Its parameters.
    pub params: Vec<Declared>,
    /// Its category in lists; empty: none.
    pub category: String,
    /// Objects to which others can be attached.
    pub slots: Vec<String>,
    /// The table of its functions.
    pub raw: tatu_model,
}

/// A script language.
pub struct Language {
    /// Index of the plugin.
    pub plugin: usize,
    /// Its id.
    pub id: String,
    /// One sentence.
    pub text: String,
    /// File suffixes.
    pub suffixes: Vec<String>,
    /// The table of its functions.
    pub raw: tatu_language,
    /// How its instances are made, configured, saved and ended.
    pub life: tatu_life,
}

/// One name of a command.
pub struct NameEntry {
    /// The name.
    pub name: String,
    /// What it returns instead of an error, if it is an old-style name.
    pub on_error: Option<Vec<Value>>,
    /// The first dialect for whose scripts an error is an error all the same.
    pub until: Option<Vec<u32>>,
}

/// How completely a command is implemented.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Completely.
    Full,
    /// Partly.
    Partial,
    /// It returns a neutral value.
    Stub,
}

impl Status {
    /// As lists and pages have it.
    pub fn name(self) -> &'static str {
        match self {
            Status::Full => "full",
            Status::Partial => "partial",
            Status::Stub => "stub",
        }
    }
}

impl NameEntry {
    /// What it returns instead of an error to a caller of a dialect, if it is so old.
    pub fn instead_of_error(&self, dialect: &[u8]) -> Option<&Vec<Value>> {
        let modern = self.until.as_ref().is_some_and(|until| !dialect.is_empty() && version(dialect) >= *until);
        self.on_error.as_ref().filter(|_| !modern)
    }
}

/// The numbers of a version such as "4.10.0"; none for what is no version, which is older than all.
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
    /// One sentence.
    pub text: String,
    /// An example that raises an error if the effect is missing.
    pub example: String,
    /// How completely it is implemented.
    pub status: Status,
    /// What is missing or differs.
    pub notes: String,
    /// What it is about, one word; empty: not given.
    pub subject: String,
    /// What to do where waiting is not possible.
    pub no_wait: Option<String>,
    /// Takes unchecked arguments.
    pub raw_args: bool,
    /// Scripts that run side by side may call it.
    pub side_by_side: bool,
    /// The table of its functions.
    pub raw: tatu_command,
}

impl CommandEntry {
    /// Its first name.
    pub fn name(&self) -> &str {
        self.names.first().map_or("", |n| n.name.as_str())
    }
}

/// A named value for scripts, and its plugin.
pub struct Constant {
    /// Index of the plugin.
    pub plugin: usize,
    /// The value as its plugin declares it; valid as long as the plugin.
    /// The table of its functions.
    pub raw: tatu_value,
}

/// A text for scripts of a language.
pub struct Prelude {
    /// Index of the plugin.
    pub plugin: usize,
    /// Language.
    pub language: String,
    /// Module; "" runs in every new state.
    pub module: String,
    /// Its text.
    pub text: Vec<u8>,
}

/// A kind of actuator.
pub struct ActuatorKind {
    /// Index of the plugin.
    pub plugin: usize,
    /// Its name in scene files.
    pub id: String,
    /// One sentence.
    pub text: String,
    /// Its parameters.
    pub params: Vec<Declared>,
    /// What may be commanded: one number each, in the order of the command buffer.
    pub commands: Vec<Declared>,
    /// Whether it is called before each physics step, instead of once per advance.
    pub every_substep: bool,
    /// The interned keys `<kind>.<parameter>`.
    pub param_props: Vec<u32>,
    /// The interned keys `<kind>.<command>`.
    pub command_props: Vec<u32>,
    /// The table of its functions.
    pub raw: tatu_actuator,
    /// How its instances are made, configured, saved and ended.
    pub life: tatu_life,
}

/// What a device's kind declares, be it a sensor or an actuator.
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
    /// All keys that a scene may set.
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
    /// One sentence.
    pub text: String,
    /// Suffixes of file names, with their dot.
    pub suffixes: Vec<String>,
    /// Its parameters.
    pub params: Vec<Declared>,
    /// The table of its functions.
    pub raw: tatu_importer,
}

/// The importer of a file, and what is to be reported about the choice.
#[derive(Debug, PartialEq, Eq)]
pub struct Choice {
    /// Index of the importer.
    pub importer: usize,
    /// Others read it as well: which one was chosen; and which could not decide whether they can read it.
    pub notes: Vec<String>,
}

impl Importer {
    /// Whether a file's name ends with one of its suffixes.
    pub(super) fn has_suffix(&self, file: &Path) -> bool {
        let name = file.file_name().map(|n| n.to_string_lossy().to_lowercase()).unwrap_or_default();
        self.suffixes.iter().any(|s| !s.is_empty() && name.ends_with(&s.to_lowercase()))
    }

    /// Confidence that it can read the file, 0 to 100.
    pub(super) fn sniff(&self, me: *mut c_void, head: &[u8]) -> u32 {
        let head = crate::border::raw(head);
        // SAFETY: by the contract; the bytes live through the call.
        self.raw.sniff.map_or(0, |f| unsafe { f(me, head) })
    }
}

/// A word by which the kind of a text is recognized.
pub struct KindMark {
    /// Language.
    pub language: String,
    /// Kind of script.
    pub kind: String,
    /// The word.
    pub word: String,
    /// The last line begins with it; else a name anywhere in the text does.
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

/// A service: a component that runs beside worlds.
pub struct ServiceKind {
    /// Index of the plugin.
    pub plugin: usize,
    /// The name in scene files and on the command line.
    pub id: String,
    /// One sentence.
    pub text: String,
    /// Its parameters.
    pub params: Vec<Declared>,
    /// Names of the events that it subscribes to.
    pub events: Vec<String>,
    /// The table of its functions,
    pub raw: tatu_service,
    /// and of its life.
    pub life: tatu_life,
}
