//! Tests of add-ons: how they are found, listed, started automatically or by name, called, ended, and replayed.

use std::{fs, thread, time::Duration};

use serde_json::{Value, json};

use crate::{kit::*, remote::jsonl::RunningProgram};

/// Creates a scene with a floor, a Pioneer that drives, and these add-ons in `addons/`.
fn place(addons: &[(&str, &str)]) -> TestFolder {
    let place = TestFolder::scene(&format!("{FLOOR}{}", pioneer(DRIVE, "")));
    for (file, text) in addons {
        place.write(&format!("addons/{file}"), text);
    }
    place
}

const DRIVE: &str = "function sysCall_init()
  left, right = sim.getObject('/Pioneer_p3dx/Pioneer_p3dx_leftMotor'), sim.getObject('/Pioneer_p3dx/Pioneer_p3dx_rightMotor')
end
function sysCall_actuation()
  sim.setJointTargetVelocity(left, 2)
  sim.setJointTargetVelocity(right, 2)
end";

/// Returns the lines of standard error that begin with `> `, in order and without this prefix.
fn marked_lines(done: &RunOutput) -> Vec<String> {
    done.err.lines().filter(|l| l.starts_with("> ")).map(|l| l[2..].to_owned()).collect()
}

fn listed(place: &TestFolder, env: &[(&str, &str)]) -> Vec<Value> {
    run(program(), place.path(), &["list", "addons", "--json"], env).good().json().as_array().unwrap().clone()
}

// Whether an add-on starts automatically depends on its file name, and on `autoStart` in the result of `sysCall_info`
// (tests/facts/script-api.md, 6).
#[test]
fn file_names_and_auto_start_decide_which_addons_start() {
    let say = |name: &str| format!("-- Says {name}.\nprint('> {name}')\n");
    let no = "-- Keeps still.\nfunction sysCall_info() return {autoStart = false} end\nprint('> no')\n";
    let files = [
        ("asks.lua", no.to_owned()),
        ("plain.lua", say("plain")),
        ("simAddOnNew.lua", say("New")),
        ("vrepAddOnFunc_click.lua", say("click")),
        ("vrepAddOnScript-hyphen.lua", say("hyphen")),
        ("vrepAddOnScript_old.lua", say("old")),
        ("readme.txt", "no add-on".to_owned()),
        (".hidden.lua", say("hidden")),
    ];
    let files: Vec<(&str, &str)> = files.iter().map(|(f, t)| (*f, t.as_str())).collect();
    let place = place(&files);
    let all = listed(&place, &[]);
    let row =
        |a: &Value| format!("{} {} {}", a["name"].as_str().unwrap(), a["auto_start"], a["style"].as_str().unwrap());
    let rows: Vec<String> = all.iter().map(row).collect();
    assert_eq!(
        rows,
        [
            "asks false callbacks",
            "plain true callbacks",
            "New true callbacks",
            "click false function",
            "hyphen false callbacks",
            "old true callbacks",
        ]
    );
    assert_eq!((&all[1]["text"], &all[1]["file"]), (&"Says plain.".into(), &"addons/plain.lua".into()));
    let done = place.run(&["--steps", "1"]).good();
    assert_eq!(marked_lines(&done), ["plain", "New", "old"]);
    done.reports(&["the add-on plain is started", "--no-addon plain"]);
    let left_out = place.run(&["--steps", "1", "--no-addon", "plain"]).good();
    assert!(!left_out.err.contains("add-on plain is started"), "{}", left_out.err);
    let nobody = place.run(&["--steps", "1", "--no-addon", "plane"]);
    nobody.refused(&["error[E600]", "plane", "did you mean `plain`"]);
    place.run(&["--steps", "2", "--no-addons", "--snapshot-at", "0.05", "one"]).good();
    place.run(&["--steps", "2", "--no-addons", "--from", "one"]).good();
    assert_eq!(marked_lines(&place.run(&["--steps", "1", "--no-addons"]).good()), [""; 0]);
    let named = place.run(&["--steps", "1", "--no-addons", "--addon", "hyphen", "--addon", "click", "--addon", "asks"]);
    // An add-on function runs immediately; the other add-ons start with the first pass.
    assert_eq!(marked_lines(&named.good()), ["click", "no", "hyphen"]);
    // An add-on can be named by its file. An add-on function runs once each time it is named.
    let file = place.run(&["--steps", "1", "--no-addons", "--addon", "addons/vrepAddOnScript-hyphen.lua"]).good();
    assert_eq!(marked_lines(&file), ["hyphen"]);
    place.run(&["--addon", "hyphenn"]).refused(&["E600", "there is no add-on `hyphenn`", "did you mean `hyphen`?"]);
}

