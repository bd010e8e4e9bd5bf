//! The input log as a file of JSON lines, which is sufficient for a replay without the files of the scene.
//!
//! The first line is the [`InputLogHeader`], with versions, command-line options, and the contents of every file from
//! which the document was read. It is followed by one line per [`InputRecord`] and a last line with the number of
//! steps. Each line is written before its record takes effect, so that the log of a killed run is usable.
//!
//! Each line ends with a checksum of itself and all previous lines, so lines that are missing, reordered or edited are
//! detected. The last line contains the hash of the world. A truncated log is not treated as damaged: its complete
//! lines are replayed.

use std::{
    fs::File,
    io::{BufWriter, Write},
    path::{Path, PathBuf},
};

use base64::{Engine, engine::general_purpose::STANDARD};
use serde::{Deserialize, Serialize};
use serde_json::{Value as Json, json};
use tatu_errors::{Error, Result, SourceLocation};
use tatu_plugins::Registry;
use tatu_scene::document::{Document, LoadOptions, PropertyOverride, ScriptOverride, SourceFiles};

use super::json;
use crate::cell::{ExternalInput, InputRecord, REQUEST_NAMES};

const FORMAT_VERSION: u64 = 2;

/// The information that a replay needs in addition to the records.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct InputLogHeader {
    /// Version of the format.
    pub tatu_input_log: u64,
    /// Version of the program that wrote the log.
    pub tatu: String,
    /// The path of the scene, as given by the user.
    pub scene: PathBuf,
    /// The seed given on the command line.
    pub seed: Option<u64>,
    /// The values of `--set` on the command line.
    pub set: Vec<String>,
    /// The values of `--script` on the command line.
    pub scripts: Vec<String>,
    /// The names of values with neutral contents, if stand-ins were created for missing objects.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stand_ins: Option<Vec<String>>,
    /// Add-ons that ran, in order. Their files are in `files`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub addons: Vec<AddonEntry>,
    /// Whether the log begins when the scene was opened, and includes the inputs of clients before the start of the
    /// simulation.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub session: bool,
    /// Plugins that were loaded, except those that offer only services, which a replay does not start.
    pub plugins: Vec<PluginVersion>,
    /// Every file from which the document was read.
    files: Vec<LoggedFile>,
}

/// An add-on that ran.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct AddonEntry {
    /// Name of the add-on.
    pub name: String,
    /// Script file of the add-on.
    pub file: PathBuf,
    /// Dialect of the script; if empty, it is inferred from the source.
    pub dialect: String,
    /// The options with which it was started.
    pub options: Vec<(String, String)>,
}

/// A plugin and its version.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PluginVersion {
    /// Id of the plugin.
    pub id: String,
    /// Version of the plugin.
    pub version: String,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct LoggedFile {
    path: PathBuf,
    #[serde(skip_serializing_if = "Option::is_none")]
    text: Option<String>,
    /// The contents as base64, if they are not valid UTF-8.
    #[serde(skip_serializing_if = "Option::is_none")]
    bytes: Option<String>,
}

impl InputLogHeader {
    /// Creates the header for a document that is about to run; `seed`, `set` and `scripts` are as given on the command
    /// line.
    pub fn new(
        document: &Document,
        registry: &Registry,
        seed: Option<u64>,
        set: Vec<String>,
        scripts: Vec<String>,
    ) -> Self {
        let files = document.sources.files().into_iter().map(|(path, bytes)| match std::str::from_utf8(&bytes) {
            Ok(text) => LoggedFile { path, text: Some(text.to_owned()), bytes: None },
            Err(_) => LoggedFile { path, text: None, bytes: Some(STANDARD.encode(&bytes)) },
        });
        let scene = document.file.clone().unwrap_or_default();
        InputLogHeader { seed, set, scripts, files: files.collect(), ..Self::of_pack(&scene, registry) }
    }

    /// Creates the header for a run of a packed scene, which contains all files and the changes of the command line.
    pub fn of_pack(scene: &Path, registry: &Registry) -> Self {
        InputLogHeader {
            tatu_input_log: FORMAT_VERSION,
            tatu: env!("CARGO_PKG_VERSION").to_owned(),
            scene: scene.to_owned(),
            seed: None,
            set: Vec::new(),
            scripts: Vec::new(),
            stand_ins: None,
            addons: Vec::new(),
            session: false,
            plugins: versions(registry),
            files: Vec::new(),
        }
    }

