//! `tatu diff`: reports where two traces differ.

use std::{
    collections::BTreeSet,
    fs::File,
    io::{BufRead, BufReader, Read, Take},
    path::{Path, PathBuf},
    process::ExitCode,
};

use serde_json::{Map, Value};
use tatu_core::errors::{Error, SourceLocation};
use tatu_plugin_api::safe::{MAX_FILE_BYTES, open_plain};
use tatu_terminal::report;

use crate::args::DiffArgs;

/// Maximum number of differing fields that are shown for an object or reading.
const MAX_FIELDS: usize = 8;

/// Compares two traces. The exit code is 0 if they are equal, 1 if they differ, and 2 if one cannot be read.
pub fn diff(args: &DiffArgs) -> ExitCode {
    match compare(&args.a, &args.b) {
        Ok(None) => ExitCode::SUCCESS,
        Ok(Some(text)) => {
            report::out!("{text}");
            ExitCode::FAILURE
        }
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

/// Describes the first difference; returns `None` if there is none.
fn compare(a: &Path, b: &Path) -> Result<Option<String>, Error> {
    let (mut lines_a, mut lines_b) = (TraceReader::open(a)?, TraceReader::open(b)?);
    let mut steps = 0_u64;
    loop {
        let (one, other) = match (lines_a.next_line()?, lines_b.next_line()?) {
            (None, None) => {
                report::out!("equal: {steps} steps");
                return Ok(None);
            }
            (Some(one), Some(other)) if is_after_stop_request(&one) == is_after_stop_request(&other) => (one, other),
            (one, _) => {
                // A trace also ends where a stop was requested.
                let (shorter, longer) = if one.is_none_or(|l| is_after_stop_request(&l)) { (a, b) } else { (b, a) };
                let (shorter, longer) = (shorter.display(), longer.display());
                return Ok(Some(format!("equal for {steps} steps; then {shorter} ends, and {longer} continues")));
            }
        };
        if let Some(text) = first_difference(&one, &other).or_else(|| other_key(&one, &other)) {
            return Ok(Some(text));
        }
        steps += u64::from(!is_after_stop_request(&one));
    }
}

/// Returns whether a line was written after a stop was requested; such lines are not compared.
fn is_after_stop_request(line: &Value) -> bool {
    line["stopping"] == Value::Bool(true)
}

/// A reader of the lines of a trace.
struct TraceReader {
    file: BufReader<Take<File>>,
    path: PathBuf,
    line: usize,
}

impl TraceReader {
    fn open(path: &Path) -> Result<Self, Error> {
        let file = open_plain(path, u64::MAX)
            .map_err(|e| Error::new("E105", format!("cannot read the trace {}: {e}", path.display())))?;
        Ok(TraceReader { file: BufReader::new(file), path: path.to_owned(), line: 0 })
    }

    fn next_line(&mut self) -> Result<Option<Value>, Error> {
        let mut line = Vec::new();
        let read = self.file.by_ref().take(MAX_FILE_BYTES).read_until(b'\n', &mut line);
        if matches!(read, Ok(0)) {
            return Ok(None);
        }
        self.line += 1;
        let wrong = |text: String| {
            let place = SourceLocation { file: self.path.clone(), line: self.line, column: 1, span: 0..0 };
            Err(Error::new("E119", text).expected("a trace as `tatu run --trace FILE` writes it").at(Some(place)))
        };
        if line.len() as u64 >= MAX_FILE_BYTES {
            return wrong(format!(
                "line {} of {} is longer than {} MB",
                self.line,
                self.path.display(),
                MAX_FILE_BYTES >> 20
            ));
        }
        let line = match read {
            Ok(_) => line,
            Err(e) => return wrong(format!("line {} of {}: {e}", self.line, self.path.display())),
        };
        match serde_json::from_slice::<Value>(&line) {
            Ok(v) if v["step"].is_u64() && v["hash"].is_string() => Ok(Some(v)),
            Ok(_) => wrong(format!("line {} of {} has no `step` or no `hash`", self.line, self.path.display())),
            Err(e) => wrong(format!("line {} of {} is not JSON: {e}", self.line, self.path.display())),
        }
    }
}

/// Describes the first difference found between two lines of traces; `None` if they agree.
fn first_difference(a: &Value, b: &Value) -> Option<String> {
    if a["step"] != b["step"] {
        return Some(format!("one trace has step {} where the other has step {}", a["step"], b["step"]));
    }
    let at = format!("step {} (t = {} s)", a["step"], a["time"]);
    if a["time"] != b["time"] {
        return Some(format!("{at}: the other trace has t = {} s at this step, so the time steps differ", b["time"]));
    }
    let empty = Map::new();
    let part = |v: &'_ Value, key: &str| v[key].as_object().cloned().unwrap_or_else(|| empty.clone());
    if let (Some(x), Some(y)) = (a["hashes"].as_object(), b["hashes"].as_object())
        && let Some(path) = first_differing_key(x, y)
    {
        let mut text = format!("{at}: {path}{}", missing_in_one(x, y, &path));
        // Show the known values next to the hash.
        for key in ["objects", "readings"] {
            let of = |v| part(v, key).get(&path).cloned().unwrap_or_default();
            text += &differing_fields(&of(a), &of(b));
        }
        return Some(text);
    }
    for key in ["objects", "readings"] {
        let (x, y) = (part(a, key), part(b, key));
        if let Some(path) = first_differing_key(&x, &y) {
            let mut text = format!("{at}: {path}{}", missing_in_one(&x, &y, &path));
            text += &differing_fields(x.get(&path).unwrap_or(&Value::Null), y.get(&path).unwrap_or(&Value::Null));
            if a["hash"] != b["hash"] && a.get("hashes").is_none() {
                text += "\n  this is the first watched object that differs; \
                         write both traces with --hashes to compare all objects";
            }
            return Some(text);
        }
    }
    if a["hash"] != b["hash"] {
        let why = "an object that is not watched differs; write both traces with --hashes to identify it";
        return Some(format!("{at}: {why}"));
    }
    let key = ["statusbar", "console"].into_iter().find(|key| a[*key] != b[*key])?;
    Some(format!("{at}: the output of scripts (`{key}`) differs: {} and {}", a[key], b[key]))
}

/// Describes the first key that differs, apart from those described separately. `hashes` is ignored if only one trace
/// contains it.
fn other_key(a: &Value, b: &Value) -> Option<String> {
    let (a, b) = (a.as_object()?, b.as_object()?);
    let keys: BTreeSet<&String> = a.keys().chain(b.keys()).collect();
    let differs = |key: &&&String| {
        let (x, y) = (a.get(**key), b.get(**key));
        x != y && (key.as_str() != "hashes" || x.is_some() && y.is_some())
    };
    let key = keys.iter().find(differs)?;
    let show = |v: Option<&Value>| v.map_or("nothing".to_owned(), Value::to_string);
    let at = format!("step {} (t = {} s)", a["step"], a["time"]);
    Some(format!("{at}: `{key}`: {} and {}", show(a.get(*key)), show(b.get(*key))))
}

/// Returns the first key, in alphabetical order, whose values differ. An object's path precedes those of its children.
fn first_differing_key(a: &Map<String, Value>, b: &Map<String, Value>) -> Option<String> {
    let keys: BTreeSet<&String> = a.keys().chain(b.keys()).collect();
    keys.into_iter().find(|k| a.get(*k) != b.get(*k)).cloned()
}

fn missing_in_one(a: &Map<String, Value>, b: &Map<String, Value>, path: &str) -> &'static str {
    match (a.contains_key(path), b.contains_key(path)) {
        (true, false) => " is in the first trace only",
        (false, true) => " is in the second trace only",
        _ => "",
    }
}

/// Returns the first `MAX_FIELDS` fields of an object or reading that differ, with both values. Fields that only the
/// second trace contains are not listed.
fn differing_fields(a: &Value, b: &Value) -> String {
    let (Some(a), Some(b)) = (a.as_object(), b.as_object()) else { return String::new() };
    let differing = a.iter().filter(|(key, x)| b.get(*key) != Some(x)).take(MAX_FIELDS);
    differing.map(|(key, x)| format!("\n  {key}: {x} and {}", b.get(key).unwrap_or(&Value::Null))).collect()
}