#[test]
fn folders_are_searched_in_order_and_the_first_wins_a_name() {
    let place = place(&[("one.lua", "-- First.\nprint('> first')")]);
    place.write("more/one.lua", "-- Second.\nprint('> second')").write("more/two.lua", "-- Two.\nprint('> two')");
    place
        .write("more/three/addon.toml", "text = \"In a folder.\"\nauto_start = false\n")
        .write("more/three/init.lua", "print('> three ' .. tatu.options().x)");
    let path = place.path().join("more");
    let env = [("TATU_ADDON_PATH", path.to_str().unwrap())];
    let all = listed(&place, &env);
    let texts: Vec<&str> = all.iter().map(|a| a["text"].as_str().unwrap()).collect();
    assert_eq!(texts, ["First.", "In a folder.", "Two."]);
    assert_eq!(all[1]["auto_start"], false);
    let args = ["run", "scene.toml", "--json", "--steps", "1", "--addon", "three:x=4"];
    let done = run(program(), place.path(), &args, &env).good();
    assert_eq!(marked_lines(&done), ["first", "three 4", "two"]);
    done.reports(&["E602", "two add-ons have the name `one`"]);
    place.write("addons/four/addon.toml", "colour = 1\n").write("addons/four/init.lua", "");
    place.tatu(&["list", "addons"]).good().reports(&["E601", "unknown key `colour`"]);
}

// See tests/facts/call-order.md, 1: `init`, then `nonSimulation` in each pass of a stopped world, `beforeSimulation`,
// the stages of each step after all other scripts, `afterSimulation`, and `cleanup` at the end.
#[test]
fn an_addon_is_called_as_observed_and_outlives_the_run() {
    let life = "
        local function say(what) print('> ' .. what .. ' ' .. sim.getSimulationState()) end
        for _, name in ipairs{'init', 'nonSimulation', 'beforeSimulation', 'beforeMainScript', 'actuation', 'sensing',
            'afterSimulation', 'cleanup'} do
          _G['sysCall_' .. name] = function() say(name) end
        end";
    let place = place(&[("life.lua", life)]);
    let lines = marked_lines(&place.run(&["--steps", "1"]).good());
    let names: Vec<&str> = lines.iter().map(|l| l.split(' ').next().unwrap()).collect();
    let pass = ["beforeMainScript", "actuation", "sensing"];
    let mut expected = vec!["init", "nonSimulation", "beforeSimulation"];
    // One step, and the three passes from the stop request to the end.
    (0..4).for_each(|_| expected.extend(pass));
    expected.extend(["afterSimulation", "cleanup"]);
    assert_eq!(names, expected);
    assert_eq!(lines[0], "init 0");
    assert_eq!(lines[expected.len() - 2], "afterSimulation 0");
}

// See tests/facts/script-api.md, 6: the run modes are 0 (starting), 1 (running) and 4 (ending). An add-on ends if it
// returns 0.
#[test]
fn an_old_addon_is_run_as_a_whole_and_ends_by_returning_0() {
    let old = "
        n = n or 0
        if sim_call_type == sim_addonscriptcall_initialization then print('> begins') end
        if sim_call_type == sim_addonscriptcall_run then
          n = n + 1
          if n == 3 then print('> enough ' .. n) return 0 end
        end
        if sim_call_type == sim_addonscriptcall_cleanup then print('> ends') end";
    let place = place(&[("vrepAddOnScript_old.lua", old)]);
    assert_eq!(listed(&place, &[])[0]["style"], "call type");
    assert_eq!(marked_lines(&place.run(&["--steps", "10"]).good()), ["begins", "enough 3", "ends"]);
}