    /// Returns the path and the contents, as text or in base64, of every file from which the document was read.
    pub fn files(&self) -> impl Iterator<Item = (&Path, &str)> {
        self.files.iter().map(|f| (f.path.as_path(), f.text.as_deref().or(f.bytes.as_deref()).unwrap_or_default()))
    }

    /// Returns options that read the document from the files in the log, with the original command-line options.
    pub fn options(&self) -> Result<LoadOptions> {
        let mut files = Vec::new();
        for f in &self.files {
            let bytes = match (&f.text, &f.bytes) {
                (Some(text), _) => text.clone().into_bytes(),
                (None, Some(bytes)) => STANDARD.decode(bytes).map_err(|e| {
                    Error::new("E116", format!("the file {} in the input log is damaged: {e}", f.path.display()))
                })?,
                (None, None) => Vec::new(),
            };
            files.push((f.path.clone(), bytes));
        }
        Ok(LoadOptions {
            seed: self.seed,
            set: self.set.iter().map(|s| PropertyOverride::parse(s)).collect::<Result<_>>()?,
            scripts: self.scripts.iter().map(|s| ScriptOverride::parse(s)).collect::<Result<_>>()?,
            services: Vec::new(),
            // Programs are those of the machine that replays the log.
            languages: Vec::new(),
            describe: false,
            sources: SourceFiles::of(files),
            reach: None,
            // A replay does not start external programs.
            allow: Vec::new(),
            // A replay does not start services.
            user_settings: Default::default(),
        })
    }

    /// Describes the differences between the program and plugins that wrote the log and those of this process, one
    /// sentence each.
    pub fn differences(&self, registry: &Registry) -> Vec<String> {
        let here = versions(registry);
        let differs = |p: &PluginVersion| match here.iter().find(|h| h.id == p.id) {
            None => Some(format!("the plugin `{}` {} is missing", p.id, p.version)),
            Some(h) if h.version != p.version => {
                Some(format!("the plugin `{}` had version {}, but has version {} here", p.id, p.version, h.version))
            }
            Some(_) => None,
        };
        let program = (self.tatu != env!("CARGO_PKG_VERSION"))
            .then(|| format!("the program had version {}, but has {} here", self.tatu, env!("CARGO_PKG_VERSION")));
        program.into_iter().chain(self.plugins.iter().filter_map(differs)).collect()
    }
}

fn versions(registry: &Registry) -> Vec<PluginVersion> {
    let only_services = |i: usize| {
        registry.services.iter().any(|s| s.plugin == i)
            && !registry.command_offers.commands.iter().any(|c| c.plugin == i)
            && !registry.sensors.iter().any(|s| s.plugin == i)
            && !registry.actuators.iter().any(|a| a.plugin == i)
            && !registry.model_offers.models.iter().any(|m| m.plugin == i)
            && !registry.scripting.languages.iter().any(|l| l.plugin == i)
    };
    let used = registry.plugins.iter().enumerate().filter(|(i, _)| !only_services(*i));
    used.map(|(_, p)| PluginVersion { id: p.id.clone(), version: p.version.clone() }).collect()
}

/// A log that is being written.
pub struct InputLogWriter {
    file: BufWriter<File>,
    path: PathBuf,
    /// Checksum of all lines so far.
    check: u64,
}

/// The string between the contents of a line and its checksum.
const CHECKSUM_KEY: &str = ",\"check\":\"";

/// Returns the checksum of a line, given without its closing brace and its checksum. `before` is the checksum of the
/// previous line.
fn checksum_of(before: u64, line: &[u8]) -> u64 {
    xxhash_rust::xxh3::xxh3_64_with_seed(line, before)
}

/// Returns the checksum of a line, if it matches the one written in the line.
fn verify_line(before: u64, line: &[u8]) -> Option<u64> {
    let rest = line.strip_suffix(b"\"}")?;
    let (rest, digits) = rest.split_at_checked(rest.len().checked_sub(16)?)?;
    let found = u64::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?;
    let right = checksum_of(before, rest.strip_suffix(CHECKSUM_KEY.as_bytes())?);
    // Upper-case digits would be parsed as the same number, but are never written.
    (found == right && !digits.iter().any(u8::is_ascii_uppercase)).then_some(right)
}

