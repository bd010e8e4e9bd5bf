//! Tests of exercises in a browser, from the teacher who writes an exercise to the student who hands in a solution.

use std::process::Command;

use serde_json::Value;

use super::drive::ScenePage;
use crate::kit::*;

/// A scene with a robot, which is a box on rails with a script for the student, and a flag.
const SCENE: &str = "[[object]]\nkind = \"shape\"\nalias = \"Robot\"\nsize_m = [0.2, 0.2, 0.2]\nposition_m = [0.0, 0.0, 0.1]\n\
    script = { text = \"function sysCall_actuation()\\nend\" }\n\
    [[object]]\nkind = \"dummy\"\nalias = \"Flag\"\nposition_m = [1.0, 0.0, 0.1]\n";
const GOALS: &str = "Reach the flag: /Robot within 0.3 m of /Flag before 5 s\\nnever /Robot object.position.z > 0.5\\n\
    /Robot goes 20 m";
const SOLUTION: &str = "function sysCall_actuation()\\n local t = sim.getSimulationTime()\\n \
    sim.setObjectPosition(sim.getObject('..'), -1, {math.min(t, 1), 0, 0.1})\\nend\\n";

/// A JavaScript expression for the contents of the last zip file that the page saved, as a map of names to texts.
const ZIP_CONTENTS_JS: &str = "import('tatu/lib/zip').then(async (z) => { const out = {}; for (const f of await z.unzip(await \
    window.saved.at(-1).arrayBuffer())) out[f.name] = new TextDecoder().decode(f.bytes); return out; })";

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_teacher_writes_an_exercise_and_a_student_hands_it_in() {
    // The teacher enters the task and its goals in the page, and saves the scene.
    let mut shown = ScenePage::new(SCENE);
    shown.until_shown("Robot");
    shown.page.click_on("#exercise");
    shown.page.until("document.querySelectorAll('dialog textarea').length === 2");
    shown.page.js(&format!(
        "(() => {{ const [task, goals] = document.querySelectorAll('dialog textarea'); \
         task.value = 'Drive the robot to the flag.\\n\\nIts script is yours.'; goals.value = `{GOALS}`; }})()"
    ));
    shown.answer("Take into the scene");
    shown.page.until("document.querySelectorAll('.goals li').length === 3");
    assert_eq!(shown.page.text(".task p"), "Drive the robot to the flag.");
    // The teacher can continue to edit the scene.
    shown.ask("import('tatu/scene/edits').then((e) => e.edit('Move', [['tatu.set', of('Flag').id, 'object.position', [0.9, 0, 0.1]]]))");
    shown.page.click_on("#save");
    shown.page.until("document.getElementById('unsaved').hidden");
    let place = TestFolder::new();
    for file in ["scene.toml", "scene_files/Exercise.lua"] {
        let to = place.path().join(file);
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        std::fs::copy(shown.folder().join(file), to).unwrap();
    }
    shown.end();

    // The student can change only scripts.
    let mut shown = ScenePage::of(place, &["open", "scene.toml", "--no-browser"]);
    shown.page.js(super::panes::CAPTURE_DOWNLOADS_JS);
    shown.page.until("document.querySelectorAll('.goals li').length === 3");
    shown.page.until("document.body.classList.contains('limited')");
    let refused = shown.ask(
        "import('tatu/scene/edits').then((e) => e.edit('Move Robot', [['tatu.set', of('Robot').id, 'object.position', \
         [1, 0, 0.1]]])).then(() => 'done', (e) => e.error)",
    );
    assert!(refused.as_str().unwrap().contains("only scripts"), "{refused}");
    assert_eq!(shown.page.js("document.getElementById('add').disabled"), true);
    let saved = format!(
        "new Promise((done) => {{ const s = of('Robot').scripts[0]; net.on('script', async (m) => {{ if (m.script !== s.id) \
         return; done(await net.ask({{ type: 'save_script', script: s.id, text: \"{SOLUTION}\", version: m.version }}, '')); }}); \
         net.send({{ type: 'script', script: s.id }}); }})"
    );
    shown.ask(&saved);
    // Before a run there is nothing to hand in.
    let hand_in =
        "[...document.querySelectorAll('.pane .tools button')].find((b) => b.textContent === 'Hand in').click()";
    shown.page.js(hand_in);
    shown.page.until("document.getElementById('last-line').textContent.startsWith('There is nothing to hand in')");
    shown.page.click_on("#play");
    shown.page.until("document.querySelectorAll('.goals .reached').length === 1");
    shown.page.until("document.getElementById('time').textContent > '00:00:02'");
    shown.page.click_on("#stop");
    // When the run stops, goals with conditions that must never hold are reached, and all other open goals have failed.
    shown.page.until("document.querySelectorAll('.goals .reached').length === 2");
    shown.page.until("document.querySelectorAll('.goals .failed').length === 1");
    shown.page.until("document.getElementById('stop').classList.contains('on')");
    shown.page.js(hand_in);
    shown.page.until("document.querySelector('dialog.question input') !== null");
    shown.page.js("document.querySelector('dialog.question input').value = 'Anna Silva'");
    shown.answer("Hand in");
    shown.page.until("window.saved.length === 1");
    shown.page.until("document.getElementById('last-line').textContent.includes('_handed_in_Anna_Silva.zip is in')");
    let files: Value = shown.page.js(ZIP_CONTENTS_JS);
    let names: Vec<&String> = files.as_object().unwrap().keys().collect();
    assert_eq!(names, ["exercise.json", "film.html", "scripts/Robot.lua"]);
    let told: Value = serde_json::from_str(files["exercise.json"].as_str().unwrap()).unwrap();
    assert_eq!((&told["student"], &told["changed"]), (&"Anna Silva".into(), &"scripts".into()));
    assert_eq!(told["goals"][0]["state"], "reached");
    assert_eq!(told["goals"][1]["text"], "never /Robot object.position.z > 0.5");
    assert!(files["film.html"].as_str().unwrap().contains("id=\"recording\""));
    let folder = shown.folder().to_owned();
    let solution = folder.join("student.lua");
    std::fs::write(&solution, files["scripts/Robot.lua"].as_str().unwrap()).unwrap();

    // The teacher runs the student's script in the original scene, without a page, and gets the same result.
    let out = Command::new(env!("CARGO_BIN_EXE_tatu"))
        .current_dir(&folder)
        .args(["run", "scene.toml", "--seconds", "2", "--script", "/Robot=student.lua"])
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&out.stderr).into_owned() + &String::from_utf8_lossy(&out.stdout);
    assert!(text.contains("reached at 0.65 s: Reach the flag"), "{text}");
    assert!(text.contains("failed at") && text.contains("/Robot goes 20 m"), "{text}");
    shown.end();
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn unsaved_text_is_handed_in_under_the_suffix_of_its_language() {
    let place = TestFolder::scene(
        "[[object]]\nkind = \"dummy\"\nalias = \"brain\"\nscript = { text = \"x = 1\" }\n\
         [[object]]\nkind = \"dummy\"\nalias = \"hand\"\nscript = \"hand.py\"\n\
         [[object]]\nkind = \"dummy\"\nalias = \"Exercise\"\ndata = { \"exercise.task\" = \"Press *Play* now.\", \
         \"exercise.goals\" = \"/brain goes 0 m\", \"exercise.change\" = \"scripts\" }\n",
    );
    place.write("hand.py", "def sysCall_sensing():\n    pass\n");
    let mut shown = ScenePage::of(place, &["open", "scene.toml", "--no-browser", "--allow", "python"]);
    shown.page.js(super::panes::CAPTURE_DOWNLOADS_JS);
    shown.page.until("document.querySelector('.task em')?.textContent === 'Play'");
    shown.page.click_on("#play");
    shown.page.until("document.getElementById('time').textContent > '00:00:00.2'");
    shown.page.click_on("#stop");
    shown.page.until("document.getElementById('stop').disabled");
    let row = shown.row("brain");
    let at = shown.page.middle(&row);
    shown.page.click_at(at, 2);
    shown.page.until("document.querySelector('.cm-content')?.textContent === 'x = 1'");
    shown.page.key("End", 35);
    shown.page.enter("2");
    shown
        .page
        .js("[...document.querySelectorAll('.pane .tools button')].find((b) => b.textContent === 'Hand in').click()");
    shown.page.until("document.querySelector('dialog.question input') !== null");
    shown.answer("Hand in");
    shown.page.until("window.saved.length === 1");
    let files: Value = shown.page.js(ZIP_CONTENTS_JS);
    let names: Vec<&String> = files.as_object().unwrap().keys().collect();
    assert_eq!(names.len(), 4, "{names:?}");
    let ending_with = |ending: &str| names.iter().find(|n| n.starts_with("scripts/") && n.ends_with(ending)).copied();
    assert_eq!(files[ending_with("hand.py").unwrap()], "def sysCall_sensing():\n    pass\n");
    assert_eq!(files[ending_with(".lua").unwrap()], "x = 12");
    // The film does not show the new text.
    shown.page.until("document.getElementById('last-line').textContent.includes('is older than the text of')");
    shown.page.until("!document.getElementById('last-line').textContent.includes('hand.py')");
    shown.end();
}

