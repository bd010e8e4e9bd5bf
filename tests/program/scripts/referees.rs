//! Tests of referees: scripts that judge a run, and which the scripts that they judge can neither see nor affect.

use serde_json::Value;

use crate::kit::*;

/// A robot in front of a flag, 2 m away, and two goals.
const SCENE: &str = r#"
dt_s = 0.05

[[object]]
kind = "shape"
alias = "floor"
primitive = "plane"
respondable = true

[[object]]
kind = "shape"
alias = "Flag"
size_m = [0.2, 0.2, 0.01]
position_m = [2.0, 0.0, 0.01]

[[object]]
kind = "shape"
alias = "Robot"
dynamic = true
respondable = true
size_m = [0.2, 0.2, 0.2]
position_m = [0.0, 0.0, 0.11]
script = "student.lua"

[[object]]
kind = "dummy"
alias = "Exercise"
script = { file = "goals.lua", kind = "referee" }
data = { "exercise.goals" = """
Do not jump: never /Robot jumps
Reach the flag: /Robot within 0.3 m of /Flag before 0.9 s if goal 1
""" }
"#;

fn judged(student: &str) -> RunOutput {
    judged_in(SCENE, student)
}

fn judged_in(scene: &str, student: &str) -> RunOutput {
    let place = TestFolder::scene(scene);
    place.write("student.lua", student);
    let goals = std::fs::read_to_string(root().join("scenes/learn/exercise.lua")).unwrap();
    place.write("goals.lua", &goals);
    place.tatu(&["run", "scene.toml", "--seconds", "1", "--json"])
}

fn states(run: &RunOutput) -> Vec<String> {
    let goals = run.json()["goals"].clone();
    goals.as_array().unwrap().iter().map(|g| g["state"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn goals_are_in_the_summary_and_in_the_exit_code() {
    let lazy = judged("");
    assert_eq!(lazy.code, 3, "{}", lazy.err);
    assert_eq!(states(&lazy), ["reached", "failed"]);
    let goals = lazy.json()["goals"].clone();
    assert_eq!((&goals[1]["text"], &goals[1]["points"]), (&Value::from("Reach the flag"), &Value::from(1.0)));
    let near = judged_in(&SCENE.replace("position_m = [2.0", "position_m = [0.25"), "");
    assert_eq!((near.code, states(&near)), (0, vec!["reached".to_owned(); 2]), "{}", near.err);
    // Errors outweigh goals.
    assert_eq!(judged("function sysCall_sensing() error('no') end").code, 1);
}

/// Each of these scripts tries to make the goals look reached.
#[test]
fn no_script_reaches_a_referee() {
    let jump = "local p = sim.getObjectPosition(sim.getObject('/Flag'), -1) \
                sim.setObjectPosition(sim.getObject('/Robot'), -1, {p[1], p[2], 0.11})";
    for (name, attack) in [
        ("removes the object", "sim.removeObjects({sim.getObject('/Exercise')})".to_owned()),
        (
            "removes every script",
            "for _, s in ipairs(sim.getObjectsInTree(sim.handle_scene, sim.handle_all, 0)) do \
             if s ~= sim.getObject('/Robot') and s ~= sim.getObject('.') and s ~= sim.getObject('/Flag') then \
             pcall(sim.removeObjects, {s}) end end"
                .to_owned(),
        ),
        (
            "guesses handles",
            "for h = 1, 60 do pcall(sim.setScriptText or print, h, 'x = 1') pcall(sim.removeScript or print, h) \
             pcall(sim.callScriptFunction, 'sysCall_cleanup', h) end"
                .to_owned(),
        ),
        ("clears the texts", "tatu.set(sim.getObject('/Exercise'), 'object.data', {})".to_owned()),
        (
            "reports by itself",
            "tatu.emit('exercise.goals', {goals = {{text = 'Reach the flag', state = 'reached', time = 0.1}}}) \
             print('reached at 0.10 s: Reach the flag')"
                .to_owned(),
        ),
        ("copies the object", "sim.copyPasteObjects({sim.getObject('/Exercise')}, 0)".to_owned()),
        ("broadcasts", "sim.broadcastMsg({id = 1}) ".to_owned()),
        ("stops the run", "sim.stopSimulation()".to_owned()),
        ("jumps", jump.to_owned()),
        ("jumps and removes", format!("{jump} sim.removeObjects({{sim.getObject('/Exercise')}})")),
    ] {
        for callback in ["init", "actuation", "sensing"] {
            let run = judged(&format!("function sysCall_{callback}()\n {attack}\nend\n"));
            let reached = states(&run);
            assert_ne!(run.code, 0, "{name} in {callback}: {}", run.err);
            assert_eq!(reached.len(), 2, "{name} in {callback}: {}", run.err);
            assert_eq!(reached[1], "failed", "{name} in {callback}: {}", run.err);
        }
    }
}

/// The scripts of exercises that were saved as child scripts are referees, too.
#[test]
fn child_scripts_of_older_exercises_become_referees() {
    let place = TestFolder::scene(&SCENE.replace(", kind = \"referee\"", ""));
    place.write("student.lua", "function sysCall_init() sim.removeObjects({sim.getObject('/Exercise')}) end\n");
    let goals = std::fs::read_to_string(root().join("scenes/learn/exercise.lua")).unwrap();
    place.write("goals.lua", &goals);
    let run = place.tatu(&["run", "scene.toml", "--seconds", "1", "--json"]);
    assert_eq!((run.code, states(&run)), (3, vec!["reached".to_owned(), "failed".to_owned()]), "{}", run.err);
}

/// A referee sees objects as they were before any script of the run could move them, and knows its own handle.
#[test]
fn referees_begin_first_and_are_called_last() {
    let place = TestFolder::scene(&SCENE.replace("file = \"goals.lua\"", "file = \"first.lua\""));
    place.write(
        "student.lua",
        "function sysCall_actuation() sim.setFloatSignal('moved', 1) end\n\
        function sysCall_init() sim.setObjectPosition(sim.getObject('..'), -1, {1, 0, 0.11}) end\n",
    );
    place.write("first.lua", "function sysCall_init()\n start = sim.getObjectPosition(sim.getObject('/Robot'), -1)[1]\n\
        own = sim.getObject('.')\nend\n\
        function sysCall_actuation()\n tatu.emit('exercise.goals', {goals = {{text = 'first', \
        state = start == 0 and sim.getFloatSignal('moved') == 1 and own > 0 and 'reached' or 'failed', time = 0}}})\nend\n");
    let run = place.tatu(&["run", "scene.toml", "--seconds", "0.2", "--json"]);
    assert_eq!((run.code, states(&run)), (0, vec!["reached".to_owned()]), "{}", run.err);
}
