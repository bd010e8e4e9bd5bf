//! Tests of `tatu grade`, which awards points to the scripts of students, and of the course that `tatu new` creates.

use std::time::Instant;

use crate::kit::*;

/// A robot that drives to a flag 0.6 m away.
const SCENE: &str = r#"format = 1

[scene]
duration_s = 3.0

[[object]]
kind = "shape"
alias = "floor"
primitive = "plane"
respondable = true

[[object]]
kind = "shape"
alias = "Flag"
size_m = [0.2, 0.2, 0.01]
position_m = [0.6, 0.0, 0.01]

[[model]]
model = "pioneer_p3dx"
script = "own.lua"
"#;

const CRITERIA: &str = "local goals = require('tatu.goals')
function sysCall_init()
    goals.begin{
        'Drive, do not jump: never /Pioneer_p3dx jumps',
        'Leave the flag alone: never /Flag jumps',
        {'Reach the flag: /Pioneer_p3dx within 0.2 m of /Flag if goal 1', points = 4},
        {'Stay on the floor: never /Pioneer_p3dx object.position.z > 0.5 if goal 3', points = 2},
    }
end
sysCall_sensing, sysCall_cleanup = goals.check, goals.finish
";

fn driver(speed: f64) -> String {
    format!(
        "function sysCall_init()\n left = sim.getObject('./Pioneer_p3dx_leftMotor')\n \
         right = sim.getObject('./Pioneer_p3dx_rightMotor')\nend\n\
         function sysCall_actuation()\n sim.setJointTargetVelocity(left, {speed})\n \
         sim.setJointTargetVelocity(right, {speed})\nend\n"
    )
}

fn place() -> TestFolder {
    let place = TestFolder::new();
    place.write("scene.toml", SCENE).write("own.lua", &driver(0.0)).write("teacher/criteria.lua", CRITERIA);
    place
}

/// Scripts that misbehave, with the points that they get.
fn misbehaving() -> Vec<(String, u32)> {
    let jump = "local p = sim.getObjectPosition(sim.getObject('/Flag'), -1)\n\
                sim.setObjectPosition(sim.getObject('/Pioneer_p3dx'), -1, {p[1], p[2], 0.14})";
    let fetch = "sim.setObjectPosition(sim.getObject('/Flag'), -1, {0, 0, 0.01})";
    let in_init = |code: &str| format!("function sysCall_init()\n{code}\nend\n");
    let each_step = |code: &str| format!("function sysCall_actuation()\n{code}\nend\n");
    let mut all: Vec<(String, u32)> = vec![
        // These do nothing, so that only the two goals with `never` are reached that require nothing.
        ("function (".to_owned(), 2),
        ("x = nil + 1".to_owned(), 2),
        (in_init("while true do end"), 2),
        (each_step("while true do end"), 2),
        (each_step("error('each step')"), 2),
        (in_init("local t = {} while true do t[#t + 1] = string.rep('x', 1e6) end"), 2),
        (each_step("local function f() return f() + 1 end f()"), 2),
        (in_init("string.rep('x', 1e9)"), 2),
        (in_init("os.exit(0)"), 2),
        (in_init("io.open('/etc/passwd'):read('a')"), 2),
        (in_init("io.open('../../teacher/criteria.lua'):read('a')"), 2),
        (in_init("io.open('../../../criteria/criteria.lua'):read('a')"), 2),
        (in_init("os.execute('touch ../../was-here')"), 2),
        (in_init("io.popen('ls')"), 2),
        (in_init("require('socket').tcp():connect('127.0.0.1', 22)"), 2),
        (in_init("require('tatu.goals').begin{}"), 2),
        (
            in_init(
                "tatu.emit('exercise.goals', {goals = {{text = 'Reach the flag', state = 'reached', time = 1, points = 100}}})",
            ),
            2,
        ),
        (in_init("print('reached at 1.00 s: Reach the flag')"), 2),
        (in_init("for h = 1, 300 do pcall(sim.removeObjects, {h}) end"), 2),
        (in_init("for h = 1, 300 do pcall(sim.callScriptFunction, 'sysCall_cleanup', h) end"), 2),
        (in_init("sim.stopSimulation()"), 2),
        (each_step("sim.stopSimulation()"), 2),
        (each_step("sim.pauseSimulation()"), 2),
        (in_init("sim.quitSimulator()"), 2),
        (in_init("sim.closeScene()"), 2),
        (in_init("sim.loadScene('scene.toml')"), 2),
        // Jumps and moved flags fail their own goal.
        (in_init(jump), 1),
        (each_step(jump), 1),
        (in_init(fetch), 5),
        ("#python\ndef sysCall_init():\n    pass\n".to_owned(), 0),
    ];
    // A robot that stands at the flag that it has fetched reaches all but the goal that forbids that.
    all[28].1 = 7;
    all
}