// See tests/facts/script-api.md, 6: `sysCall_addOnScriptRun` is called in each pass; the add-on ends if it returns
// sim.syscb_cleanup (1).
#[test]
fn script_addons_run_in_each_pass_and_function_addons_once() {
    let text = "function sysCall_init() print('> init') n = 0 end
        function sysCall_addOnScriptRun()
          n = n + 1
          print('> run ' .. n)
          if n == 4 then return sim.syscb_cleanup end
        end
        function sysCall_cleanup() print('> over') end";
    let place = place(&[("vrepAddOnScript-between.lua", text)]);
    let done = place.run(&["--steps", "10", "--addon", "between"]).good();
    assert_eq!(marked_lines(&done), ["init", "run 1", "run 2", "run 3", "run 4", "over"]);
    // The text of an add-on function runs once, whether it uses names of new or of old versions of V-REP.
    for text in ["print('> once')\nreturn sim.syscb_cleanup", "print('> once ' .. simGetSimulationTime())"] {
        place.write("addons/vrepAddOnFunc_once.lua", text);
        let done = place.run(&["--steps", "3", "--addon", "once"]).good();
        assert_eq!(marked_lines(&done).len(), 1, "{}", done.err);
    }
    place.write("addons/vrepAddOnFunc_once.lua", "local x = nil + 1");
    let done = place.run(&["--steps", "3", "--addon", "once"]);
    assert_eq!((&done.errors()[0]["line"], &done.json()["steps"]), (&1.into(), &3.into()));
}

#[test]
fn options_reach_an_addon_as_a_table_of_the_types_of_its_defaults() {
    let text = "function sysCall_info() return {autoStart = false} end
        function sysCall_init()
          local o = tatu.options{period = 0.5, n = 1, loud = false, paths = ''}
          print('> ' .. o.period * 2 .. ' ' .. o.n .. ' ' .. tostring(o.loud) .. ' ' .. o.paths)
          return {cmd = 'cleanup'}
        end
        function sysCall_actuation() print('> never') end
        function sysCall_cleanup() print('> over') end";
    let place = place(&[("given.lua", text)]);
    let given = |options: &str| place.run(&["--steps", "2", "--addon", &format!("given:{options}")]);
    assert_eq!(marked_lines(&given("period=0.25,loud=yes,paths=/a,/b").good()), ["0.5 1 true /a,/b", "over"]);
    let wrong = given("perod=1").errors();
    assert!(
        wrong[0]["message"].as_str().unwrap().contains("no option `perod`; expected one of: loud, n, paths, period")
    );
    assert!(wrong[0]["file"].as_str().unwrap().ends_with("given.lua") && wrong[0]["line"] == 3, "{wrong:?}");
    place.run(&["--addon", ":period=1"]).refused(&["E102", "does not name an add-on"]);
}

#[test]
fn a_failing_addon_is_named_and_suspended_without_other_effects() {
    let good = place(&[]);
    let without = good.run(&["--seconds", "1"]).good().json();
    let bad = "function sysCall_actuation()
          if sim.getSimulationTime() > 0.32 then local x = nil + 1 end
        end
        function sysCall_sensing() calls = (calls or 0) + 1 end
        function sysCall_cleanup() print('> ' .. calls) end";
    let done = place(&[("bad.lua", bad)]).run(&["--seconds", "1"]);
    let errors = done.errors();
    assert_eq!(errors.len(), 1, "{errors:?}");
    assert!(errors[0]["file"].as_str().unwrap().ends_with("addons/bad.lua"), "{errors:?}");
    assert_eq!((&errors[0]["line"], &errors[0]["count"]), (&2.into(), &1.into()), "called after its error");
    // It failed in the actuation of the eighth step, at 0.35 s, after seven complete steps.
    assert_eq!(marked_lines(&done), ["7"]);
    let (with, without) = (&done.json()["objects"], &without["objects"]);
    assert_eq!(with, without, "the add-on has changed positions or hashes of robots");
    assert!(errors[0]["object"].is_null(), "an add-on does not belong to an object: {errors:?}");
    // An add-on for old versions of V-REP is also stopped (tests/facts/script-api.md, 6), whereas old scripts of the
    // scene are called again after an error.
    let old = "if sim_call_type == sim_addonscriptcall_run then local x = nil + 1 end
        if sim_call_type == sim_addonscriptcall_cleanup then print('> ends') end";
    let done = place(&[("old.lua", old)]).run(&["--steps", "5"]);
    assert_eq!((&done.errors()[0]["count"], marked_lines(&done)), (&1.into(), vec!["ends".to_owned()]), "{}", done.err);
    let loops = place(&[("loops.lua", "function sysCall_actuation() while true do end end")]).run(&["--steps", "3"]);
    assert_eq!(loops.errors()[0]["kind"], "budget");
}