impl InputLogWriter {
    /// Creates the file and writes the header.
    pub fn create(path: &Path, header: &InputLogHeader) -> Result<Self> {
        let file = File::create(path)
            .map_err(|e| Error::new("E105", format!("cannot write the input log {}: {e}", path.display())))?;
        let mut writer = InputLogWriter { file: BufWriter::new(file), path: path.to_owned(), check: 0 };
        writer.line(&json!(header))?;
        writer.flush()?;
        Ok(writer)
    }
    /// Writes a record and flushes it to the operating system.
    pub fn write(&mut self, record: &InputRecord) -> Result {
        self.line(&record_json(record))?;
        self.flush()
    }
    /// Writes the last line. `steps` is the number of steps, and `begun` specifies whether the barrier after them had
    /// begun. `opened` contains the names of files that were read during the run and are not in the log. `hash` is the
    /// world's total hash after the last step.
    pub fn end(mut self, steps: u64, begun: bool, opened: &[String], hash: u64) -> Result {
        let mut line = json!({ "end": steps, "begun": begun, "hash": format!("{hash:016x}") });
        if !opened.is_empty() {
            line["opened"] = json!(opened);
        }
        self.line(&line)?;
        self.flush()
    }
    fn line(&mut self, line: &Json) -> Result {
        let text = line.to_string();
        let open = text.strip_suffix('}').unwrap_or(&text);
        self.check = checksum_of(self.check, open.as_bytes());
        writeln!(self.file, "{open}{CHECKSUM_KEY}{:016x}\"}}", self.check).map_err(|e| self.failed(&e))
    }
    fn flush(&mut self) -> Result {
        self.file.flush().map_err(|e| self.failed(&e))
    }
    fn failed(&self, e: &std::io::Error) -> Error {
        Error::new("E105", format!("the input log {} cannot be continued: {e}", self.path.display()))
    }
}

fn record_json(r: &InputRecord) -> Json {
    let mut line = json!({ "step": r.step, "at": r.at, "service": r.service, "client": r.client });
    match &r.input {
        ExternalInput::Call { name, args, waits } => {
            line["call"] = json!(name);
            line["args"] = args.iter().map(json::write).collect();
            if *waits {
                line["waits"] = json!(true);
            }
        }
        ExternalInput::Event { kind, text } => {
            line["input"] = json!(kind);
            line["text"] = json!(text);
        }
        ExternalInput::Request(what) => {
            line["request"] = json!(REQUEST_NAMES.iter().find(|(_, n)| n == what).map_or("", |(name, _)| *name));
        }
        ExternalInput::Pass => line["pass"] = json!(true),
        ExternalInput::Observed { kind, text } => {
            line["observed"] = json!(kind);
            line["text"] = json!(text);
        }
    }
    line
}

/// A log that has been read.
#[derive(Debug)]
pub struct RecordedRun {
    /// Header of the log.
    pub header: InputLogHeader,
    /// The external inputs, in order.
    pub records: Vec<InputRecord>,
    /// Number of steps of the run, or `None` if the run was killed.
    pub end: Option<u64>,
    /// Whether the run ended within the barrier after its last step, so that the inputs of that barrier belong to it.
    pub begun: bool,
    /// Files that were read during the run but are not in the log; a replay reads them from disk.
    pub opened: Vec<String>,
    /// Hash of the world after the last step.
    pub hash: Option<u64>,
    /// Whether the last line of the file is truncated. Such a line is not part of the log.
    pub is_truncated: bool,
}

impl RecordedRun {
    /// Returns the number of steps of the run or, if the run was killed, the step of the last record.
    pub fn steps(&self) -> u64 {
        self.end.unwrap_or_else(|| self.records.last().map_or(0, |r| r.step))
    }
}

/// Maximum size of an input log or snapshot to be read, bytes. The limit is generous because the program writes these
/// files itself.
pub(crate) const MAX_OWN_FILE_BYTES: u64 = 4 << 30;

