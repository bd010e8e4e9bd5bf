//! The host's representation of what plugins offer.

use std::{
    ffi::c_void,
    path::{Path, PathBuf},
};

use tatu_plugin_api::{abi::*, safe::Value};

use super::Plugin;
use crate::ParameterSpec;

/// A field of a sensor kind.
#[derive(Debug, Clone, Default)]
pub struct FieldSpec {
    /// Name of the schema and of the field, separated by a dot.
    pub name: String,
    /// Element type, a `TATU_ELEM_*` constant.
    pub elem: u32,
    /// Size of each dimension; 0 for the number of beams, or one of the `TATU_DIM_*` constants.
    pub dims: [u32; 3],
    /// Unit of the values; `None` if they are dimensionless.
    pub unit: Option<String>,
    /// Description in one sentence.
    pub text: String,
    /// The field that is 0 where this one has no value, if it differs from that of the schema.
    pub valid: Option<String>,
    /// The values that mean "nothing", if they differ from those of the schema.
    pub nothing: Option<String>,
}

/// A preset of a sensor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PresetSpec {
    /// Id, by which scene files refer to it.
    pub id: String,
    /// Description in one sentence.
    pub text: String,
    /// TOML lines as in a scene file, parsed when the preset is used.
    pub settings: String,
}

/// A kind of sensor that a plugin offers.
pub struct SensorKind {
    /// Index of the plugin in the registry.
    pub plugin: usize,
    /// Id, by which scene files refer to it.
    pub id: String,
    /// Description in one sentence.
    pub text: String,
    /// Ids of the schemas that the readings conform to.
    pub schemas: Vec<String>,
    /// Declared parameters, in order.
    pub params: Vec<ParameterSpec>,
    /// The fields of a reading.
    pub fields: Vec<FieldSpec>,
    /// Copies of the tables with which the plugin declares the fields.
    pub field_tables: Vec<tatu_field>,
    /// Presets, each a named set of settings.
    pub presets: Vec<PresetSpec>,
    /// The interned keys of the fields, in order.
    pub field_props: Vec<u32>,
    /// Copy of the table that the plugin provides.
    pub raw: tatu_sensor,
    /// Functions that create, configure, save and destroy instances.
    pub life: tatu_life,
    /// Whether this is not a sensor, but the readings of the kind of actuator with this id.
    pub of_actuator: bool,
}

impl SensorKind {
    /// Returns whether sensors of this kind measure after each physics step.
    pub fn in_physics(&self) -> bool {
        !self.of_actuator && self.raw.flags & TATU_SENSOR_EVERY_PHYSICS_STEP != 0
    }
}

/// A model that a plugin can build, which consists of objects and has parameters.
pub struct Model {
    /// Index of the plugin in the registry.
    pub plugin: usize,
    /// Id, by which scene files refer to it.
    pub id: String,
    /// Description in one sentence.
    pub text: String,
    /// Declared parameters, in order.
    pub params: Vec<ParameterSpec>,
    /// Category under which lists show the model; may be empty.
    pub category: String,
    /// Licence of the model; empty if it is the plugin's.
    pub licence: String,
    /// The mounts by which it fits slots of other models; if empty, it fits every slot.
    pub mounts: Vec<String>,
    /// Slots, which are objects to which other models can be attached.
    pub slots: Vec<AttachmentSlot>,
    /// Constants of the model, with their sources.
    pub numbers: Vec<ModelNumber>,
    /// The file that describes the model, if it was read from text.
    pub file: Option<PathBuf>,
    /// The plugin's own table, whose address identifies the model to the plugin.
    pub(crate) given: *const tatu_model,
    /// Copy of the table that the plugin provides.
    pub(crate) raw: tatu_model,
}

/// A function that reads a model from text.
pub(super) type ReadModelFn =
    unsafe extern "C" fn(*mut c_void, tatu_str, tatu_str, *mut *const tatu_model, *mut tatu_error) -> tatu_status;

/// A slot of a model, to which other models can be attached.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AttachmentSlot {
    /// Alias of the object that is the slot.
    pub alias: String,
    /// The mount that fits the slot; if empty, every mount fits.
    pub mount: String,
    /// Description of the slot's location, one sentence; may be empty.
    pub text: String,
    /// Maximum mass that may be attached, kg; 0 if it is not specified.
    pub payload: f64,
}

/// A constant of a model, with the source of its value.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelNumber {
    /// Name of the constant.
    pub name: String,
    /// Value, in SI units.
    pub value: Value,
    /// Unit of the value; may be empty.
    pub unit: String,
    /// Source of the value, such as a data sheet; may be empty.
    pub source: String,
}

