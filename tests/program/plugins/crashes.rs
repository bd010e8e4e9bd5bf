//! Tests of a plugin that crashes or ends the program: an error names it, the exit status is right, and the output
//! before the crash is not lost. The plugin is `crashes/plugin.c`; environment variables select what it does, and in
//! which function.

#![cfg(all(target_os = "linux", target_env = "gnu"))]

use std::{
    io::{BufRead, BufReader},
    os::unix::process::ExitStatusExt,
    path::Path,
    process::{Command, Stdio},
    sync::OnceLock,
};

use tempfile::TempDir;

use crate::kit::*;

const ID: &str = "org.example.crashes";
/// Number of complete steps, of 0.05 s each, before the crash. The script calls the command at 0.15 s, in the fourth
/// step.
const STEPS_BEFORE_CRASH: usize = 3;

/// Signal numbers on Linux.
const SIGILL: i32 = 4;
const SIGABRT: i32 = 6;
const SIGBUS: i32 = 7;
const SIGFPE: i32 = 8;
const SIGSEGV: i32 = 11;

/// Builds the plugin with the crash code in a file; returns the folder.
fn built(harm: &str) -> TempDir {
    let sources = root().join("tests/program/plugins/crashes");
    let dir = TempDir::with_prefix("tatu-test-").unwrap();
    let object = dir.path().join("plugin.o");
    let include = format!("-I{}", root().join("plugin-api/include").display());
    let common = ["-O1", "-fPIC", "-pthread", include.as_str()];
    succeed(
        Command::new(compiler("cc"))
            .args(common)
            .args(["-std=gnu11", "-c", "-o"])
            .args([object.clone(), sources.join("plugin.c")]),
    );
    let linker = if harm.ends_with("cpp") { "c++" } else { "cc" };
    let file = dir.path().join(library("tatu_crashes"));
    succeed(Command::new(compiler(linker)).args(common).args(["-shared", "-o"]).args([
        file,
        object,
        sources.join(harm),
    ]));
    dir
}

/// Returns the plugin with crash code in C, built once.
fn in_c() -> &'static Path {
    static BUILD_FOLDER: OnceLock<TempDir> = OnceLock::new();
    BUILD_FOLDER.get_or_init(|| built("harm.c")).path()
}

/// Creates a scene that uses a command, two sensors that are measured together, and a service, each of which can be
/// made to crash.
fn scene() -> TestFolder {
    let script = "function sysCall_actuation()
        print('acts at', sim.getSimulationTime())
        if sim.getSimulationTime() > 0.12 then print('calls') crash.now() end
    end";
    let eye = |alias: &str| format!("[[object]]\nkind = \"sensor\"\nsensor = \"crash_sensor\"\nalias = \"{alias}\"\n");
    TestFolder::scene(&format!("{}{}{}", watcher("box1", script), eye("left"), eye("right")))
}

/// Runs the scene with the kind of crash `how` in the function `at`.
fn harmed(place: &TestFolder, plugins: &Path, at: &str, how: &str, args: &[&str]) -> RunOutput {
    let env = [("TATU_PLUGIN_PATH", plugins.to_str().unwrap()), ("CRASH_AT", at), ("CRASH_HOW", how)];
    let all = ["run", "scene.toml", "--steps", "10", "--trace", "trace.jsonl", "--service", "crash_service"];
    run(program(), place.path(), &[&all, args].concat(), &env)
}

/// Checks that exactly one line contains an error with this code, and returns it.
#[track_caller]
fn line(done: &RunOutput, code: &str) -> String {
    let start = format!("error[{code}]: ");
    let all: Vec<&str> = done.err.lines().filter(|l| l.starts_with(&start)).collect();
    assert_eq!(all.len(), 1, "{}\n{}", done.err, done.out);
    all[0].to_owned()
}

