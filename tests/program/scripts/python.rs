//! Tests of scripts in Python: permission, callbacks, values, threads, errors, seeds, saved state.

use crate::kit::*;

/// Returns a dummy with an inline script in Python.
fn dummy(alias: &str, script: &str) -> String {
    format!("[[object]]\nkind = \"dummy\"\nalias = \"{alias}\"\nscript = {{ text = '''#python\n{script}\n''' }}\n")
}

/// Runs a scene with the permission, and returns what it printed.
fn output_of(place: &TestFolder, steps: u32) -> String {
    let done = place.tatu(&["run", "scene.toml", "--steps", &steps.to_string(), "--allow", "python"]);
    done.out + &done.err
}

/// Runs a scene with the permission, without errors, and returns what it printed.
fn printed(scene: &str, steps: u32) -> String {
    let said = output_of(&TestFolder::scene(scene), steps);
    assert!(!said.contains("error["), "{said}");
    said
}

#[test]
fn a_script_is_not_run_without_permission_and_one_sentence_says_so() {
    let scene = dummy("a", "import os\nos.mkdir('made')") + &dummy("b", "import os\nos.mkdir('made')");
    let place = TestFolder::scene(&scene);
    let done = place.tatu(&["run", "scene.toml", "--steps", "2"]).good();
    done.reports(&["2 scripts in the language `python` do not run", "`--allow python`"]);
    assert_eq!(done.err.matches("--allow python").count(), 1, "{}", done.err);
    assert!(!place.path().join("made").exists());
    place.tatu(&["run", "scene.toml", "--steps", "2", "--allow", "pyton"]).refused(&["E101", "did you mean `python`?"]);
    place.write("scene.toml", &format!("format = 1\n[permissions]\npython = true\n{scene}"));
    let asked = place.tatu(&["check", "scene.toml"]);
    assert!((asked.out + &asked.err).contains("`--allow python`"));
}

#[test]
fn callbacks_are_called_in_the_same_order_as_those_of_lua() {
    let python = "
def sysCall_init():
    sim = require('sim')
    say('init')
def say(what):
    sim.setStringSignal('order', (sim.getStringSignal('order') or '') + what + ' ')
def sysCall_actuation(): say('actuation')
def sysCall_sensing(): say('sensing')
def sysCall_thread():
    say('thread')
    sim.step()
    say('thread')
def sysCall_cleanup():
    say('cleanup')
    print(sim.getStringSignal('order'))";
    let lua = "
sim = require 'sim'
function sysCall_init() say('init') end
function say(what) sim.setStringSignal('order', (sim.getStringSignal('order') or '')..what..' ') end
function sysCall_actuation() say('actuation') end
function sysCall_sensing() say('sensing') end
function sysCall_thread() say('thread') sim.step() say('thread') end
function sysCall_cleanup() say('cleanup') print(sim.getStringSignal('order')) end";
    let order = |text: &str| text.lines().find(|l| l.contains("init")).map(str::to_owned);
    let found = order(&printed(&dummy("a", python), 4));
    assert!(
        found.as_ref().is_some_and(|l| l.starts_with("init thread actuation sensing thread actuation")),
        "{found:?}"
    );
    assert_eq!(found, order(&printed(&watcher("a", lua), 4)));
}

#[test]
fn values_pass_both_ways_and_others_are_refused_with_their_place() {
    let lua = watcher("lua", "function echo(...) return ... end function twice(f, x) return f(f(x)) end");
    let python = "
import array
def sysCall_init():
    sim = require('sim')
def sysCall_sensing():
    other = sim.getScript(sim.scripttype_simulation, sim.getObject('/lua'))
    echo = lambda *a: sim.callScriptFunction('echo', other, *a)
    same = [None, True, -2 ** 63, 2.0, 'ção', [1, 2], [1.0, 2.5], [1, 'a', [2]], {'a': 1, 'b': [1]}, [], b'\\xff\\x00']
    for value in same:
        assert repr(echo(value)) == repr(value), (value, echo(value))
    assert echo((1, 2)) == [1, 2] and echo(array.array('d', [1, 2])) == [1.0, 2.0] and echo(range(2)) == [0, 1]
    assert echo(1, None, 'x') == (1, None, 'x') and echo() is None
    assert sim.callScriptFunction('twice', other, lambda x: x * 3, 5) == 45
    assert type(sim.packInt32Table([65, 66])) is bytes and len(sim.packInt32Table([65, 66])) == 8
    loop = []
    loop.append(loop)
    for bad, words in [(2 ** 63, '64 bits'), ({1}, 'type set'), ({(1, 2): 3}, 'the key (1, 2)'), (loop, 'contains itself')]:
        try:
            echo(bad)
            raise AssertionError(bad)
        except TypeError as error:
            assert words in str(error), error
    print('all values pass')";
    assert!(printed(&(lua + &dummy("a", python)), 2).contains("all values pass"));
}