/// Reads a log. Fails with E105 if the file cannot be read, and with E116 if it is not an input log or is damaged.
pub fn read(path: &Path) -> Result<RecordedRun> {
    let bytes = tatu_plugin_api::safe::read_plain(path, MAX_OWN_FILE_BYTES)
        .map_err(|e| Error::new("E105", format!("cannot read the input log {}: {e}", path.display())))?;
    let wrong = |line: usize, text: String| {
        let place = SourceLocation { file: path.to_owned(), line, column: 1, span: 0..0 };
        Error::new("E116", text).at(Some(place))
    };
    let mut lines: Vec<&[u8]> = bytes.split(|b| *b == b'\n').collect();
    // The text after the last newline is empty, or a line that was only partly written.
    let cut = lines.pop().is_some_and(|rest| !rest.is_empty());
    let first = lines.first().ok_or_else(|| {
        wrong(0, format!("{} is not a complete input log", path.display()))
            .help("write one with `tatu run SCENE --log FILE`")
    })?;
    match serde_json::from_slice::<Json>(first).ok().as_ref().and_then(|j| j["tatu_input_log"].as_u64()) {
        Some(FORMAT_VERSION) => {}
        Some(n) => {
            let text = format!("the input log has format {n}");
            return Err(wrong(1, text)
                .expected(format!("format {FORMAT_VERSION}"))
                .help("replay it with the program that wrote it"));
        }
        None => {
            let text = format!("{} is not an input log", path.display());
            return Err(wrong(1, text).help("write one with `tatu run SCENE --log FILE`"));
        }
    }
    let changed = |line: usize| {
        let text = match line {
            1 => "the header of the input log is damaged: it was edited, or bytes in it were changed".to_owned(),
            n => format!(
                "the input log is damaged at line {n}: it was changed, or lines before it are missing or in a \
                 different order"
            ),
        };
        wrong(line, text)
            .help("copy the log again from an intact original, or write it again with `tatu run SCENE --log FILE`")
    };
    let mut check = verify_line(0, first).ok_or_else(|| changed(1))?;
    let header =
        serde_json::from_slice(first).map_err(|e| wrong(1, format!("the input log's header is damaged: {e}")))?;
    let mut log = RecordedRun {
        header,
        records: Vec::new(),
        end: None,
        begun: true,
        opened: Vec::new(),
        hash: None,
        is_truncated: cut,
    };
    for (i, line) in lines.iter().enumerate().skip(1) {
        check = verify_line(check, line).ok_or_else(|| changed(i + 1))?;
        let json: Json = serde_json::from_slice(line)
            .map_err(|e| wrong(i + 1, format!("this line of the input log is damaged: {e}")))?;
        if let Some(steps) = json.get("end").and_then(Json::as_u64) {
            log.end = Some(steps);
            let opened = json["opened"].as_array().into_iter().flatten();
            log.opened = opened.filter_map(|f| f.as_str().map(str::to_owned)).collect();
            log.begun = json["begun"].as_bool().unwrap_or(true);
            log.hash = json["hash"].as_str().and_then(|h| u64::from_str_radix(h, 16).ok());
            continue;
        }
        let record = record(&json).filter(|_| log.end.is_none()).ok_or_else(|| {
            wrong(i + 1, "this line of the input log is damaged".into())
                .expected("a call, a request, an input or a pass")
        })?;
        if log.records.last().is_some_and(|before| (before.step, before.at) >= (record.step, record.at)) {
            return Err(wrong(i + 1, "this line of the input log is not later than the previous line".into())
                .expected("increasing steps and positions"));
        }
        log.records.push(record);
    }
    Ok(log)
}

/// Converts records to the lines in which snapshots store them.
pub(crate) fn to_bytes(records: &[InputRecord]) -> Vec<u8> {
    records.iter().flat_map(|r| format!("{}\n", record_json(r)).into_bytes()).collect()
}

/// Reads records that `to_bytes` wrote. Returns `None` if they are damaged.
pub(crate) fn from_bytes(bytes: &[u8]) -> Option<Vec<InputRecord>> {
    let lines = bytes.split(|b| *b == b'\n').filter(|l| !l.is_empty());
    lines.map(|l| record(&serde_json::from_slice(l).ok()?)).collect()
}

fn record(json: &Json) -> Option<InputRecord> {
    let input = match (json.get("call"), json.get("request"), json.get("input")) {
        (None, None, Some(kind)) => {
            ExternalInput::Event { kind: kind.as_str()?.to_owned(), text: json.get("text")?.as_str()?.to_owned() }
        }
        (Some(name), None, None) => ExternalInput::Call {
            name: name.as_str()?.to_owned(),
            args: json.get("args")?.as_array()?.iter().map(json::read).collect::<Option<_>>()?,
            waits: json.get("waits").and_then(Json::as_bool).unwrap_or(false),
        },
        (None, Some(name), None) => {
            ExternalInput::Request(REQUEST_NAMES.iter().find(|(n, _)| Some(*n) == name.as_str())?.1)
        }
        (None, None, None) if json.get("pass").is_some() => ExternalInput::Pass,
        (None, None, None) => ExternalInput::Observed {
            kind: json.get("observed")?.as_str()?.to_owned(),
            text: json.get("text")?.as_str()?.to_owned(),
        },
        _ => return None,
    };
    Some(InputRecord {
        step: json.get("step")?.as_u64()?,
        at: json.get("at")?.as_u64()?,
        service: json.get("service")?.as_str()?.to_owned(),
        client: json.get("client")?.as_u64()?,
        input,
    })
}