/// A script language that a plugin implements.
pub struct ScriptLanguage {
    /// Index of the plugin in the registry.
    pub plugin: usize,
    /// Id of the language.
    pub id: String,
    /// Description in one sentence.
    pub text: String,
    /// Suffixes of the names of script files, including the dot.
    pub suffixes: Vec<String>,
    /// The permission without which its scripts are not loaded.
    pub permission: Option<String>,
    /// Declared settings, in order; their values are the parameters of each script.
    pub params: Vec<ParameterSpec>,
    /// Copy of the table that the plugin provides.
    pub raw: tatu_language,
    /// Functions that create, configure, save and destroy instances.
    pub life: tatu_life,
}

/// A name of a command.
pub struct CommandName {
    /// Name by which scripts call the command.
    pub name: String,
    /// The values that a call by this name returns instead of raising an error, if the name is an old-style one.
    pub on_error: Option<Vec<Value>>,
    /// The first version of the dialect for which an error is raised instead of returning `on_error`.
    pub until: Option<Vec<u32>>,
}

/// The degree to which a command is implemented.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandStatus {
    /// Fully implemented.
    Full,
    /// Partly implemented.
    Partial,
    /// Not implemented: it returns a neutral value.
    Stub,
}

impl CommandStatus {
    /// Returns the status as a name for lists and pages.
    pub fn name(self) -> &'static str {
        match self {
            CommandStatus::Full => "full",
            CommandStatus::Partial => "partial",
            CommandStatus::Stub => "stub",
        }
    }
}

impl CommandName {
    /// Returns the values that callers with this dialect receive instead of an error, if any.
    pub fn instead_of_error(&self, dialect: &[u8]) -> Option<&Vec<Value>> {
        let modern = self.until.as_ref().is_some_and(|until| !dialect.is_empty() && version(dialect) >= *until);
        self.on_error.as_ref().filter(|_| !modern)
    }
}

/// Parses the numbers of a version such as "4.10.0". If the string is not a version, the result is empty, which
/// precedes every version.
pub fn version(dialect: &[u8]) -> Vec<u32> {
    let text = String::from_utf8_lossy(dialect);
    text.split('.').map_while(|part| part.trim().parse().ok()).collect()
}

/// A command, which is a function of a plugin that scripts can call.
pub struct CommandEntry {
    /// Index of the plugin in the registry.
    pub plugin: usize,
    /// Names of the command; there is at least one.
    pub names: Vec<CommandName>,
    /// Declared parameters, in order.
    pub params: Vec<ParameterSpec>,
    /// Declared results, in order.
    pub returns: Vec<ParameterSpec>,
    /// Description in one sentence.
    pub text: String,
    /// An example that fails if the command has no effect.
    pub example: String,
    /// The degree to which the command is implemented.
    pub status: CommandStatus,
    /// Description of what is missing or differs; may be empty.
    pub notes: String,
    /// Subject under which lists show the command, one word; may be empty.
    pub subject: String,
    /// The hint for callers that cannot wait for the command.
    pub no_wait: Option<String>,
    /// Whether arguments are passed to the command unchecked.
    pub raw_args: bool,
    /// Whether scripts that run in parallel may call the command.
    pub side_by_side: bool,
    /// Copy of the table that the plugin provides.
    pub raw: tatu_command,
}

impl CommandEntry {
    /// Returns the command's first name.
    pub fn name(&self) -> &str {
        self.names.first().map_or("", |n| n.name.as_str())
    }
}

/// A named value for scripts.
pub struct ScriptConstant {
    /// Index of the plugin in the registry.
    pub plugin: usize,
    /// The value as declared by the plugin, which remains valid while the plugin is loaded.
    pub raw: tatu_value,
}

/// A script source that a plugin provides for a language.
pub struct Prelude {
    /// Index of the plugin in the registry.
    pub plugin: usize,
    /// Id of the script language.
    pub language: String,
    /// Module name; if it is empty, the prelude runs in every new state.
    pub module: String,
    /// Source code.
    pub text: Vec<u8>,
}