#[track_caller]
fn crashed(done: &RunOutput, signal: i32, words: &[&str]) {
    assert_eq!(done.signal, Some(signal), "exit {}\n{}", done.code, done.err);
    let line = line(done, "F211");
    words.iter().for_each(|w| assert!(line.contains(w), "`{w}` in: {line}"));
}

/// Checks that the trace and the output of the script and of C code are complete up to the step of the crash.
#[track_caller]
fn written(place: &TestFolder, done: &RunOutput) {
    assert_eq!(place.lines("trace.jsonl").len(), STEPS_BEFORE_CRASH);
    let said = done.out.lines().filter(|l| l.starts_with("acts at")).count();
    assert!(said >= STEPS_BEFORE_CRASH, "{}", done.out);
    assert!(done.out.contains("printed by C"), "{}", done.out);
}

#[test]
fn a_crash_in_a_command_is_blamed_by_every_signal() {
    let mut all = vec![
        ("null", SIGSEGV, "(SIGSEGV)"),
        ("bus", SIGBUS, "(SIGBUS)"),
        ("illegal", SIGILL, "(SIGILL)"),
        ("abort", SIGABRT, "(SIGABRT)"),
        ("deep", SIGSEGV, "(SIGSEGV, stack overflow)"),
    ];
    if cfg!(target_arch = "x86_64") {
        // Only on x86-64: on other processors a division by zero returns 0.
        all.push(("divide", SIGFPE, "(SIGFPE)"));
    }
    for (how, signal, name) in all {
        let place = scene();
        let done = harmed(&place, in_c(), "command", how, &[]);
        crashed(&done, signal, &[name, "`tatu_command.call`", "plugin `org.example.crashes`", "for /box1"]);
        written(&place, &done);
        assert!(done.out.contains("\ncalls\n"), "the output of the last step is lost:\n{}", done.out);
    }
}

#[test]
fn a_crash_in_a_measure_is_blamed_with_any_number_of_threads() {
    for threads in ["1", "2"] {
        for (how, name) in [("null", "(SIGSEGV)"), ("deep", "stack overflow")] {
            let place = scene();
            let done = harmed(&place, in_c(), "measure", how, &["--threads", threads]);
            crashed(&done, SIGSEGV, &[name, "`tatu_sensor.measure`", ID, "for /left, the first of a batch of 2"]);
            written(&place, &done);
        }
    }
}

#[test]
fn a_crash_in_a_barrier_names_the_service() {
    let place = scene();
    let done = harmed(&place, in_c(), "barrier", "null", &[]);
    crashed(&done, SIGSEGV, &["`tatu_service.barrier`", ID, "the service `crash_service`"]);
    written(&place, &done);
}

#[test]
fn a_crash_before_there_is_a_world_names_the_file() {
    let file = library("tatu_crashes");
    for how in ["null", "deep"] {
        let place = scene();
        crashed(&harmed(&place, in_c(), "init", how, &[]), SIGSEGV, &["`tatu_plugin.init`", ID, &file]);
        crashed(&harmed(&place, in_c(), "constructor", how, &[]), SIGSEGV, &["one of its constructors", &file]);
        // Other commands that load plugins report it too.
        let env = [("TATU_PLUGIN_PATH", in_c().to_str().unwrap()), ("CRASH_AT", "init"), ("CRASH_HOW", how)];
        for args in [&["list", "plugins"][..], &["check", "scene.toml"], &["describe", "joint"]] {
            crashed(&run(program(), place.path(), args, &env), SIGSEGV, &["`tatu_plugin.init`", ID]);
        }
    }
}

