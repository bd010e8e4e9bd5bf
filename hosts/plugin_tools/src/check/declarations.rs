//! Tests of declarations: errors found while the plugin is loaded, and problems that do not prevent loading.

use std::path::Path;

use tatu_core::{errors::Error, plugins::ParameterSpec};

use super::{
    finding::{self, error, warning},
    subject::TestedPlugin,
};

/// Runs the test `declarations`.
pub fn run(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    finding::report_activity("", "when its declarations are read");
    for e in &subject.refused {
        let text = subject.readable(&e.text);
        let text = text.split_once("): ").map_or(text.as_str(), |(_, rest)| rest);
        let help = e.help.as_ref().map_or(String::new(), |h| format!(" ({h})"));
        error("", format!("{text}{help}"));
    }
    about(&subject);
    parameters(&subject);
    offers(&subject);
    Ok(())
}

/// Checks the plugin's name, version, licence, id and file name.
fn about(subject: &TestedPlugin) {
    let p = &subject.registry.plugins[subject.plugin];
    if p.name.is_empty() {
        error("", "its `name`, for display, is empty");
    }
    let numbers: Vec<&str> = p.version.split(['-', '+']).next().unwrap_or("").split('.').collect();
    if numbers.len() < 2 || numbers.iter().any(|n| n.parse::<u32>().is_err()) {
        error("", format!("its version `{}` is not of a form such as \"1.2.0\"", p.version));
    }
    if let Err(e) = spdx::Expression::parse(&p.licence) {
        let text = format!("its licence `{}` is not an SPDX expression such as \"MIT\": {}", p.licence, e.reason);
        error("", text);
    }
    if !p.id.contains('.') {
        warning("", format!("its id `{}` has no namespace; choose one such as \"org.example.{}\"", p.id, p.id));
    }
    let name = subject.file.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let stem = name.strip_prefix(std::env::consts::DLL_PREFIX).unwrap_or(&name);
    if !stem.starts_with("tatu_") {
        let (prefix, suffix) = (std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
        error("", format!("its file {name} would not be found: plugins are named {prefix}tatu_NAME{suffix}"));
    }
}

/// Checks that parameters, fields, results and presets have descriptions.
fn parameters(subject: &TestedPlugin) {
    let r = &subject.registry;
    let say = |place: String, what: &str, all: &[ParameterSpec]| {
        for p in all.iter().filter(|p| p.text.trim().is_empty()) {
            error(&place, format!("its {what} `{}` has no description (`text`)", p.key));
        }
    };
    let mine = |plugin: usize| plugin == subject.plugin;
    for s in r.sensor_kinds().map(|(_, s)| s).filter(|s| mine(s.plugin)) {
        let place = format!("sensor `{}`", s.id);
        for f in s.fields.iter().filter(|f| f.text.trim().is_empty() && !is_of_schema(&f.name)) {
            error(&place, format!("its field `{}` has no description (`text`)", f.name));
        }
        for p in s.presets.iter().filter(|p| p.text.trim().is_empty()) {
            error(&place, format!("its preset `{}` has no description (`text`)", p.id));
        }
        say(place, "parameter", &s.params);
    }
    for a in r.actuators.iter().filter(|a| mine(a.plugin)) {
        let place = super::devices::actuator_place(a);
        for p in a.presets.iter().filter(|p| p.text.trim().is_empty()) {
            error(&place, format!("its preset `{}` has no description (`text`)", p.id));
        }
        say(place.clone(), "parameter", &a.params);
        say(place, "command", &a.commands);
    }
    for m in r.model_offers.models.iter().filter(|m| mine(m.plugin)) {
        say(format!("model `{}`", m.id), "parameter", &m.params);
    }
    for i in r.importers.iter().filter(|i| mine(i.plugin)) {
        say(format!("importer `{}`", i.id), "parameter", &i.params);
    }
    for s in r.services.iter().filter(|s| mine(s.plugin)) {
        say(format!("service `{}`", s.id), "parameter", &s.params);
    }
    for e in r.events.iter().filter(|e| e.plugin == Some(subject.plugin)) {
        say(format!("event `{}`", e.name), "field", &e.fields);
    }
}

/// Returns whether a field belongs to a standard schema, which describes it.
fn is_of_schema(name: &str) -> bool {
    tatu_core::plugins::schemas::all_schemas().iter().any(|s| s.fields.iter().any(|f| f.name == name))
}

/// Checks that commands have examples, and that their names have a namespace.
fn offers(subject: &TestedPlugin) {
    let mine = subject.registry.command_offers.commands.iter().filter(|c| c.plugin == subject.plugin);
    for c in mine {
        let place = super::inspector::place(c);
        let waits = c.no_wait.is_some();
        if c.example.trim().is_empty() && !waits && c.status != tatu_core::plugins::CommandStatus::Stub {
            warning(&place, "it has no example");
        }
        if !c.name().contains('.') && !c.name().starts_with("sim") {
            warning(&place, "its name has no namespace; choose one such as `mine.command`");
        }
    }
}
