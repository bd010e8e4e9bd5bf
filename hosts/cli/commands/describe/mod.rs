//! `tatu describe`: prints everything about an id.
//!
//! `facts` collects the information as JSON, `example` builds TOML that is valid in a scene, and this file prints them.

mod example;
pub(crate) mod facts;
mod pages;
mod picture;

use std::process::ExitCode;

use serde_json::{Value, json};
use tatu_core::{document::SourceFiles, errors::Error};
use tatu_terminal::{Watchdog, report, table};

use crate::args::{DescribeArgs, SceneChanges};

/// Maximum number of a plugin's commands that are listed with descriptions; if there are more, only names are listed.
const MAX_DESCRIBED_COMMANDS: usize = 20;
/// Maximum number of a plugin's commands that are listed by name; if there are more, only their count is printed.
const MAX_LISTED_COMMANDS: usize = 200;
/// Width of lists of names, in columns.
const LIST_COLUMNS: usize = 100;

/// Prints the descriptions of ids; the exit code is 2 if an id does not exist.
pub fn describe(args: &DescribeArgs) -> ExitCode {
    let watchdog = Watchdog::start(args.watchdog, false);
    let changes = SceneChanges { allow: args.allow.clone(), ..SceneChanges::default() };
    let registry = match super::registry(args.scene.as_deref(), &SourceFiles::default(), &changes, &watchdog) {
        Ok(r) => r,
        Err(e) => {
            report::error(&e);
            return ExitCode::from(2);
        }
    };
    if let Some(folder) = args.markdown.as_deref().filter(|_| args.all) {
        return match pages::write(&registry, folder) {
            Ok(n) => {
                report::out!("{n} pages in {}", folder.display());
                ExitCode::SUCCESS
            }
            Err(e) => {
                report::error(&Error::new("E105", format!("{} cannot be written: {e}", folder.display())));
                ExitCode::from(2)
            }
        };
    }
    let mut all = Vec::new();
    for id in &args.ids {
        let found = facts::all(&registry, id);
        if !found.is_empty() {
            all.push(found);
            continue;
        }
        let names = facts::names(&registry);
        report::error(
            &Error::new("E130", format!("nothing has the id or name `{id}`"))
                .expected("a plugin, kind of sensor, actuator or part, model, importer, script language, service, schema, object kind or command")
                .help("`tatu list plugins`, `models`, `sensors`, `actuators`, `parts`, `importers`, `services` and `commands` \
                       show what is available; models in folders are found from the folder that contains `models/`, \
                       with `--scene FILE`, or by TATU_MODEL_PATH")
                .nearest(id, names.iter().map(String::as_str)),
        );
        return ExitCode::from(2);
    }
    if let Some(file) = &args.picture
        && let Err(e) = picture::write(&registry, &args.ids, file)
    {
        report::error(&e);
        return ExitCode::from(2);
    }
    if args.json {
        // Several items of different types may share an id.
        let mut items: Vec<Value> = all.into_iter().map(with_others).collect();
        let items = if items.len() == 1 { items.remove(0) } else { Value::Array(items) };
        report::out!("{}", serde_json::to_string_pretty(&items).unwrap_or_default());
    } else {
        for (i, fact) in all.iter().flatten().enumerate() {
            if i > 0 {
                report::out!("");
            }
            print(fact);
        }
    }
    ExitCode::SUCCESS
}

/// Returns the first fact about an id, with the others nested in it.
fn with_others(mut found: Vec<Value>) -> Value {
    let mut first = found.remove(0);
    if !found.is_empty() {
        first["also"] = Value::Array(found);
    }
    first
}

