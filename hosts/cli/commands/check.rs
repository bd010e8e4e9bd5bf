//! `tatu check`: reports whether a scene can be loaded and started, and the problems found.

use std::process::ExitCode;

use serde_json::{Value as Json, json};
use tatu_core::{
    World,
    document::{Document, LoadOptions, SourceFiles},
    errors::Fault,
};
use tatu_plugin_api::abi::TATU_REPORT_NOTE;

use super::describe::facts::to_json;
use tatu_terminal::{Watchdog, report};

use crate::args::CheckArgs;

/// Checks a scene; the exit code is 0 if it starts, otherwise 2.
pub fn check(args: &CheckArgs) -> ExitCode {
    let watchdog = Watchdog::start(args.watchdog, false);
    let options = args.changes.options(&[]).map(|o| LoadOptions { describe: args.json, ..o });
    let mut problems = Vec::new();
    let world =
        super::registry(Some(&args.scene), &SourceFiles::default(), &args.changes, &watchdog).and_then(|registry| {
            let document = super::load(&args.scene, &options?, &registry)?;
            let numbers = args.numbers.then(|| super::numbers::numbers(&document));
            let described = args.json.then(|| described(args, &document));
            let warnings = document.reports.iter().filter(|r| r.severity != TATU_REPORT_NOTE);
            problems = warnings.map(|r| r.text.clone()).collect();
            let world = World::new(document, registry)?;
            // The description is printed only if the world could be created.
            if let Some(numbers) = numbers {
                report::out!("{numbers}");
            }
            if let Some(mut json) = described {
                add_mechanisms(&mut json, &world);
                report::out!("{json}");
            }
            Ok(world)
        });
    match world {
        Ok(world) => {
            // A scene starts even if one of its scripts does not compile; starting the scene here reports such errors.
            watchdog.world(&world, false);
            world.start();
            world.mechanics().iter().for_each(|text| report::warn_text(text));
            world.take_lines().iter().for_each(|l| report::warn_text(&l.text));
            if !args.json && !args.numbers {
                report::out!("{}: {}", args.scene.display(), verdict(&problems, &world.faults()));
            }
            ExitCode::SUCCESS
        }
        Err(e) => {
            report::error(&e);
            if !args.json && !args.numbers {
                report::out!("{}: cannot run: {}", args.scene.display(), e.text);
            }
            ExitCode::from(2)
        }
    }
}

/// Returns a one-line summary: whether the scene runs without problems, or with which.
fn verdict(problems: &[String], faults: &[Fault]) -> String {
    let faults = faults.iter().map(|f| &f.message);
    let all: Vec<String> = problems.iter().chain(faults).map(|text| shortened(text)).collect();
    match all.as_slice() {
        [] => "runs".to_owned(),
        [one] => format!("runs, but with one problem: {one}"),
        all => format!("runs, but with {} problems: {}", all.len(), all.join("; ")),
    }
}

/// Returns the first sentence of a report, cut to `MAX_REPORT_CHARS` characters. The file name is removed, because the
/// summary starts with it.
fn shortened(text: &str) -> String {
    let rest =
        text.split_once(": ").filter(|(file, _)| file.contains('.') && !file.contains(' ')).map_or(text, |(_, r)| r);
    let rest = rest.strip_prefix("without ").unwrap_or(rest);
    let sentence = rest.split(". ").next().unwrap_or(rest);
    match sentence.char_indices().nth(MAX_REPORT_CHARS) {
        Some((at, _)) => format!("{}...", &sentence[..at]),
        None => sentence.to_owned(),
    }
}

/// Maximum length of a report in the summary, in characters.
const MAX_REPORT_CHARS: usize = 120;

/// Adds the solver of each mechanism, keyed by the path of the mechanism's first shape.
fn add_mechanisms(json: &mut Json, world: &World) {
    let solvers: serde_json::Map<String, Json> =
        world.mechanisms().into_iter().map(|(path, solver)| (path, json!(solver))).collect();
    if let Some(map) = json.as_object_mut().filter(|_| !solvers.is_empty()) {
        map.insert("mechanisms".into(), Json::Object(solvers));
    }
}

/// Returns the importer's description of the file, or an empty object if it provides none, and adds the file's name.
/// The texts of all reports are added too, unless the description has its own `report`.
fn described(args: &CheckArgs, document: &Document) -> Json {
    let mut out = document.description.as_ref().map(to_json).filter(Json::is_object).unwrap_or_else(|| json!({}));
    if let Some(map) = out.as_object_mut() {
        let name = args.scene.file_name().map(|n| n.to_string_lossy().into_owned());
        map.insert("file".into(), json!(name.unwrap_or_default()));
        map.entry("report").or_insert_with(|| {
            let texts: Vec<&str> = document.reports.iter().map(|r| r.text.as_str()).collect();
            json!(texts)
        });
    }
    out
}
