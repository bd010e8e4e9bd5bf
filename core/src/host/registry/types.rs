//! What a plugin can offer, as the host keeps it; actuators, importers and services stand with their own subject.

use tatu_plugin_api::{abi::*, safe::Value};

use crate::host::Declared;

/// One field of a sensor kind.
#[derive(Debug, Clone)]
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
}

/// A kind of sensor.
pub struct SensorKind {
    /// Index of the plugin.
    pub plugin: usize,
    /// What scenes write.
    pub id: String,
    /// One sentence.
    pub text: String,
    /// What readers look for.
    pub schemas: Vec<String>,
    /// Its parameters.
    pub params: Vec<Declared>,
    /// What it fills.
    pub fields: Vec<FieldInfo>,
    /// The interned keys of its fields.
    pub(crate) field_props: Vec<u32>,
    pub(crate) raw: tatu_sensor,
    pub(crate) life: tatu_life,
}

/// A model.
pub struct Model {
    /// Index of the plugin.
    pub plugin: usize,
    /// What scenes write.
    pub id: String,
    /// One sentence.
    pub text: String,
    /// Its parameters.
    pub params: Vec<Declared>,
    /// Where others may be hung.
    pub slots: Vec<String>,
    pub(crate) raw: tatu_model,
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
    pub(crate) raw: tatu_language,
    pub(crate) life: tatu_life,
}

/// One name of a command.
pub struct NameEntry {
    /// The name.
    pub name: String,
    /// What it returns instead of an error, if it is an old-style name.
    pub on_error: Option<Vec<Value>>,
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
    /// A call.
    pub example: String,
    /// What to do where waiting is not possible.
    pub no_wait: Option<String>,
    /// Takes arguments as they come.
    pub raw_args: bool,
    pub(crate) raw: tatu_command,
}

/// A named value for scripts, and who gave it.
pub struct Constant {
    /// Index of the plugin.
    pub plugin: usize,
    /// The value as its plugin declares it; valid as long as the plugin.
    pub(crate) raw: tatu_value,
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