/// A script that puts the robot somewhere else fails the goals that require that it does not.
#[test]
fn a_robot_that_jumps_reaches_no_goal() {
    let jump = "function sysCall_METHOD()\nlocal p = sim.getObjectPosition(sim.getObject('/Flag'), -1)\n\
        if sim.getSimulationTime() < 0.2 then sim.setObjectPosition(sim.getObject('..'), -1, {p[1], p[2], 0.14}) end\nend\n";
    for method in ["init", "actuation"] {
        let place = TestFolder::new();
        place.write("jump.lua", &jump.replace("METHOD", method));
        let scene = root().join("scenes/learn/exercise_reach_the_flag.toml");
        let run = place.tatu(&["run", scene.to_str().unwrap(), "--seconds", "1", "--script", "/Pioneer_p3dx=jump.lua"]);
        assert_eq!(run.code, 3, "{}", run.err);
        let text = run.err.clone() + &run.out;
        assert!(text.contains("failed at 0.05 s: Drive, do not jump"), "{method}: {text}");
        assert!(text.matches("failed at").count() >= 4 && !text.contains("reached at 1"), "{method}: {text}");
    }
}

/// The exercise that comes with the program contains the same script that the page adds to new exercises.
#[test]
fn the_exercise_to_try_has_the_script_of_the_page() {
    let read = |path: &str| std::fs::read_to_string(root().join(path)).unwrap();
    assert_eq!(read("scenes/learn/exercise.lua"), read("plugins/views/web/page/run/exercise.lua"));
}

