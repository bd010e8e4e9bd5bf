//! Tests of models with sensors and scripts that other scripts copy, load and save during a run.

use crate::kit::*;

/// A carriage with a sensor and a script that reads it.
const CARRIAGE: &str = r#"
[[object]]
kind = "dummy"
alias = "carriage"
model_base = true
position_m = [0.0, 0.0, 0.5]
[object.script]
text = '''
function sysCall_init() eye = sim.getObject('./eye') me = sim.getObject('.') end
function sysCall_sensing()
  local r, d = sim.readProximitySensor(eye)
  print(sim.getObjectAlias(me, 2) .. ' sees ' .. r .. ' ' .. string.format('%.3f', d or 0))
end
'''
[[object]]
kind = "sensor"
sensor = "proximity"
alias = "eye"
parent = "carriage"
volume = "ray"
range_m = 3.0
orientation_deg = [0.0, 90.0, 0.0]
[[object]]
kind = "shape"
alias = "wall"
position_m = [2.05, 0.0, 0.5]
size_m = [0.1, 4.0, 1.0]
"#;

fn output_text(done: &RunOutput) -> String {
    format!("{}{}", done.out, done.err)
}

#[test]
fn copies_have_working_sensors_and_scripts() {
    let script = "function sysCall_init()
          local base = sim.getObject('/carriage')
          local copy = sim.copyPasteObjects({base}, 1)[1]
          sim.setObjectPosition(copy, {1, 1, 0.5})
        end";
    let place = TestFolder::scene(&format!("{CARRIAGE}{}", watcher("maker", script)));
    let done = place.tatu(&["run", "scene.toml", "--steps", "3"]).good();
    assert!(output_text(&done).contains("/carriage[0]/script sees 1 2.000"), "{}", output_text(&done));
    assert!(output_text(&done).contains("/carriage[1]/script sees 1 1.000"), "{}", output_text(&done));
}

#[test]
fn a_model_is_loaded_removed_and_loaded_again() {
    let script = "function sysCall_init()
          model = sim.loadModel('part.toml')
          sim.setObjectPosition(model, {0.5, 0, 0.5})
          mesh = sim.loadModel('p.obj')
          assert(sim.getObjectType(mesh) == sim.object_shape_type)
        end
        function sysCall_actuation()
          local t = sim.getSimulationTime()
          if t > 0.12 and model then sim.removeModel(model) model = nil print('gone') end
          if t > 0.22 and not again then again = sim.loadModel('part.toml') print('back') end
        end";
    let place = TestFolder::scene(&watcher("maker", script));
    place.write("part.toml", &format!("format = 1\n{CARRIAGE}")).write("p.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let done = place.tatu(&["run", "scene.toml", "--steps", "9", "--threads", "2"]).good();
    let text = output_text(&done);
    let sees = text.matches("carriage/script sees 1 1.500").count();
    assert!((2..=4).contains(&sees) && text.contains("gone") && text.contains("back"), "{text}");
    assert!(text.matches("carriage/script sees 1 2.000").count() >= 2, "{text}");
    // The runs are bit-identical.
    let hash = |threads: &str| place.run(&["--steps", "9", "--threads", threads]).good().json()["hash"].clone();
    assert_eq!(hash("1"), hash("2"));
}

#[test]
fn models_and_scenes_saved_by_a_script_are_loaded() {
    let script = "function sysCall_init()
          local base = sim.getObject('/carriage')
          sim.setObjectPosition(base, {0.25, 0, 0.5})
          assert(sim.saveModel(base, 'made.ttm') == 1)
          assert(sim.saveScene('all.toml') == 1)
          local again = sim.loadModel('made.ttm')
          sim.setObjectPosition(again, {1.5, 0.3, 0.5})
        end";
    let place = TestFolder::scene(&format!("{CARRIAGE}{}", watcher("maker", script)));
    let done = place.tatu(&["run", "scene.toml", "--steps", "2"]).good();
    assert!(output_text(&done).contains("/carriage[1]/script sees 1 0.500"), "{}", output_text(&done));
    let saved = place.read("made.ttm.toml");
    assert!(
        saved.contains("position_m = [0.25, 0.0, 0.5]") && saved.contains("made.ttm_files/carriage.lua"),
        "{saved}"
    );
    place.tatu(&["check", "made.ttm.toml"]).good();
    place.tatu(&["check", "all.toml"]).good();
}

#[test]
fn models_that_cannot_be_loaded_raise_an_error() {
    let tries = |text: &str| {
        format!("function sysCall_init() local ok, e = pcall(function() {text} end) print('> ' .. tostring(e)) end")
    };
    for (text, words) in [
        ("sim.loadModel('missing.ttm')", "missing.ttm"),
        ("sim.loadModel('bad.toml')", "unknown key `what`"),
        ("sim.loadModel('../outside.toml')", "outside.toml"),
        ("sim.saveScene('../outside.toml')", "outside.toml"),
    ] {
        let place = TestFolder::scene(&watcher("maker", &tries(text)));
        place.write("bad.toml", "format = 1\nwhat = 1\n");
        let done = place.tatu(&["run", "scene.toml", "--steps", "1"]).good();
        assert!(output_text(&done).contains(words), "{text}: {}", output_text(&done));
    }
}

#[test]
fn a_run_is_saved_as_it_is() {
    let place = TestFolder::scene(&format!(
        "{FLOOR}{}",
        cuboid("box", [0.2; 3], [0.0, 0.0, 1.0], "dynamic = true\nrespondable = true")
    ));
    place.run(&["--seconds", "3", "--save", "end.toml"]).good();
    let saved = place.read("end.toml");
    assert!(saved.contains("alias = \"box\""), "{saved}");
    // The saved box has come to rest and remains at its position.
    let end = place.tatu(&["run", "end.toml", "--seconds", "1", "--trace", "t", "--watch", "/box", "--json"]).good();
    assert_eq!(end.code, 0);
    let z = place.lines("t").last().unwrap().object::<3>("/box", "position")[2];
    assert!((z - 0.1).abs() < 1e-3, "{z}");
    place.run(&["--save", "end.txt"]).refused(&["error[E105]", ".toml"]);
}