#[test]
fn a_plugin_that_crashes_or_exits_at_its_end_is_named() {
    let (place, file) = (scene(), library("tatu_crashes"));
    let env = |how| [("TATU_PLUGIN_PATH", in_c().to_str().unwrap()), ("CRASH_AT", "shutdown"), ("CRASH_HOW", how)];
    for args in [&["list", "plugins"][..], &["check", "scene.toml"], &["run", "scene.toml", "--steps", "1"]] {
        let words = ["`tatu_plugin.shutdown`", ID, &file];
        crashed(&run(program(), place.path(), args, &env("null")), SIGSEGV, &words);
        let done = run(program(), place.path(), args, &env("exit"));
        assert_eq!(done.code, if args[0] == "run" { 1 } else { 2 }, "{}", done.err);
        assert!(words.iter().all(|w| line(&done, "F212").contains(w)), "{}", done.err);
    }
}

#[test]
fn a_signal_from_outside_is_reported_as_such() {
    let place = TestFolder::scene("");
    let mut running = Command::new(program())
        .args(["run", "scene.toml", "--service", "jsonl:port=0,wait_for=1"])
        .current_dir(place.path())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(running.stderr.take().unwrap()).lines().map_while(Result::ok);
    assert!(lines.any(|l| l.contains("listening")));
    succeed(Command::new("kill").args(["-ABRT", &running.id().to_string()]));
    let told = lines.find(|l| l.contains("F211")).unwrap();
    assert!(told.contains("ended from outside") && told.contains("SIGABRT"), "{told}");
    assert_eq!(running.wait().unwrap().signal(), Some(SIGABRT));
}

#[test]
fn a_crash_on_a_thread_for_scripts_names_the_script_that_runs_there() {
    let script = "function sysCall_actuation() if sim.getSimulationTime() > 0.12 then crash.now() end end";
    let all: String = (0..40).map(|i| watcher(&format!("d{i}"), script)).collect();
    for threads in ["1", "2"] {
        let place = TestFolder::scene(&all);
        let done = harmed(&place, in_c(), "command", "deep", &["--threads", threads]);
        crashed(&done, SIGSEGV, &["stack overflow", "`tatu_command.call`", ID, "for /d"]);
        assert_eq!(place.lines("trace.jsonl").len(), STEPS_BEFORE_CRASH);
    }
}

#[test]
fn a_crash_on_a_thread_of_a_plugins_own_names_its_file() {
    let place = scene();
    let done = harmed(&place, in_c(), "command", "thread null", &[]);
    crashed(&done, SIGSEGV, &[&library("tatu_crashes"), "outside of any call"]);
    written(&place, &done);
}

#[test]
#[cfg_attr(no_cxx, ignore = "needs a C++ compiler")]
fn an_exception_that_leaves_a_plugin_is_its_fault() {
    let plugins = built("harm.cpp");
    let all = [
        ("command", "`tatu_command.call`"),
        ("measure", "`tatu_sensor.measure`"),
        ("barrier", "`tatu_service.barrier`"),
        ("init", "`tatu_plugin.init`"),
        ("constructor", "one of its constructors"),
    ];
    for (at, call) in all {
        let place = scene();
        let done = harmed(&place, plugins.path(), at, "throw", &[]);
        crashed(&done, SIGABRT, &[call, "crashes"]);
        if !["init", "constructor"].contains(&at) {
            assert_eq!(place.lines("trace.jsonl").len(), STEPS_BEFORE_CRASH, "{at}");
        }
    }
}

#[test]
fn a_plugin_that_calls_exit_is_at_fault() {
    let all = [
        ("command", "exit", 1, "`tatu_command.call` (`crash.now`) of plugin `org.example.crashes` for /box1"),
        ("measure", "exit", 1, "`tatu_sensor.measure` of plugin `org.example.crashes` for /left"),
        ("barrier", "exit", 1, "the service `crash_service`"),
        ("command", "thread exit", 1, "in the thread"),
        ("init", "exit", 2, "`tatu_plugin.init` of plugin `org.example.crashes`"),
        ("constructor", "exit", 2, "libtatu_crashes"),
    ];
    for (at, how, code, words) in all {
        let place = scene();
        let done = harmed(&place, in_c(), at, how, &[]);
        assert_eq!(done.code, code, "{at}: {}", done.err);
        let line = line(&done, "F212");
        assert!(line.contains(words), "`{words}` in: {line}");
        if code == 1 {
            written(&place, &done);
        }
    }
}