/// Thirty scripts that misbehave among others: each gets its own points, the same with one and two threads.
#[test]
fn each_script_gets_its_own_points() {
    let place = place();
    let bad = misbehaving();
    assert_eq!(bad.len(), 30);
    // Most of the others differ in speed only, and so in whether they arrive.
    let many = 18;
    let mut expected = Vec::new();
    for (i, (script, points)) in bad.iter().enumerate() {
        place.write(&format!("in/bad_{i:02}.lua"), script);
        expected.push((format!("bad_{i:02}"), *points));
    }
    for i in 0..many {
        let arrives = i % 2 == 0;
        place.write(&format!("in/good_{i:03}.lua"), &driver(if arrives { 2.4 } else { 0.5 } + 0.0001 * f64::from(i)));
        expected.push((format!("good_{i:03}"), if arrives { 8 } else { 2 }));
    }
    let begin = Instant::now();
    let args = ["grade", "scene.toml", "teacher/criteria.lua", "in", "--timeout", "20", "--csv"];
    let first = place.tatu(&[&args[..], &["two.csv", "-j", "2"]].concat()).good();
    eprintln!("{} scripts in {:.0?}", expected.len(), begin.elapsed());
    let rows = place.read("two.csv");
    for (student, points) in &expected {
        let row =
            rows.lines().find(|row| row.starts_with(student.as_str())).unwrap_or_else(|| panic!("{student}: {rows}"));
        assert!(row.starts_with(&format!("{student},{points},")), "{student}, wanted {points}: {row}\n{}", first.err);
    }
    place.tatu(&[&args[..], &["one.csv", "-j", "1"]].concat()).good();
    assert_eq!(rows, place.read("one.csv"));
}

#[test]
fn results_are_written_for_other_programs_and_slips_are_checked() {
    let place = place();
    place.write("in/=anna/controller.lua", &driver(2.5)).write("in/bruno.lua", &format!("-- mine\n{}", driver(2.5)));
    place.write("in/carla.lua", "x = ").write("in/empty/README.md", "nothing");
    #[cfg(unix)]
    std::os::unix::fs::symlink("../teacher/criteria.lua", place.path().join("in/link.lua")).unwrap();
    let run = place.tatu(&[
        "grade",
        "scene.toml",
        "teacher/criteria.lua",
        "in",
        "--seeds",
        "1,2",
        "--csv",
        "marks.csv",
        "--html",
        "page",
        "--gradescope",
        "gradescope",
        "--github",
    ]);
    let run = run.good();
    assert!(run.out.contains("=anna  8 of 8  moves exactly as bruno"), "{}", run.out);
    assert!(run.out.contains("there are 0 scripts in the folder"), "{}", run.out);
    #[cfg(unix)]
    assert!(run.out.contains("link   0 of 0  it is a link"), "{}", run.out);
    assert!(run.out.contains("::error file=in/carla.lua::not reached: Reach the flag"), "{}", run.out);
    let marks = place.read("marks.csv");
    assert!(marks.starts_with("student,points,of,") && marks.contains("\n'=anna,8,8,1,1,4,2,"), "{marks}");
    let page = place.read("page/index.html");
    assert!(page.contains("<a href=\"001__anna.html\">=anna</a>") && page.contains("not reached"), "{page}");
    assert!(place.read("page/001__anna.html").contains("<html"));
    let results: serde_json::Value = serde_json::from_str(&place.read("gradescope/bruno.json")).unwrap();
    assert_eq!((&results["score"], &results["tests"][2]["max_score"]), (&8.0.into(), &4.0.into()));

    // A slip holds in another folder, and for its own script only.
    let slip = run.out.lines().find_map(|l| l.strip_prefix("slip of bruno: ")).unwrap();
    let other = self::place();
    other.write("mine.lua", &format!("-- mine\n{}", driver(2.5))).write("else.lua", &driver(2.6));
    let check = |script, slip: &str| {
        other.tatu(&["grade", "scene.toml", "teacher/criteria.lua", script, "--seeds", "1,2", "--check", slip])
    };
    assert!(check("mine.lua", slip).good().out.starts_with("the slip is right"));
    let wrong = check("else.lua", slip);
    assert!(wrong.code == 1 && wrong.out.contains("it states script"), "{}", wrong.out);
    let wrong = check("mine.lua", &slip.replace("points=8/8", "points=9/8"));
    assert!(wrong.code == 1 && wrong.out.contains("it states points 9/8, but it is 8/8"), "{}", wrong.out);
}

#[test]
fn criteria_that_are_wrong_are_reported_before_anything_is_graded() {
    let place = place();
    place.write("in/a.lua", &driver(1.0));
    for (criteria, wanted) in [
        ("goals = ", "goals"),
        ("function sysCall_init() require('tatu.goals').begin{'/Pioneer_p3dx flies'} end", "cannot be read"),
        ("", "reports no goals"),
    ] {
        place.write("teacher/criteria.lua", criteria);
        place.tatu(&["grade", "scene.toml", "teacher/criteria.lua", "in"]).refused(&[wanted]);
    }
    place.tatu(&["grade", "scene.toml", "nowhere.lua", "in"]).refused(&["nowhere.lua"]);
}

/// The solution of a new course reaches every goal, and its script to start from does not.
#[test]
fn a_new_course_can_be_solved_tested_and_graded() {
    let place = TestFolder::new();
    place.tatu(&["new", "course", "maze"]).good();
    place.tatu(&["check", "maze/scene.toml"]).good();
    let run = place.tatu(&["test", "maze", "--set", "scene.duration_s=2"]);
    assert_eq!(run.code, 3, "{}{}", run.out, run.err);
    let args =
        ["grade", "maze/scene.toml", "maze/teacher/criteria.lua", "maze/teacher/solution.lua", "--seconds", "20"];
    let graded = place.tatu(&args).good();
    assert!(graded.out.contains("solution  10 of 10"), "{}", graded.out);
}
