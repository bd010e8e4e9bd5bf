//! Tests of commands: their examples, valid and invalid arguments, and independence of worlds.

use std::{fmt::Write, path::Path, sync::PoisonError};

use tatu_core::{World, errors::Error, plugins::CommandEntry};

use super::{
    finding::{self, error},
    scripts::{LUA_HELPERS, calls, ordinary_script, quoted},
    stage,
    subject::TestedPlugin,
};

/// Number of steps of a run.
pub const RUN_STEPS: usize = 4;
/// Number of steps in which an example may wait.
const EXAMPLE_STEPS: usize = 6;
/// Prefix of the lines that the script reports; all other lines are ignored.
const LINE_PREFIX: &str = "@check ";

/// Runs the test `examples`.
pub fn examples(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    for c in subject.own_commands().filter(|c| !c.example.trim().is_empty()) {
        let place = super::inspector::place(c);
        finding::report_activity(&place, "when its example runs");
        // As a thread, an example may wait.
        let example = quoted(c.example.as_bytes());
        let script = format!(
            "{LUA_HELPERS}\nfunction sysCall_thread() report(load({example}, 'example', 't', objects())) end\n"
        );
        let said = run(&subject, &script, EXAMPLE_STEPS)?;
        if let Some(said) = said.first().filter(|l| l.starts_with("compile: ")) {
            error(&place, format!("its example does not compile: {}", said.trim_start_matches("compile: ")));
        } else if let Some(said) = said.first().filter(|l| l.starts_with("raise: ")) {
            let why = said.trim_start_matches("raise: ");
            let help =
                "an example creates the objects that it needs, or uses the variables `body`, `joint` and `sensor`";
            error(&place, format!("its example raises an error: {why} ({help})"));
        }
    }
    Ok(())
}

/// Runs the test `arguments`.
pub fn arguments(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    let all: Vec<&CommandEntry> = subject.own_commands().collect();
    for c in all {
        let mut script = format!("{LUA_HELPERS}\n");
        for call in calls(c) {
            let _ = writeln!(script, "{call}");
        }
        run(&subject, &script, RUN_STEPS)?;
    }
    Ok(())
}

/// Runs the test `worlds`: the calls in one world must not affect a second world in the same process.
pub fn worlds(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    if subject.own_commands().next().is_none() {
        return Ok(());
    }
    let script = ordinary_script(&subject);
    let first = run(&subject, &script, RUN_STEPS)?;
    let second = run(&subject, &script, RUN_STEPS)?;
    let dangling = subject.spy.dangling.lock().unwrap_or_else(PoisonError::into_inner);
    let pairs = [&first, &second].map(|lines| {
        let mut pairs = with_places(lines);
        // What is left on the stack differs from one call to the next; that is reported already.
        pairs.retain(|(place, _)| !dangling.contains(place));
        pairs
    });
    compare(
        &pairs[0],
        &pairs[1],
        "calls in one world change the results in another: check for a global or static variable",
    );
    Ok(())
}

/// Returns the reported lines, each without the name of the command, with the place of that command.
pub fn with_places(lines: &[String]) -> Vec<(String, String)> {
    let pair = |line: &String| {
        let (name, text) = line.split_once(' ').unwrap_or(("", line));
        (format!("command `{name}`"), text.to_owned())
    };
    lines.iter().map(pair).collect()
}

/// Reports the first line in which two transcripts differ.
pub fn compare(first: &[(String, String)], second: &[(String, String)], what: &str) {
    let mut pairs = first.iter().zip(second);
    if let Some(((place, a), (_, b))) = pairs.find(|(a, b)| a != b) {
        return error(place, format!("{what}: {a}, then {b}"));
    }
    if first.len() != second.len() {
        let [a, b] = [first, second].map(<[_]>::len);
        error("", format!("{what}: {a} calls return in the first run, and {b} in the second"));
    }
}

/// Runs a script in a new world; returns the lines that it reported.
pub fn run(subject: &TestedPlugin, script: &str, steps: usize) -> Result<Vec<String>, Error> {
    let scene = stage::scene("", script);
    let world = subject.world(&scene, &[("check.lua", script.as_bytes())], 1)?;
    let mut lines = play(&world, steps);
    lines.iter_mut().for_each(|l| *l = subject.without_folders(l));
    subject.report_faults(&world);
    world.end();
    subject.report_faults(&world);
    Ok(lines)
}

/// Starts a world and runs steps; returns the lines that its script reported.
pub fn play(world: &World, steps: usize) -> Vec<String> {
    world.start();
    let mut lines = Vec::new();
    for _ in 0..steps {
        let goes_on = world.step();
        lines.extend(reported(world));
        if !goes_on {
            break;
        }
    }
    lines
}

/// Returns the lines that the script reported since the last call.
pub fn reported(world: &World) -> Vec<String> {
    let lines = world.take_lines().into_iter();
    lines.filter_map(|l| l.text.split_once(LINE_PREFIX).map(|(_, text)| text.to_owned())).collect()
}