#[test]
fn the_summary_contains_a_crash() {
    let place = scene();
    let done = harmed(&place, in_c(), "command", "null", &["--json"]);
    assert_eq!(done.signal, Some(SIGSEGV));
    let json = &done.out[done.out.find('{').unwrap()..=done.out.rfind('}').unwrap()];
    let told: serde_json::Value = serde_json::from_str(json).unwrap();
    let error = &told["errors"][0];
    assert_eq!(
        (&told["steps"], error["code"].as_str(), error["kind"].as_str()),
        (&STEPS_BEFORE_CRASH.into(), Some("F211"), Some("crash"))
    );
    assert_eq!((error["plugin"].as_str(), error["object"].as_str()), (Some(ID), Some("/box1")));
}

#[test]
fn the_log_of_a_run_that_crashed_can_be_replayed() {
    let place = scene();
    let done = harmed(&place, in_c(), "command", "null", &["--log", "log"]);
    assert_eq!(done.signal, Some(SIGSEGV));
    let env = [("TATU_PLUGIN_PATH", in_c().to_str().unwrap())];
    let again =
        run(program(), place.path(), &["run", "--replay", "log", "--steps", "5", "--trace", "again"], &env).good();
    again.reports(&["did not end normally"]);
    let (before, after) = (place.lines("trace.jsonl"), place.lines("again"));
    assert!(before.iter().zip(&after).all(|(a, b)| a.hash() == b.hash()));
}

#[test]
fn a_child_that_a_plugin_forks_dies_by_itself() {
    let place = scene();
    let done = harmed(&place, in_c(), "command", "fork", &[]).good();
    assert!(!done.err.contains("error"), "{}", done.err);
}

#[test]
fn a_library_with_an_undefined_symbol_is_refused() {
    let (place, plugins) = (TestFolder::new(), built("undefined.c"));
    let env = [("TATU_PLUGIN_PATH", plugins.path().to_str().unwrap())];
    let done = run(program(), place.path(), &["list", "plugins"], &env).good();
    done.reports(&["E301", &library("tatu_crashes"), "`nobody_has_this`", "link it"]);
    assert!(!done.out.contains(ID), "{}", done.out);
}

#[test]
fn every_command_that_loads_plugins_is_watched() {
    let place = scene();
    let env = [("TATU_PLUGIN_PATH", in_c().to_str().unwrap()), ("CRASH_AT", "init"), ("CRASH_HOW", "hang")];
    let all = [
        &["list", "plugins"][..],
        &["check", "scene.toml"],
        &["describe", "joint"],
        &["convert", "scene.toml", "out.toml"],
        &["look", "scene.toml", "--sensor", "left", "-o", "out.png"],
    ];
    for args in all {
        let done = run(program(), place.path(), &[args, &["--watchdog", "0.4"]].concat(), &env);
        done.refused(&["F210", "`org.example.crashes", "tatu_plugin.init"]);
    }
}

#[test]
fn a_service_that_blocks_the_run_is_named() {
    let place = TestFolder::scene("");
    let mut running = Command::new(program())
        .args(["run", "scene.toml", "--strict", "--service", "jsonl:port=0,wait_for=1"])
        .current_dir(place.path())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // No client connects. The test waits until the program reports this.
    let told =
        BufReader::new(running.stderr.take().unwrap()).lines().map_while(Result::ok).find(|l| l.contains("held"));
    running.kill().unwrap();
    running.wait().unwrap();
    let told = told.unwrap();
    assert!(told.contains("the service `jsonl` (plugin `tatu.service.jsonl`) has held the run"), "{told}");
    assert!(!told.contains("warning"), "a held run must not cause a warning, because of `--strict`: {told}");
}
