//! Subcommands of the program that plugins offer: `tatu NAME ...` calls the command `subcommand.NAME`, whose parameters
//! are the arguments of the command line.

use std::{ffi::OsString, process::ExitCode};

use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use serde_json::Value as Json;
use tatu_core::{
    World,
    document::{self, SourceFiles},
    errors::Error,
    plugins::{CommandEntry, ParameterSpec, Registry, units},
};
use tatu_plugin_api::{
    abi::{TATU_BYTES, TATU_PARAM_REST, TATU_TEXT},
    safe::Value,
};
use tatu_terminal::{Watchdog, report};

use super::describe::facts::to_json;
use crate::args::{CliArgs, ExternalArgs};

/// What precedes the name of a subcommand in the name of its command.
const COMMANDS: &str = "subcommand.";
/// The result that is the exit code instead of being printed.
const EXIT_CODE: &str = "exit_code";

/// Seconds of real time after which a command that has not returned ends the program.
const WATCHDOG_S: f64 = 60.0;

/// Runs a subcommand of a plugin; `words` are its name and its arguments. The exit code is that which the command
/// returns, or 0; 2 if it failed.
pub fn subcommand(words: &[OsString]) -> ExitCode {
    match called(words) {
        Ok(code) => code,
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

fn called(words: &[OsString]) -> Result<ExitCode, Error> {
    let name = words.first().map(|w| w.to_string_lossy().into_owned()).unwrap_or_default();
    // The plugins must be known before the arguments can be parsed, and the scene's own may offer the command.
    let early = early_arguments(&words[1..]);
    let watchdog = Watchdog::start(WATCHDOG_S, false);
    let file = early.scene.as_deref().filter(|file| file.exists());
    let registry = super::registry(file, &SourceFiles::default(), &early.changes, &watchdog)?;
    let full = format!("{COMMANDS}{name}");
    let Some((id, _)) = registry.command(&full) else { return Err(unknown(&name, &registry)) };
    let entry = &registry.command_offers.commands[id as usize - 1];
    let line = command_line(&name, entry)?;
    let matches = line.get_matches_from(words);
    let given = ExternalArgs::from_arg_matches(&matches).unwrap_or(early);
    let arguments = arguments(entry, &matches)?;
    let exit = entry.returns.iter().position(|result| result.key == EXIT_CODE);
    let options = given.changes.options(&[])?;
    let document = match &given.scene {
        Some(scene) => super::load(scene, &options, &registry)?,
        None => document::Document::default().into(),
    };
    let world = World::new(document, registry)?;
    watchdog.world(&world, false);
    let results = world.call(&full, &arguments).map_err(|fault| {
        let error = Error::new("E128", format!("`tatu {name}` failed: {}", fault.message));
        fault.help.iter().fold(error, |error, help| error.help(help.clone()))
    })?;
    for (_, result) in results.iter().enumerate().filter(|(i, _)| Some(*i) != exit) {
        match result {
            Value::Text(bytes) | Value::Bytes(bytes) => report::out!("{}", String::from_utf8_lossy(bytes).trim_end()),
            Value::Nil => {}
            other => report::out!("{}", to_json(other)),
        }
    }
    let code =
        exit.and_then(|i| results.get(i)).and_then(|code| if let Value::Int(i) = code { Some(*i) } else { None });
    Ok(code.map_or(ExitCode::SUCCESS, |code| ExitCode::from(u8::try_from(code).unwrap_or(1))))
}

/// Returns the options of the program among the arguments, before those of the subcommand are known.
fn early_arguments(words: &[OsString]) -> ExternalArgs {
    let program = ExternalArgs::augment_args(Command::new("tatu").no_binary_name(true).disable_help_flag(true));
    let is_option = |word: &OsString| word.to_str().is_some_and(|w| w.starts_with("--"));
    let known = |word: &OsString| {
        let text = word.to_string_lossy();
        let long = text.trim_start_matches("--").split('=').next().unwrap_or_default().to_owned();
        program.get_arguments().any(|arg| arg.get_long() == Some(&long))
    };
    let mut own = Vec::new();
    for (i, word) in words.iter().enumerate().filter(|(_, word)| is_option(word) && known(word)) {
        own.push(word.clone());
        own.extend(words.get(i + 1).filter(|next| !is_option(next) && !word.to_string_lossy().contains('=')).cloned());
    }
    let parsed = program.clone().try_get_matches_from(own).and_then(|matches| ExternalArgs::from_arg_matches(&matches));
    parsed.unwrap_or_default()
}

/// Returns the command line that the parameters of a command describe: those that are required are positional.
fn command_line(name: &str, entry: &CommandEntry) -> Result<Command, Error> {
    let program = Command::new("tatu").bin_name(format!("tatu {name}")).next_help_heading("Scene");
    let mut line = ExternalArgs::augment_args(program).about(entry.text.clone());
    for parameter in &entry.params {
        let long = units::key_with_unit(&parameter.key, parameter.unit.as_deref());
        let is_taken = line.get_arguments().any(|a| a.get_long() == Some(&long) || *a.get_id() == *id(parameter));
        if is_taken || matches!(long.as_str(), "" | "help") {
            let text = format!("the parameter `{long}` of `{COMMANDS}{name}` has the name of another option, or none");
            return Err(Error::new("E128", text).help("give the parameter another name"));
        }
        let expected = match &parameter.fallback {
            Value::Nil => parameter.expectation(),
            default => format!("{}; default: {}", parameter.expectation(), to_json(default)),
        };
        let arg = Arg::new(id(parameter))
            .help(format!("{} ({expected})", parameter.text.trim_end_matches('.')))
            .help_heading("Arguments")
            .allow_negative_numbers(true)
            .value_name(long.to_uppercase());
        line = line.arg(if is_rest(entry, parameter) {
            arg.num_args(0..).action(ArgAction::Append)
        } else if parameter.optional() {
            arg.long(long).allow_hyphen_values(true)
        } else {
            arg.required(true)
        });
    }
    Ok(line)
}

/// Returns the name by which a parameter is known among the arguments, which no option of the program has.
fn id(parameter: &ParameterSpec) -> String {
    format!("parameter {}", parameter.key)
}

/// Returns whether a parameter takes all further arguments. Only the last one can.
fn is_rest(entry: &CommandEntry, parameter: &ParameterSpec) -> bool {
    let is_last = entry.params.last().is_some_and(|last| std::ptr::eq(last, parameter));
    is_last && parameter.flags & TATU_PARAM_REST != 0
}

/// Returns the arguments of the command. A text is taken as it is, any other value is JSON in the unit of the option.
fn arguments(entry: &CommandEntry, matches: &ArgMatches) -> Result<Vec<Value>, Error> {
    let mut arguments = Vec::new();
    for parameter in &entry.params {
        let given = matches.get_many::<String>(&id(parameter)).into_iter().flatten();
        let values = given.map(|text| value(parameter, text)).collect::<Result<Vec<_>, _>>()?;
        if values.is_empty() && !is_rest(entry, parameter) {
            arguments.push(Value::Nil);
        }
        arguments.extend(values);
    }
    Ok(arguments)
}

fn value(parameter: &ParameterSpec, text: &str) -> Result<Value, Error> {
    if matches!(parameter.kind, TATU_TEXT | TATU_BYTES) {
        return Ok(Value::from(text));
    }
    let unit = parameter.unit.as_deref();
    let key = units::key_with_unit(&parameter.key, unit);
    let factor = units::factor(&key, &parameter.key, unit).unwrap_or(1.0);
    let json = serde_json::from_str(text).unwrap_or_else(|_| Json::from(text));
    from_json(&json, factor).ok_or_else(|| {
        let error = Error::new("E128", format!("`{key}`: `{text}` is no value"));
        error.expected(parameter.expectation())
    })
}

/// Converts a value of JSON. Numbers with a fraction, or with another unit than SI, are multiplied by `factor`.
fn from_json(json: &Json, factor: f64) -> Option<Value> {
    Some(match json {
        Json::Null => Value::Nil,
        Json::Bool(truth) => Value::Bool(*truth),
        Json::Number(number) if factor == 1.0 && number.is_i64() => Value::Int(number.as_i64()?),
        Json::Number(number) => Value::Float(number.as_f64()? * factor),
        Json::String(text) => Value::from(text.as_str()),
        Json::Array(list) => Value::List(list.iter().map(|item| from_json(item, factor)).collect::<Option<_>>()?),
        Json::Object(map) => {
            let entry = |(key, item): (&String, &Json)| Some((Value::from(key.as_str()), from_json(item, 1.0)?));
            Value::Map(map.iter().map(entry).collect::<Option<_>>()?)
        }
    })
}

/// Returns the error for a name that is no subcommand.
fn unknown(name: &str, registry: &Registry) -> Error {
    let line = <CliArgs as clap::CommandFactory>::command();
    let own: Vec<String> =
        line.get_subcommands().filter(|c| !c.is_hide_set()).map(|c| c.get_name().to_owned()).collect();
    let names = registry.command_offers.commands.iter().flat_map(|command| &command.names);
    let mut offered: Vec<&str> = names.filter_map(|n| n.name.strip_prefix(COMMANDS)).collect();
    offered.sort_unstable();
    let plugins = if offered.is_empty() { String::new() } else { format!("; of plugins: {}", offered.join(", ")) };
    let known = own.iter().map(String::as_str).chain(offered.iter().copied());
    Error::new("E128", format!("there is no subcommand `{name}`"))
        .expected(format!("one of {}{plugins}", own.join(", ")))
        .nearest(name, known)
}