#[test]
fn threads_wait_in_simulation_time_while_other_callbacks_run() {
    let script = "
import time
def sysCall_init():
    sim = require('sim')
    self.calls = 0
def sysCall_actuation():
    self.calls += 1
def sysCall_thread():
    sim.setStepping(True)
    sim.wait(0.2)
    assert abs(sim.getSimulationTime() - 0.2) < 1e-9 and self.calls == 4, (sim.getSimulationTime(), self.calls)
    time.sleep(0.1)
    assert abs(time.time() - 0.3) < 1e-9 and self.calls == 6, (time.time(), self.calls)
    sim.setStepping(False)
    while self.calls < 8:
        sim.getSimulationTime()
    print('the thread ended at', round(sim.getSimulationTime(), 2))";
    assert!(printed(&dummy("a", script), 12).contains("the thread ended at 0.4"));
}

#[test]
fn errors_name_file_and_line_and_the_text_of_unknown_commands() {
    for (script, words) in [
        ("def sysCall_init(:", &["SyntaxError", "a:2"][..]),
        ("def sysCall_init():\n    f()\ndef f():\n    return {}['x']", &["a:5: KeyError: 'x'"]),
        ("def sysCall_init():\n    sim.getObjct('/a')", &["a:3", "did you mean `sim.getObject`?"]),
        ("def sysCall_init():\n    sim.getObject('/nowhere')", &["a:3", "there is no object `/nowhere`"]),
        ("import no_such_module", &["a:2", "No module named 'no_such_module'"]),
        ("def sysCall_thread():\n    sim.step()\n    1 / 0", &["a:4: ZeroDivisionError"]),
        ("include no_such_file", &["include file 'no_such_file' not found"]),
    ] {
        let place = TestFolder::scene(&dummy("a", script));
        let said = output_of(&place, 3);
        for word in words {
            assert!(said.contains(word), "{script}: {said}");
        }
    }
}

#[test]
fn random_numbers_and_sets_are_the_same_in_two_runs_with_the_same_seed() {
    let script = "
import random
def sysCall_sensing():
    words = {'a%d' % i for i in range(20)}
    print('drawn', random.random(), random.Random().random(), list(words)[:5])";
    let drawn = |seed: &str| {
        let place = TestFolder::scene(&dummy("a", script));
        let done = place.tatu(&["run", "scene.toml", "--steps", "2", "--allow", "python", "--seed", seed]).good();
        (done.out + &done.err).lines().filter(|l| l.contains("drawn")).map(str::to_owned).collect::<Vec<_>>()
    };
    let first = drawn("1");
    assert!(first.len() > 1, "{first:?}");
    assert_eq!(first, drawn("1"));
    assert_ne!(first, drawn("2"));
}

#[test]
fn an_included_file_replaces_the_text_and_finds_modules_beside_it() {
    let place = TestFolder::scene("[[object]]\nkind = \"dummy\"\nalias = \"a\"\nscript = \"robot.py\"\n");
    std::fs::create_dir(place.path().join("lib")).unwrap();
    place.write("robot.py", "#python\n#luaExec additionalIncludePaths = {'lib'}\ninclude controller\n");
    place.write("controller.py", "import helper\ndef sysCall_sensing():\n    print(helper.NAME, __file__)\n");
    place.write("helper.py", "NAME = 'found'\n");
    let said = output_of(&place, 1);
    assert!(said.contains("found") && said.contains("controller.py"), "{said}");
}

#[test]
fn state_that_a_script_saves_is_restored_from_a_snapshot() {
    let scene = dummy(
        "a",
        "
def sysCall_init():
    global count
    count = 0
def sysCall_actuation():
    global count
    count += 1
    print('count', count)
def sysCall_savestate():
    return {'count': count}
def sysCall_loadstate(state):
    global count
    count = state['count']",
    );
    let place = TestFolder::scene(&scene);
    place.tatu(&["run", "scene.toml", "--steps", "3", "--allow", "python", "--snapshot-at", "0.1", "half.snap"]).good();
    let done = place.tatu(&["run", "scene.toml", "--from", "half.snap", "--steps", "2", "--allow", "python"]).good();
    let said = done.out + &done.err;
    assert!(said.contains("count 3") && !said.contains("count 1\n"), "{said}");
}

