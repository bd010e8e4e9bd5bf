//! Tests that an error names a plugin that breaks the contract immediately after the call, and that the run continues
//! where possible. The plugin is `breaches/plugin.c`.

#![cfg(all(target_os = "linux", target_env = "gnu"))]

use std::{fs, path::Path, process::Command, sync::OnceLock};

use tempfile::TempDir;

use crate::kit::*;

const ID: &str = "org.example.breaches";

fn plugin() -> &'static Path {
    static BUILD_FOLDER: OnceLock<TempDir> = OnceLock::new();
    let build = || {
        let dir = TempDir::with_prefix("tatu-test-").unwrap();
        let to = dir.path().join(library("tatu_breaches"));
        compile(&root().join("tests/program/plugins/breaches/plugin.c"), &to);
        dir
    };
    BUILD_FOLDER.get_or_init(build).path()
}

fn compile(source: &Path, to: &Path) {
    let include = format!("-I{}", root().join("plugin-api/include").display());
    // Warnings are off because compilers detect some of the intentional faults.
    let args = ["-std=gnu11", "-O1", "-w", "-shared", "-fPIC", "-pthread", &include, "-o"];
    succeed(Command::new(compiler("cc")).args(args).arg(to).arg(source).arg("-lm"));
}

fn ran(place: &TestFolder, env: &[(&str, &str)], args: &[&str]) -> RunOutput {
    let env = [&[("TATU_PLUGIN_PATH", plugin().to_str().unwrap())], env].concat();
    let mut all = vec!["run", "scene.toml", "--no-addons", "--json"];
    if !args.contains(&"--steps") {
        all.extend(["--steps", "4"]);
    }
    all.extend(args);
    run(program(), place.path(), &all, &env)
}

/// Returns a script that calls the command once, prints the result, and continues.
fn calls(how: &str) -> TestFolder {
    let script = format!(
        "function sysCall_actuation()
            if called then return end
            called = true
            print('told', pcall(breach.now, '{how}', {{1.5, 2.5}}))
        end
        function sysCall_cleanup() print('goes on to the end') end"
    );
    TestFolder::scene(&watcher("box", &script))
}

#[test]
fn a_command_with_forbidden_writes_or_results_is_blamed() {
    for (how, words) in [
        ("one result too many", "wrote outside its space for 64 results"),
        ("results twice", "wrote outside its space for 64 results"),
        ("before the results", "wrote outside its space for 64 results"),
        ("past alloc", "wrote past the end of memory that the host gave it"),
        ("past an argument", "wrote past the end of an argument"),
        ("before the state", "state block"),
        ("past the state", "state block"),
        ("huge span", "result 1 has 1152921504606846976 elements"),
        ("large span", "result 1 has 2147483648 elements"),
        ("list in itself", "is nested deeper than 32 levels"),
        ("key that is no number", "a map with the key NaN"),
        ("null list", "a list or map of 3 elements at a null pointer"),
        ("unaligned", "not aligned"),
    ] {
        for threads in ["1", "2"] {
            let done = ran(&calls(how), &[], &["--threads", threads]).good();
            let line = done.err.lines().find(|l| l.starts_with("told")).unwrap();
            for word in [words, "breach.now", ID, "broke the contract", "false"] {
                assert!(line.contains(word), "{how}: `{word}` in: {line}");
            }
            done.reports(&["goes on to the end"]);
        }
    }
}

#[test]
fn an_actuator_that_writes_what_it_must_not_is_switched_off() {
    let scene = "[[object]]\nkind = \"shape\"\nalias = \"box\"\ndynamic = true\n[[object]]\nkind = \"actuator\"\nactuator = \"breach\"\nalias = \"a\"\nparent = \"box\"\n";
    for (how, words) in [
        ("one force too many", "outside `wrench`"),
        ("64 forces too many", "outside `wrench`"),
        ("before the forces", "outside `wrench`"),
        ("effort", "outside `effort`"),
        ("command", "`command` of its batch, which is read-only"),
        ("past the command", "`command` of its batch, which is read-only"),
        ("status", "the status 9, which is not defined for this call"),
        ("past the status", "outside `status`"),
        ("before the state", "state block"),
        ("past the state", "state block"),
    ] {
        for threads in ["1", "2"] {
            let done = ran(&TestFolder::scene(scene), &[("BREACH_OF_ACTUATOR", how)], &["--threads", threads]);
            let errors = done.errors();
            let message = errors[0]["message"].as_str().unwrap();
            assert!(errors.len() == 1 && message.contains(words) && message.contains(ID), "{how}: {errors:?}");
            assert_eq!(errors[0]["object"], "/box/a");
        }
    }
}