#[test]
fn a_replay_has_the_addons_of_the_run() {
    let push = "function sysCall_info() return {autoStart = false} end
        function sysCall_init() speed = tatu.options{speed = 1}.speed end
        function sysCall_actuation()
          sim.setJointTargetVelocity(sim.getObject('/Pioneer_p3dx/Pioneer_p3dx_leftMotor'), speed)
        end";
    let place = place(&[("push.lua", push)]);
    let ran = place.run(&["--seconds", "1", "--addon", "push:speed=7", "--log", "run.log"]).good().json();
    let plain = place.run(&["--seconds", "1"]).good().json();
    assert_ne!(ran["hash"], plain["hash"]);
    // The log contains the add-on's text.
    fs::remove_file(place.path().join("addons/push.lua")).unwrap();
    let again = place.tatu(&["run", "--replay", "run.log", "--json"]).good().json();
    assert_eq!((&again["hash"], &again["steps"]), (&ran["hash"], &ran["steps"]));
}

#[test]
fn addons_of_the_program_do_not_start_by_themselves() {
    let all = run(program(), root(), &["list", "addons", "--json"], &[]).good().json();
    let names: Vec<&str> = all.as_array().unwrap().iter().map(|a| a["name"].as_str().unwrap()).collect();
    assert_eq!(
        names,
        ["auto_stop", "collision_reporter", "key_teleop", "path_tracer", "pose_logger", "profiler_report"]
    );
    for addon in all.as_array().unwrap() {
        assert_eq!(addon["auto_start"], false, "{addon}");
        assert!(addon["text"].as_str().unwrap().len() > 20, "the first line must describe the add-on: {addon}");
    }
    let done = run(program(), root(), &["run", "scenes/first/pioneer_avoids_walls.toml", "--steps", "2"], &[]).good();
    assert!(!done.err.contains("add-on"), "{}", done.err);
}

/// Runs the scene in `place` with one of the add-ons that come with the program.
fn shipped(place: &TestFolder, name: &str, options: &str, args: &[&str]) -> RunOutput {
    let file = root().join("addons").join(format!("{name}.lua"));
    let addon = format!("{}:{options}", file.display());
    place.run(&[&["--addon", addon.as_str()], args].concat())
}

/// With wheels of 0.0975 m at 2 rad/s, the Pioneer drives at 0.195 m/s (see its README). After 2 s it has driven about
/// 0.38 m, slightly less than 0.39 m because it accelerates first.
#[test]
fn the_pose_logger_writes_the_poses_of_the_trace() {
    let place = place(&[]);
    let args = ["--seconds", "2", "--trace", "trace.jsonl", "--watch", "/Pioneer_p3dx"];
    shipped(&place, "pose_logger", "period=0.5", &args).good();
    let csv = place.read("poses.csv");
    let lines: Vec<&str> = csv.lines().collect();
    assert!(lines[0].starts_with("time_s,\"/Pioneer_p3dx x_m\",\"/Pioneer_p3dx y_m\""), "{csv}");
    let row = |i: usize| lines[i].split(',').map(|c| c.parse::<f64>().unwrap()).collect::<Vec<_>>();
    // The first row is that of the first step. The others follow every 0.5 s.
    let times: Vec<f64> = (1..lines.len()).map(|i| row(i)[0]).collect();
    assert_eq!(times[..5], [0.05, 0.5, 1.0, 1.5, 2.0], "{csv}");
    let trace = place.lines("trace.jsonl");
    let position: [f64; 3] = trace[39].object("/Pioneer_p3dx", "position");
    assert!((row(5)[1] - position[0]).abs() < 1e-6 && (row(5)[2] - position[1]).abs() < 1e-6, "{csv}");
    assert!(row(5)[1] > 0.3 && row(5)[1] < 0.4, "{csv}");
}