#[test]
fn a_goal_that_cannot_be_read_is_named() {
    let script = std::fs::read_to_string(root().join("plugins/views/web/page/run/exercise.lua")).unwrap();
    for (goal, wanted) in [
        ("/Robot flies", "cannot be read"),
        ("Far: /Robot within 1 m of /Moon", "no object /Moon"),
        ("/Robot goes 1 m", "failed at 0.25 s: /Robot goes 1 m"),
        ("/Robot object.position.z > 0.05 for 0.1 s", "reached at"),
        ("never /Robot within 5 m of /Flag", "failed at 0.05 s"),
        ("/Robot goes 1 m if goal 1", "expected the number of an earlier goal"),
        ("/Robot goes 1 m\\nnever /Robot touches /Robot if goal 1", "failed at 0.25 s: never /Robot touches"),
        ("never /Robot object.position.z > 1\\n/Robot goes 0 m if goal 1", "reached at 0.05 s: /Robot goes 0 m"),
    ] {
        let place = TestFolder::scene(&format!(
            "{SCENE}[[object]]\nkind = \"dummy\"\nalias = \"Exercise\"\ndata = {{ \"exercise.goals\" = \"{goal}\" }}\n\
             script = \"exercise.lua\"\n"
        ));
        std::fs::write(place.path().join("exercise.lua"), &script).unwrap();
        let run = ["run", "scene.toml", "--seconds", "0.1"];
        let out = Command::new(env!("CARGO_BIN_EXE_tatu")).current_dir(place.path()).args(run).output().unwrap();
        let text = String::from_utf8_lossy(&out.stderr).into_owned() + &String::from_utf8_lossy(&out.stdout);
        assert!(text.contains(wanted), "{goal}: {text}");
    }
}