#[test]
fn functions_that_a_command_retains_are_called_after_it_has_returned() {
    let script = "
def sysCall_init():
    sim = require('sim')
    self.heard = 0
    tatu.on('mine.ping', heard)
def heard(event, name):
    self.heard += event['x']
def sysCall_actuation():
    tatu.emit('mine.ping', {'x': 2})
def sysCall_sensing():
    assert self.heard > 0 and self.heard % 2 == 0
    print('heard', self.heard)";
    assert!(printed(&dummy("a", script), 3).contains("heard 6"));
}

#[test]
fn files_that_a_script_leaves_open_are_complete_at_the_end() {
    let script = "
def sysCall_init():
    self.file = open('data.csv', 'w')
def sysCall_sensing():
    self.file.write('line' + chr(10))";
    let place = TestFolder::scene(&dummy("a", script));
    place.tatu(&["run", "scene.toml", "--steps", "3", "--allow", "python"]).good();
    assert!(place.read("data.csv").matches("line").count() >= 3);
}

#[test]
fn a_replay_runs_the_script_again_if_it_is_allowed() {
    let place = TestFolder::scene(&dummy("a", "import random\ndef sysCall_sensing(): print('drawn', random.random())"));
    let drawn = |args: &[&str]| {
        let done = place.tatu(args).good();
        (done.out + &done.err).lines().filter(|l| l.starts_with("drawn")).map(str::to_owned).collect::<Vec<_>>()
    };
    let first = drawn(&["run", "scene.toml", "--steps", "3", "--allow", "python", "--log", "log"]);
    assert!(first.len() > 2, "{first:?}");
    assert_eq!(first, drawn(&["run", "--replay", "log", "--allow", "python"]));
    assert_eq!(drawn(&["run", "--replay", "log"]), [""; 0]);
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn arrays_of_numpy_are_lists_and_its_generators_are_seeded() {
    let script = "
import numpy as np
def sysCall_init():
    sim = require('sim')
    here = np.int64(sim.getObject('.'))
    sim.setObjectPosition(here, np.array([1, 2.5, 3]))
    assert sim.getObjectPosition(here, np.int32(-1)) == [1.0, 2.5, 3.0]
    sim.setFloatSignal('x', np.float32(1.5))
    assert sim.getFloatSignal('x') == 1.5
    print('drawn', np.random.rand(2), np.random.default_rng().random())";
    let place = TestFolder::scene(&dummy("a", script));
    let python = served_scene::python("numpy", "numpy").display().to_string();
    let drawn = || {
        let args = ["run", "scene.toml", "--steps", "1", "--allow", "python"];
        let done = run(program(), place.path(), &args, &[("TATU_PYTHON", &python)]).good();
        (done.out + &done.err).lines().filter(|l| l.contains("drawn")).map(str::to_owned).collect::<Vec<_>>()
    };
    let first = drawn();
    assert_eq!(first.len(), 1);
    assert_eq!(first, drawn());
}

/// Creates a link with this path to the interpreter `python3`.
fn link(path: &std::path::Path) {
    let found =
        std::process::Command::new("python3").args(["-c", "import sys; print(sys.executable)"]).output().unwrap();
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::os::unix::fs::symlink(String::from_utf8(found.stdout).unwrap().trim(), path).unwrap();
}

/// A script that prints its interpreter.
const WHO: &str = "import sys\ndef sysCall_init(): print('runs', sys.executable)";

#[test]
fn the_interpreter_is_that_of_the_command_line_then_that_of_the_scene_then_that_of_the_user() {
    let place = TestFolder::new();
    let data = place.path().join("data");
    place.write("scenes/plain.toml", &format!("format = 1\n{}", dummy("a", WHO)));
    let own = "[language.python]\ninterpreter = \"tools/of_scene\"\n";
    place.write("scenes/scene.toml", &format!("format = 1\n{own}{}", dummy("a", WHO)));
    let named = |name: &str| place.path().join(name);
    place.write("data/tatu/settings.toml", &own.replace("tools/of_scene", named("of_user").to_str().unwrap()));
    ["of_call", "scenes/tools/of_scene", "of_user", "of_variable"].iter().for_each(|name| link(&named(name)));
    let runs = |args: &[&str], variables: &[(&str, &str)]| {
        let args = [&["run"], args, &["--steps", "1", "--allow", "python"]].concat();
        let done = run(program(), place.path(), &args, variables).good();
        let said = done.out + &done.err;
        said.lines().find_map(|l| Some(l.split_once("runs ")?.1.to_owned())).unwrap_or(said)
    };
    let variable = named("of_variable");
    let variable = ("TATU_PYTHON", variable.to_str().unwrap());
    let settings = ("XDG_DATA_HOME", data.to_str().unwrap());
    let given = ["scenes/scene.toml", "--language", "python:interpreter=./of_call"];
    for (args, variables, expected) in [
        (&given[..], &[variable, settings][..], "of_call"),
        (&["scenes/scene.toml"], &[variable, settings], "scenes/tools/of_scene"),
        (&["scenes/plain.toml"], &[variable, settings], "of_user"),
        (&["scenes/plain.toml"], &[variable], "of_variable"),
    ] {
        assert_eq!(runs(args, variables), named(expected).display().to_string(), "{args:?}");
    }
    // A saved scene has the settings of its own file only.
    runs(&[&given[..], &["--save", "scenes/saved.toml"]].concat(), &[]);
    let saved = place.read("scenes/saved.toml");
    assert!(saved.contains(own.trim()) && !saved.contains("of_call"), "{saved}");
    // A replay uses the interpreter of the machine on which it is run.
    place.tatu(&["run", "scenes/scene.toml", "--steps", "1", "--allow", "python", "--log", "log"]).good();
    let replayed = ["--replay", "log", "--language", "python:interpreter=./of_call"];
    assert_eq!(runs(&replayed, &[]), named("of_call").display().to_string());
}

#[test]
fn settings_of_languages_are_checked() {
    let place = TestFolder::scene(&dummy("a", WHO));
    let refused = |setting: &str, words: &[&str]| {
        place.tatu(&["run", "scene.toml", "--steps", "1", "--language", setting]).refused(words);
    };
    refused("pyton:interpreter=x", &["E101", "there is no script language `pyton`", "did you mean `python`?"]);
    refused("python:interpretr=x", &["E101", "unknown key `interpretr`", "did you mean `interpreter`?"]);
    refused("python:memory_mb=much", &["E102", "`memory_mb`", "an integer"]);
    refused("python", &["E102", "sets nothing"]);
    let scene = |table: &str| place.write("scene.toml", &format!("format = 1\n{table}\n"));
    scene("[language.python]\nmemory_mb = -1");
    place.tatu(&["check", "scene.toml"]).refused(&["E102", "scene.toml:3"]);
    scene("[language.ruby]");
    place.tatu(&["check", "scene.toml"]).refused(&["E101", "there is no script language `ruby`", "scene.toml:2"]);
    let told = place.tatu(&["describe", "python"]).good().out;
    assert!(told.contains("permission: python") && told.contains("interpreter"), "{told}");
}

#[test]
fn a_missing_interpreter_is_named_with_what_to_do() {
    let place = TestFolder::scene(&dummy("a", WHO));
    let args = ["run", "scene.toml", "--steps", "1", "--allow", "python", "--language", "python:interpreter=no_such"];
    let said = place.tatu(&args);
    let said = said.out + &said.err;
    for words in ["there is no Python interpreter `no_such`", "`--language python:interpreter=PATH`"] {
        assert!(said.contains(words), "{said}");
    }
    // Without the permission, the program that a scene names is not started.
    place.write("started", "#!/bin/sh\ntouch was_started\n");
    let started = place.path().join("started");
    std::fs::set_permissions(&started, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    let scene = format!("format = 1\n[language.python]\ninterpreter = \"./started\"\n{}", dummy("a", WHO));
    place.write("scene.toml", &scene);
    place.tatu(&["run", "scene.toml", "--steps", "1"]).good();
    assert!(!place.path().join("was_started").exists());
    place.tatu(&["run", "scene.toml", "--steps", "1", "--allow", "python"]);
    assert!(place.path().join("was_started").exists());
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn the_example_with_opencv_follows_the_ball_and_saves_its_pictures() {
    let place = TestFolder::new();
    let python = served_scene::python("opencv-python-headless matplotlib", "cv2, matplotlib.pyplot");
    let scene = root().join("scenes/first/follow_a_ball.toml").display().to_string();
    let set = format!("python:interpreter={}", python.display());
    let done =
        place.tatu(&["run", &scene, "--seconds", "30", "--allow", "python", "--language", &set, "--strict"]).good();
    let said = done.out + &done.err;
    let away = said.lines().find_map(|l| l.split_once("the ball is ")?.1.strip_suffix(" m away")?.parse::<f64>().ok());
    // The camera is 0.15 m ahead of the robot's centre, and stays 0.7 m away from the ball, which moves.
    assert!(away.is_some_and(|away| (0.6..1.3).contains(&away)), "{said}");
    for picture in ["followed.png", "seen.png"] {
        assert_eq!(std::fs::read(place.path().join(picture)).unwrap()[..4], *b"\x89PNG", "{picture}");
    }
}