/// A kind of actuator or part that a plugin offers.
pub struct ActuatorKind {
    /// Index of the plugin in the registry.
    pub plugin: usize,
    /// Id, by which scene files refer to it.
    pub id: String,
    /// Description in one sentence.
    pub text: String,
    /// Declared parameters, in order.
    pub params: Vec<ParameterSpec>,
    /// Declared commands, each a single number, in the order of the command buffer.
    pub commands: Vec<ParameterSpec>,
    /// Whether actuators are called before each physics step, instead of once per advance.
    pub every_physics_step: bool,
    /// The interned keys `<kind>.<parameter>`.
    pub param_props: Vec<u32>,
    /// The interned keys `<kind>.<command>`.
    pub command_props: Vec<u32>,
    /// Index of the actuator's readings among the kinds of sensors, if it has any.
    pub readings: Option<usize>,
    /// Copy of the table that the plugin provides; without functions for a part.
    pub raw: tatu_actuator,
    /// Copy of the table of a kind of part, which is declared and created like an actuator, but called alone.
    pub part: Option<tatu_part>,
    /// Names of the events that a part receives, or `*`.
    pub events: Vec<String>,
    /// Presets of a part, in order of declaration; actuators have none.
    pub presets: Vec<PresetSpec>,
    /// Functions that create, configure, save and destroy instances.
    pub life: tatu_life,
}

/// A plugin that receives events.
pub struct EventListener {
    /// Index of the plugin in the registry.
    pub plugin: usize,
    /// Names of the events, or `*`.
    pub names: Vec<String>,
    /// The function that receives them.
    pub heard: HeardFn,
}

/// The declarations of a kind of sensor or actuator.
#[derive(Clone, Copy)]
pub struct DeviceKind<'a> {
    /// Index of the plugin in the registry.
    pub plugin: usize,
    /// Id, by which scene files refer to it.
    pub id: &'a str,
    /// Declared parameters, in order.
    pub params: &'a [ParameterSpec],
    /// Declared commands; empty for a sensor.
    pub commands: &'a [ParameterSpec],
}

impl<'a> DeviceKind<'a> {
    /// Returns the declarations of all keys that a scene can set.
    pub fn all_params(self) -> impl Iterator<Item = &'a ParameterSpec> {
        self.params.iter().chain(self.commands)
    }
}

/// An importer, which reads files in another format.
pub struct Importer {
    /// Index of the plugin in the registry.
    pub plugin: usize,
    /// Id, by which scene files refer to it.
    pub id: String,
    /// Description in one sentence.
    pub text: String,
    /// Suffixes of file names, including the dot.
    pub suffixes: Vec<String>,
    /// Declared parameters, in order.
    pub params: Vec<ParameterSpec>,
    /// Copy of the table that the plugin provides.
    pub(crate) raw: tatu_importer,
}

/// The importer chosen for a file, and notes about the choice.
#[derive(Debug, PartialEq, Eq)]
pub struct ImporterChoice {
    /// Index of the importer in the registry.
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
    pub(super) fn sniff(&self, plugin: &Plugin, head: &[u8]) -> u32 {
        let head = crate::border::raw(head);
        // SAFETY: `f` is from this plugin, which has not been shut down, and `me` is its own pointer. The bytes live
        // until the call has returned.
        self.raw.sniff.map_or(0, |f| unsafe { f(plugin.me, head) })
    }
}

/// A word that identifies the kind of a script.
pub struct ScriptKindMark {
    /// Id of the script language.
    pub language: String,
    /// Kind of the scripts that the word identifies.
    pub kind: String,
    /// The word to search for.
    pub word: String,
    /// Whether the last line must begin with the word. Otherwise, a name anywhere in the source must begin with it.
    pub last: bool,
}

impl ScriptKindMark {
    pub(super) fn matches_script(&self, text: &[u8]) -> bool {
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
    /// Index of the plugin in the registry.
    pub plugin: usize,
    /// Id, by which scene files and the command line refer to it.
    pub id: String,
    /// Description in one sentence.
    pub text: String,
    /// Declared parameters, in order.
    pub params: Vec<ParameterSpec>,
    /// Names of the events that the service subscribes to.
    pub events: Vec<String>,
    /// Copy of the table that the plugin provides.
    pub raw: tatu_service,
    /// Functions that create, configure, save and destroy instances.
    pub life: tatu_life,
}

/// A model in the list of all models.
#[derive(Debug, Clone)]
pub struct ListedModel {
    pub id: String,
    pub text: String,
    /// The heading in lists, such as "mobile robots"; may be empty.
    pub category: String,
}

impl ListedModel {
    pub(super) fn of(model: &Model) -> ListedModel {
        ListedModel { id: model.id.clone(), text: model.text.clone(), category: model.category.clone() }
    }
}