#[test]
fn the_collision_reporter_names_the_colliding_objects() {
    let wall = cuboid("wall", [0.1, 2.0, 0.5], [0.5, 0.0, 0.25], "respondable = true\n");
    let place = TestFolder::scene(&format!("{FLOOR}{}{wall}", pioneer(DRIVE, "")));
    let done = shipped(&place, "collision_reporter", "file=hits.csv", &["--seconds", "5"]).good();
    done.reports(&["collision_reporter: ", "/wall", "time(s)"]);
    assert!(!done.err.contains("no collisions") && !done.err.contains("/floor"), "{}", done.err);
    assert!(place.read("hits.csv").lines().nth(1).unwrap().contains("/wall"));
}

#[test]
fn keys_drive_any_robot_with_two_wheels() {
    let place = place(&[]);
    place.write("keys.txt", "0.2 up\n0.2 up\n0.2 up\n0.2 up\n2 s\n2 space\n");
    let args = ["--seconds", "3", "--keys", "keys.txt", "--trace", "trace.jsonl", "--watch", "/Pioneer_p3dx"];
    let done = shipped(&place, "key_teleop", "speed=1", &args).good();
    done.reports(&["key_teleop: drives /Pioneer_p3dx"]);
    let trace = place.lines("trace.jsonl");
    let x = |step: usize| trace[step].object::<3>("/Pioneer_p3dx", "position")[0];
    // With 4 rad/s and wheels of 0.0975 m the speed is 0.39 m/s. Afterwards the robot stands still.
    assert!(((x(35) - x(25)) / 0.5 - 0.39).abs() < 0.02, "{} m/s", (x(35) - x(25)) / 0.5);
    assert!((x(59) - x(52)).abs() < 0.002, "{}", x(59) - x(52));
}