#[test]
fn a_sensor_that_writes_what_it_must_not_is_switched_off() {
    let scene = "[[object]]\nkind = \"sensor\"\nsensor = \"breach_sensor\"\nalias = \"eye\"\n";
    for (how, words) in [
        ("past the status", "outside the statuses"),
        ("before the field", "before the beginning of the field `breach.x`"),
        ("past the field", "past the end of the field `breach.x`"),
    ] {
        let done = ran(&TestFolder::scene(scene), &[("BREACH_OF_SENSOR", how)], &[]);
        let errors = done.errors();
        let message = errors[0]["message"].as_str().unwrap();
        assert!(errors.len() == 1 && message.contains(words) && message.contains(ID), "{how}: {errors:?}");
    }
    let done = ran(&TestFolder::scene(scene), &[("BREACH_OF_BEAMS", "1")], &[]);
    done.refused(&["wrote outside the table `tatu_beams`", "/eye"]);
}

#[test]
fn process_state_changed_by_a_plugin_is_restored_and_reported() {
    let mut all = vec![
        ("folder", "changed the working folder of the process"),
        ("signal", "changed the action of SIGUSR1"),
        ("output", "changed standard output (closed or exchanged)"),
        ("thread", "`scene.pose` was called for a world that does not exist, or from a thread that is not the world's"),
    ];
    if cfg!(target_arch = "x86_64") {
        all.push(("direction", "changed the direction flag of the processor in tatu_command.call"));
    }
    for (how, words) in all {
        let done = ran(&calls(how), &[], &[]);
        assert_eq!(done.code, 1, "{how}: {}", done.err);
        let library = library("tatu_breaches");
        let line =
            done.err.lines().find(|l| l.starts_with("error[F207]")).unwrap_or_else(|| panic!("{how}: {}", done.err));
        assert!(line.contains(words) && (line.contains(ID) || line.contains(&library)), "{how}: {line}");
        done.reports(&["goes on to the end"]);
    }
}

/// After the host has restored a signal action, the system reports it with an additional flag. The host must not take
/// this for a second change.
#[test]
fn a_restored_signal_action_is_reported_once() {
    let done = ran(&calls("signal of children"), &[], &["--steps", "400"]);
    let errors = done.errors();
    assert!(errors.len() == 1 && errors[0]["count"] == 1, "{errors:?}");
    assert!(errors[0]["message"].as_str().unwrap().contains("changed the action of SIGCHLD"), "{errors:?}");
}

#[test]
fn files_lie_where_they_lay_after_a_changed_folder() {
    let script = "function sysCall_init()
        breach.now('folder')
        local f = io.open('made.txt', 'w') f:write('here') f:close()
    end";
    let place = TestFolder::scene(&watcher("box", script));
    ran(&place, &[], &[]);
    assert_eq!(place.read("made.txt"), "here");
}

#[test]
fn silent_process_ends_are_reported() {
    let done = ran(&calls("timer"), &[], &[]);
    assert_eq!(done.signal, Some(14), "{}", done.err);
    done.reports(&["F211", "SIGALRM", "`breach.now`", ID]);
    let done = ran(&calls("fork"), &[], &[]).good();
    done.reports(&["the process was forked in `tatu_command.call` (`breach.now`)", ID]);
    assert_eq!(done.err.matches("goes on to the end").count(), 1, "a forked copy has continued: {}", done.err);
    let done = ran(&calls("end"), &[], &[]);
    assert_eq!(done.code, 1);
    done.reports(&["F210", "atexit", "goes on to the end"]);
}

#[test]
fn lines_of_the_log_do_not_act_on_a_terminal() {
    let done = ran(&calls("log"), &[], &[]).good();
    assert!(!done.err.contains('\u{1b}') && !done.out.contains('\u{1b}'), "{}", done.err);
    done.reports(&["x\\u{1b}[2J"]);
}

#[test]
fn a_mesh_without_points_fails_the_build() {
    let done = ran(&TestFolder::scene("[[model]]\nmodel = \"breach_model\"\n"), &[], &[]);
    done.refused(&["E111", "breach_model", "3 points", "null"]);
}

#[test]
fn a_plugin_without_extensions_gets_a_hint_on_the_misspelt_id() {
    let place = TestFolder::scene("");
    let text = fs::read_to_string(root().join("tests/program/plugins/breaches/plugin.c")).unwrap();
    let text = text
        .replace("strcmp(id, TATU_COMMAND)", "strcmp(id, \"tatu.comand/draft.4\")")
        .replace("if (!strcmp(id, TATU_ACTUATOR)) return &actuators;", "")
        .replace("if (!strcmp(id, TATU_SENSOR)) return &sensors;", "")
        .replace("return strcmp(id, TATU_MODEL) ? NULL : &models;", "return NULL;");
    place.write("mine/plugin.c", &text);
    compile(&place.path().join("mine/plugin.c"), &place.path().join("mine").join(library("tatu_breaches")));
    let env = [("TATU_PLUGIN_PATH", "mine")];
    let done = run(program(), place.path(), &["run", "scene.toml", "--steps", "1"], &env).good();
    done.reports(&["E324", "offers nothing", "`tatu.comand/draft.4`", "did you mean `tatu.command/draft.4`"]);
}
