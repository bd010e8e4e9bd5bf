//! `tatu measure`: measures the behaviour of a model, and compares it with the model's data sheet.
//!
//! Each function of the model's `card.lua` runs in a separate world, which contains a floor and the model.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
    sync::Arc,
};

use serde_json::{Value as Json, json};
use tatu_core::{
    World,
    document::{self, LoadOptions, SourceFiles},
    errors::Error,
    plugins::Registry,
};
use tatu_plugin_api::{
    abi::TATU_LOG_ERROR,
    safe::{MAX_FILE_BYTES, Value, read_plain_text},
};
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, value};

use super::list;
use tatu_terminal::{Watchdog, report, table};

use crate::{
    args,
    card::{self, CardMeasure, grade::Grade, rounded},
};

/// Helper functions for measures, prepended to each script.
const LUA_HELPERS: &str = include_str!("../card/measure.lua");
/// The signal through which the script returns the measured value.
const RESULT_SIGNAL: &str = "measured";

/// Measures a model. The exit code is 0 if all values agree with the data sheet and with the card, 1 if one does not or
/// a plugin could not be ended, and 2 if a value could not be measured.
pub fn measure(args: &args::MeasureArgs) -> ExitCode {
    let watchdog = Watchdog::start(args.watchdog, false);
    let done = super::registry(None, &SourceFiles::default(), &args::SceneChanges::default(), &watchdog).and_then(
        |registry| {
            let code = measure_all(args, &registry, &watchdog)?;
            Ok(if super::end_plugins(registry) { code } else { ExitCode::FAILURE })
        },
    );
    match done {
        Ok(code) => code,
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

fn measure_all(args: &args::MeasureArgs, registry: &Arc<Registry>, watchdog: &Watchdog) -> Result<ExitCode, Error> {
    let file = model_file(&args.model, registry)?;
    let lacks = || Error::new("E105", format!("there is no card.toml beside {}", file.display()));
    let card = card::read(&file)?
        .ok_or_else(|| lacks().help("docs/plugin-authors/robots.md describes how to write a card"))?;
    let names: Vec<&str> = card.measures.iter().map(|m| m.name.as_str()).collect();
    if let Some(other) = args.only.iter().find(|o| !names.contains(&o.as_str())) {
        let error = Error::new("E130", format!("{} has no measure `{other}`", card.file.display()));
        return Err(error.expected(names.join(", ")).nearest(other, names.iter().copied()));
    }
    let lua = card.file.with_extension("lua");
    let script = read_plain_text(&lua, MAX_FILE_BYTES)
        .map_err(|e| Error::new("E105", format!("{} cannot be read: {e}", lua.display())))?;
    let wanted = |m: &CardMeasure| args.only.is_empty() || args.only.contains(&m.name);
    // A measure that fails does not prevent the others from running.
    let mut failed = false;
    let mut values = Vec::new();
    for m in &card.measures {
        let done = wanted(m).then(|| measure_one(m, &file, &lua, &script, registry, watchdog)).transpose();
        failed |= done.is_err();
        values.push(done.inspect_err(report::error).ok().flatten());
    }
    if args.write {
        card::write(&card, &values)?;
    }
    let rows: Vec<Json> = card.measures.iter().zip(&values).filter_map(|(m, v)| row(m, (*v)?, args.write)).collect();
    print_results(args, registry, &file, &rows)?;
    let good = rows.iter().all(|r| r["verdict"] == "ok");
    Ok(if failed { ExitCode::from(2) } else { ExitCode::from(u8::from(!good)) })
}

/// Returns the file of a model given by its id, its folder or its file.
fn model_file(name: &str, registry: &Registry) -> Result<PathBuf, Error> {
    let path = Path::new(name);
    let files = [path.to_owned(), path.join("model.toml")];
    if let Some(file) = files.into_iter().find(|f| f.is_file()) {
        return Ok(file);
    }
    let found = registry.find_model(name).filter(|f| f.importer.is_none());
    found.map(|f| f.file).ok_or_else(|| {
        Error::new("E130", format!("there is no model `{name}` that is stored in a folder"))
            .expected("the id of a model, or a folder with a `model.toml`")
            .help("`tatu list models` lists all models")
    })
}

/// Runs the function of one measure in a separate world; returns the measured value.
fn measure_one(
    m: &CardMeasure,
    model: &Path,
    lua: &Path,
    script: &str,
    registry: &Arc<Registry>,
    watchdog: &Watchdog,
) -> Result<f64, Error> {
    let fail = |why: String| Error::new("E126", format!("`{}` of {} {why}", m.name, lua.display()));
    let scene = model.with_file_name("card.scene.toml");
    let script = format!("{} {script}", lua_header(m));
    let files = [(scene.clone(), scene_of(m, model).into_bytes()), (lua.to_owned(), script.into_bytes())];
    let options = LoadOptions { sources: SourceFiles::with_replacements(files, false), ..LoadOptions::default() };
    let document = document::load(&scene, registry, &options)?;
    let world = World::new(Arc::new(document), registry.clone())?;
    watchdog.world(&world, false);
    watchdog.begin(None);
    world.start();
    let mut value = None;
    while value.is_none() && world.time() < m.seconds && world.step() {
        watchdog.step(world.steps(), world.time(), None);
        if let Some(line) = world.take_lines().into_iter().find(|l| l.level == TATU_LOG_ERROR) {
            return Err(fail(format!("failed: {}", line.text)));
        }
        value = match world.call("sim.getFloatSignal", &[Value::text(RESULT_SIGNAL)]).ok().as_deref() {
            Some([Value::Float(x), ..]) => Some(*x),
            _ => None,
        };
    }
    world.end();
    match value {
        Some(x) if x.is_finite() => Ok(x),
        Some(x) => Err(fail(format!("returned {x}, but must return a finite number"))),
        None if world.time() < m.seconds => Err(fail("ended the run before it returned a number".into())),
        None => Err(fail(format!("returned no number within {} s of simulation time", m.seconds))),
    }
}

/// Returns the code that precedes the script: the helper functions and the call to the measure, on a single line, so
/// that line numbers in errors are those of card.lua.
fn lua_header(m: &CardMeasure) -> String {
    let shared: Vec<&str> = LUA_HELPERS.lines().map(str::trim).filter(|l| !l.starts_with("--")).collect();
    let name = &m.name;
    format!(
        "{} function sysCall_thread() local value = {name}() \
         if type(value) ~= 'number' then error('{name} returned a ' .. type(value) .. ': expected a number', 0) end \
         sim.setFloatSignal('{RESULT_SIGNAL}', value) end",
        shared.join(" ")
    )
}

/// Returns the scene file of a measure.
fn scene_of(m: &CardMeasure, model: &Path) -> String {
    let mut doc = DocumentMut::new();
    doc["format"] = value(1);
    if !m.scene.is_empty() {
        doc["scene"] = Item::Table(m.scene.clone());
    }
    let mut placed = Table::new();
    placed["file"] = value(model.file_name().unwrap_or_default().to_string_lossy().into_owned());
    m.params.iter().for_each(|(key, item)| placed[key] = item.clone());
    let object = |alias: &str, kind: &str| {
        let mut table = Table::new();
        table["kind"] = value(kind);
        table["alias"] = value(alias);
        table
    };
    let mut floor = object("floor", "shape");
    floor["primitive"] = value("plane");
    floor["respondable"] = value(true);
    let mut measure = object("measure", "dummy");
    measure["script"] = value("card.lua");
    doc["object"] = Item::ArrayOfTables([floor, measure].into_iter().collect());
    doc["model"] = Item::ArrayOfTables(ArrayOfTables::from_iter([placed]));
    doc.to_string()
}

/// Describes a measure as JSON; `measured` is the value from this run.
fn row(m: &CardMeasure, measured: f64, written: bool) -> Option<Json> {
    let verdict = match (m.is_within_tolerance(measured), m.measured) {
        (false, _) => "off",
        (true, None) if !written => "not recorded: use --write",
        (true, Some(_)) if !written && !m.is_recorded(measured) => "recorded otherwise",
        _ => "ok",
    };
    let off = match m.expected {
        0.0 => format!("{measured:.1e}"),
        expected => format!("{:+.2} %", 100.0 * (measured - expected) / expected.abs()),
    };
    Some(json!({
        "measure": m.name, "text": m.text, "measured": rounded(measured), "expected": m.expected, "unit": m.unit,
        "off": off, "allowed": rounded(m.allowed), "recorded": m.measured, "source": m.source, "verdict": verdict,
    }))
}

fn print_results(args: &args::MeasureArgs, registry: &Registry, file: &Path, rows: &[Json]) -> Result<(), Error> {
    if args.json {
        report::out!("{}", serde_json::to_string_pretty(rows).unwrap_or_default());
        return Ok(());
    }
    table(rows, &["measure", "measured", "expected", "unit", "off", "verdict", "source"]);
    let numbers = list::model_at(registry, &args.model, file)?.numbers;
    // The card is read again, since `--write` may have changed it.
    let card = card::read(file)?;
    let grade = Grade::of(&numbers, card.as_ref());
    report::out!("\ngrade {}: {}", grade.letter(), grade.text(&numbers, card.as_ref()));
    Ok(())
}