#[test]
fn the_path_tracer_reports_the_distance_driven() {
    let place = place(&[]);
    let args = ["--seconds", "2", "--trace", "trace.jsonl", "--watch", "/Pioneer_p3dx"];
    let done = shipped(&place, "path_tracer", "", &args).good();
    let line = done.err.lines().find(|l| l.contains("path_tracer: /Pioneer_p3dx went ")).unwrap().to_owned();
    let way: f64 = line.split("went ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    // The robot drives at 0.195 m/s for 2.15 s, which includes three passes after the last step, minus the distance
    // lost during the acceleration.
    assert!(way > 0.36 && way < 0.42, "{line}");
}

#[test]
fn the_profiler_counts_what_scripts_and_sensors_used() {
    let busy = "function sysCall_actuation() local x = 0 for i = 1, 3000 do x = x + i end end";
    let place = TestFolder::scene(&format!("{FLOOR}{}", pioneer(busy, "")));
    let ran = || shipped(&place, "profiler_report", "file=use.csv", &["--seconds", "1"]).good();
    let report = |done: &RunOutput| -> Vec<String> {
        done.err.lines().filter(|l| l.contains("profiler_report: ")).map(str::to_owned).collect()
    };
    let (one, other) = (report(&ran()), report(&ran()));
    assert_eq!(one, other, "the output depends on a clock");
    assert!(one[0].contains("23 steps, 1 scripts"), "expected 20 steps and three final passes: {one:?}");
    assert!(one[1].contains("100.0 %") && one[1].contains("/Pioneer_p3dx"), "{one:?}");
    // The robot has 16 sonars with one volume each.
    assert!(one[2].contains("16 sensor(s) of kind proximity: 368 readings, 368 beams"), "{one:?}");
    assert!(place.read("use.csv").contains("sensor,\"proximity\",368,368"));
}

#[test]
fn conditions_stop_a_run() {
    let place = place(&[]);
    let steps = |options: &str| {
        let done = shipped(&place, "auto_stop", options, &["--seconds", "20"]).good();
        (done.json()["sim_time_s"].as_f64().unwrap(), done.err)
    };
    let (time, err) = steps("time=1");
    assert!(
        (time - 1.0).abs() < 1e-9 && err.contains("auto_stop: the time limit is reached at 1.00 s"),
        "{time} {err}"
    );
    // At 0.195 m/s, 0.5 m take 2.6 s.
    let (time, err) = steps("object=/Pioneer_p3dx,way=0.5");
    assert!(time > 2.5 && time < 2.8 && err.contains("the object has moved 0.5"), "{time} {err}");
    let (time, _) = steps("region=0.3,-1,1,1");
    assert!(time > 1.5 && time < 1.8, "{time}");
    let (time, _) = steps("region=-0.4,-1,0.4,1,outside=true");
    assert!(time > 2.0 && time < 2.3, "{time}");
    let wall = cuboid("wall", [0.1, 2.0, 0.5], [0.5, 0.0, 0.25], "respondable = true\n");
    let place = TestFolder::scene(&format!("{FLOOR}{}{wall}", pioneer(DRIVE, "")));
    let done = shipped(&place, "auto_stop", "hit=true", &["--seconds", "20"]).good();
    assert!(done.err.contains("touch at") && done.json()["sim_time_s"].as_f64().unwrap() < 3.0, "{}", done.err);
    // The robot pushes against the wall and does not move.
    let done = shipped(&place, "auto_stop", "still=2", &["--seconds", "60"]).good();
    assert!(done.err.contains("the object stands still"), "{}", done.err);
}

#[test]
fn with_reload_a_changed_addon_is_loaded_between_two_steps() {
    let say = |word: &str| format!("n = n or 0\nfunction sysCall_sensing() n = n + 1 print('> {word} ' .. n) end\n");
    let place = place(&[("word.lua", &say("old"))]);
    let run = RunningProgram::start(&place, ",wait_for=1", &["--json", "--reload"]);
    let mut client = run.client();
    client.stepping();
    client.step(2);
    place.write("addons/word.lua", &say("new"));
    thread::sleep(Duration::from_millis(250));
    client.step(2);
    client.ask(json!({ "request": "quit" }));
    let ended = run.end().good();
    let lines: Vec<&str> = ended.err.lines().filter(|l| l.starts_with("> ")).take(4).collect();
    // When the text of an add-on is reloaded, its global numbers keep their values.
    assert_eq!(lines, ["> old 1", "> old 2", "> new 3", "> new 4"], "{}", ended.err);
    assert!(ended.err.contains("reloaded the addon addons/word.lua (state kept)"), "{}", ended.err);
}

/// Runs the commands and files of the guide in their order.
#[test]
fn the_examples_of_the_addon_guide_work() {
    let guide = fs::read_to_string(root().join("docs/guide/write-an-addon.md")).unwrap();
    let block = |language: &str, n: usize| -> String {
        let start = format!("```{language}\n");
        guide.split(&start).nth(n + 1).and_then(|b| b.split("```").next()).expect("the guide has this block").to_owned()
    };
    let place = TestFolder::new();
    place.write("addons/hello.lua", &block("lua", 0)).write("scene.toml", &block("toml", 0));
    let listed = place.tatu(&["list", "addons"]).good().out;
    assert!(guide.contains(&listed), "the guide does not contain:\n{listed}");
    let run = |args: &[&str]| place.tatu(&[&["run", "scene.toml", "--steps", "3"], args].concat()).good().out;
    assert_eq!(run(&[]), "hello\na simulation begins\nthe first step is done\nit is over\n");
    place.write("addons/hello.lua", &format!("{}{}", block("lua", 1), block("lua", 2)));
    assert_eq!(run(&[]), "");
    assert_eq!(run(&["--addon", "hello:name=Ada,times=2"]), "hello Ada\nhello Ada\n");
    // The example of the guide that listens to events, none of which occurs here.
    place.write("addons/hello.lua", &block("lua", 3));
    assert_eq!(run(&[]), "");
}