fn print(fact: &Value) {
    let text = |key: &str| fact[key].as_str().unwrap_or_default();
    let plugin = if text("plugin").is_empty() { String::new() } else { format!(" (plugin {})", text("plugin")) };
    report::out!("{} {}{plugin}", text("what"), text("id"));
    for line in [text("text"), text("frame")].iter().filter(|t| !t.is_empty()) {
        report::out!("  {line}");
    }
    for key in ["version", "category", "licence", "abi", "path", "file", "grade", "no_wait", "permission"] {
        if let Some(t) = fact[key].as_str().filter(|t| !t.is_empty()) {
            report::out!("  {}: {t}", key.replace('_', " "));
        }
    }
    for key in [
        "names",
        "schemas",
        "suffixes",
        "mounts",
        "not_shown",
        "sensors",
        "actuators",
        "parts",
        "models",
        "importers",
        "languages",
        "services",
    ] {
        names(&key.replace('_', " "), &fact[key]);
    }
    section("slots", &fact["slots"], &["name", "mount", "payload_kg", "text"]);
    section("parameters", &fact["parameters"], &["name", "type", "unit", "range", "default", "text"]);
    section("measures", &fact["measures"], &["text", "measured", "sheet", "unit", "within", "holds", "source"]);
    // Values that are computed from parameters are those for their defaults.
    let numbers = if fact["parameters"].as_array().is_some_and(|p| !p.is_empty()) {
        "numbers, for the defaults of the parameters"
    } else {
        "numbers"
    };
    section(numbers, &fact["numbers"], &["name", "value", "unit", "source"]);
    section("controls", &fact["controls"], &["name", "type", "unit", "range", "default", "text"]);
    section("returns", &fact["returns"], &["name", "type", "unit", "text"]);
    section("fields", &fact["fields"], &["name", "element", "shape", "unit", "text", "nothing"]);
    presets(&fact["presets"]);
    if let Some(commands) = fact["commands"].as_array().filter(|c| !c.is_empty()) {
        if commands.len() <= MAX_DESCRIBED_COMMANDS {
            section("commands", &fact["commands"], &["name", "text"]);
        } else if commands.len() > MAX_LISTED_COMMANDS {
            report::out!("commands: {}, see `tatu list commands`; `tatu describe NAME` for details", commands.len());
        } else {
            let all: Vec<_> = commands.iter().map(|c| c["name"].clone()).collect();
            names(&format!("commands ({}, `tatu describe NAME` for details)", all.len()), &Value::Array(all));
        }
    }
    if !text("example").is_empty() {
        report::out!("\nexample:");
        text("example").lines().for_each(|l| report::out!("{}", format!("  {l}").trim_end()));
    }
}

/// Prints presets, each with its settings.
fn presets(list: &Value) {
    let Some(list) = list.as_array().filter(|l| !l.is_empty()) else { return };
    report::out!("\npresets:");
    for p in list {
        report::out!(
            "{}",
            format!("  {}  {}", p["id"].as_str().unwrap_or_default(), p["text"].as_str().unwrap_or_default())
                .trim_end()
        );
        let lines = p["settings"].as_str().unwrap_or_default().lines();
        lines.filter(|l| !l.trim().is_empty()).for_each(|l| report::out!("    {}", l.trim_end()));
    }
}

/// Prints a list of names in lines of limited length.
fn names(title: &str, list: &Value) {
    let Some(list) = list.as_array().filter(|l| !l.is_empty()) else { return };
    let mut line = format!("{title}:");
    for (i, name) in list.iter().filter_map(Value::as_str).enumerate() {
        let comma = if i + 1 < list.len() { "," } else { "" };
        if line.len() + name.len() > LIST_COLUMNS {
            report::out!("{line}");
            line = String::from("   ");
        }
        line += &format!(" {name}{comma}");
    }
    report::out!("{line}");
}

fn section(title: &str, rows: &Value, columns: &[&str]) {
    let Some(rows) = rows.as_array().filter(|r| !r.is_empty()) else { return };
    report::out!("\n{title}:");
    let cell = |v: &Value, column: &str| match (column, v) {
        ("range", Value::Array(r)) => {
            let end = |v: &Value| v.as_f64().map(short);
            match (end(&r[0]), end(&r[1])) {
                (Some(a), Some(b)) => format!("{a} to {b}"),
                (Some(a), None) => format!("from {a}"),
                (None, Some(b)) => format!("to {b}"),
                _ => String::new(),
            }
        }
        (_, Value::Null) => String::new(),
        (_, Value::String(s)) => s.clone(),
        (_, Value::Number(n)) => n.as_f64().map_or(n.to_string(), short),
        (_, Value::Array(a)) if column == "shape" => {
            let word = |v: &Value| v.as_str().map_or_else(|| v.to_string(), str::to_owned);
            a.iter().map(word).collect::<Vec<_>>().join(" x ")
        }
        (_, other) => other.to_string(),
    };
    let shown: Vec<Value> = rows
        .iter()
        .map(|row| {
            columns
                .iter()
                .map(|c| ((*c).to_owned(), json!(cell(&row[*c], c))))
                .collect::<serde_json::Map<_, _>>()
                .into()
        })
        .collect();
    // Empty columns are left out.
    let used: Vec<&str> = columns
        .iter()
        .copied()
        .filter(|c| shown.iter().any(|r| r[*c].as_str().is_some_and(|t| !t.is_empty())))
        .collect();
    table(&shown, &used);
}

/// Formats a number without insignificant digits: 1.5707963267948966 as 1.5708.
fn short(x: f64) -> String {
    let rounded = (x * 1e4).round() / 1e4;
    if (rounded - x).abs() <= 5e-5 * x.abs() || x == 0.0 { format!("{rounded}") } else { format!("{x}") }
}
