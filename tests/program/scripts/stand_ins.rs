//! Tests of scripts that run without their scene: objects of suitable kinds ("stand-ins") are created in place of those
//! that the scripts refer to.

use serde_json::{Value, json};

use crate::kit::*;

/// Runs `script.lua` with `--stand-ins` for 20 steps, and returns the summary.
#[track_caller]
fn stand_ins(text: &str, more: &[&str]) -> Value {
    let place = TestFolder::new();
    place.write("script.lua", text);
    let args = ["run", "--script", "script.lua", "--stand-ins", "--steps", "20", "--json"];
    let done = place.tatu(&[&args, more].concat());
    assert!(done.code == 0 || done.code == 1, "{}", done.err);
    // The summary is on standard output, and the lines of scripts are on standard error.
    done.json()
}

fn kind_of(summary: &Value, name: &str) -> String {
    let all = summary["stand_ins"].as_array().unwrap();
    let found = all.iter().find(|s| s["name"] == name).unwrap_or_else(|| panic!("no `{name}` among {all:?}"));
    found["kind"].as_str().unwrap().into()
}

fn kinds(summary: &Value) -> Vec<Value> {
    summary["errors"].as_array().unwrap().iter().map(|e| e["kind"].clone()).collect()
}

#[test]
fn kinds_follow_from_the_calls() {
    let done = stand_ins(
        "function sysCall_init()
            motor = sim.getObject('/robot/left[1]')
            sonar = sim.getObject('./sonar')
            box = simGetObjectHandle('box#2')
            place = sim.getObject('../place')
            force = sim.getObject('/wrist')
            slow = sim.getObject('/late')
         end
         function sysCall_actuation()
            sim.setJointTargetVelocity(motor, 1)
            sim.readProximitySensor(sonar)
            sim.addForceAndTorque(box, {0, 0, 1}, {0, 0, 0})
            sim.getObjectPosition(place, -1)
            -- Kinds that become evident later are learned as well.
            if sim.getSimulationTime() > 0.5 then sim.setJointPosition(slow, 0.1) end
         end",
        &[],
    );
    assert_eq!(kinds(&done), Vec::<Value>::new(), "{done}");
    for (name, kind) in [
        ("robot", "dummy"),
        ("left", "joint"),
        ("left#0", "joint"),
        ("sonar", "sensor"),
        ("box#2", "shape"),
        ("place", "dummy"),
        ("late", "joint"),
    ] {
        assert_eq!(kind_of(&done, name), kind, "{name}");
    }
}

#[test]
fn kinds_follow_from_the_numbers_of_parameters() {
    let done = stand_ins(
        "function sysCall_init()
            motor, box = sim.getObjectHandle('motor'), sim.getObjectHandle('box')
            eye, sonar = sim.getObjectHandle('eye'), sim.getObjectHandle('sonar')
            graph = sim.getObjectHandle('graph')
            sim.setObjectInt32Parameter(motor, 2000, 1)
            sim.setObjectInt32Parameter(box, sim.shapeintparam_respondable, 1)
            sim.getObjectFloatParameter(eye, sim.visionfloatparam_far_clipping)
            sim.getObjectInt32Parameter(sonar, sim.proxintparam_volume_type)
            stream = sim.addGraphStream(graph, 'x', 'm', 0, {1, 0, 0})
         end
         function sysCall_sensing() sim.setGraphStreamValue(graph, stream, 1) end",
        &[],
    );
    assert_eq!(kinds(&done), Vec::<Value>::new(), "{done}");
    for (name, kind) in
        [("motor", "joint"), ("box", "shape"), ("eye", "sensor"), ("sonar", "sensor"), ("graph", "graph")]
    {
        assert_eq!(kind_of(&done, name), kind, "{name}");
    }
}

#[test]
fn old_names_are_made_and_names_asked_in_passing_are_not() {
    let done = stand_ins(
        "if (sim_call_type==sim_childscriptcall_initialization) then
            motor = simGetObjectHandle('leftMotor')
            self = simGetObjectAssociatedWithScript(sim_handle_self)
            if simGetCollectionHandle('parts') < 0 then error('no collection') end
            absent = simGetObjectHandle('absent@silentError')
            if absent ~= -1 then error('it was made') end
         end
         if (sim_call_type==sim_childscriptcall_actuation) then
            if simSetJointTargetVelocity(motor, 2) ~= 1 then error('no joint') end
            if simGetObjectName(self) == nil then error('no object') end
         end",
        &[],
    );
    assert_eq!(kinds(&done), Vec::<Value>::new(), "{done}");
    assert_eq!(done["stand_ins"], json!([{ "name": "leftMotor", "kind": "joint" }]));
    let done = stand_ins(
        "function sysCall_init()
            if sim.getObject('/absent', {noError = true}) ~= -1 then error('it was made') end
         end",
        &[],
    );
    assert_eq!((kinds(&done), &done["stand_ins"]), (vec![], &json!([])));
}

#[test]
fn a_path_hangs_below_the_right_object() {
    let done = stand_ins(
        "function sysCall_init()
            local b = sim.getObject('/a/b')
            if sim.getObjectParent(b) ~= sim.getObject('/a') then error('b') end
            local own = sim.getObject('..')
            if sim.getObjectParent(sim.getObject('./c')) ~= own then error('c') end
            if sim.getObjectParent(sim.getObject(':/d/e')) ~= sim.getObject('./d') then error('e') end
            if sim.getObject('/a/b') ~= b then error('made twice') end
         end",
        &[],
    );
    assert_eq!(kinds(&done), Vec::<Value>::new(), "{done}");
}

/// Scripts often test whether a child, a parent or a parameter exists. Stand-ins for these are therefore created only
/// if a script uses one without such a test, which would be an error.
#[test]
fn parents_children_and_parameters_are_made_when_they_are_missed() {
    let asks = "function sysCall_init()
            parent = sim.getObjectParent(sim.getObject('..'))
            child = sim.getObjectChild(sim.getObject('/tree'), 0)
            speed = sim.getScriptSimulationParameter(sim.handle_self, 'speed')
            name = sim.getScriptSimulationParameter(sim.handle_self, 'name')";
    let looks = "if parent ~= -1 or child ~= -1 or speed or name then error('there is one') end end";
    assert_eq!(kinds(&stand_ins(&format!("{asks} {looks}"), &[])), Vec::<Value>::new());
    let uses = "sim.getObjectPosition(parent, -1); sim.getObjectPosition(child, -1)
            twice = 2 * speed; for word in string.gmatch(name, '%w') do end end";
    let done = stand_ins(&format!("{asks} {uses}"), &[]);
    assert_eq!(kinds(&done), Vec::<Value>::new(), "{done}");
    assert_eq!(kind_of(&done, "child"), "dummy");
}

/// A model's base controls the scripts of its parts through script parameters, as V-REP's quadricopter does.
#[test]
fn scripts_of_other_objects_are_made_when_they_are_missed() {
    let done = stand_ins(
        "if (sim_call_type==sim_childscriptcall_initialization) then
            other = simGetScriptHandle('propeller1')
            if simSetScriptSimulationParameter(sim_handle_tree, 'on', 'true') < 2 then error('not in the tree') end
            n = simGetScriptSimulationParameter(sim_handle_main_script, 'number')
            for i = 1, n do last = i end
         end
         if (sim_call_type==sim_childscriptcall_actuation) then
            if simSetScriptSimulationParameter(other, 'velocity', 5.3) ~= 1 then error('not set') end
            if math.abs(simGetScriptSimulationParameter(other, 'velocity') - 5.3) > 1e-6 then error('not there') end
            if simGetObjectName(simGetObjectAssociatedWithScript(other)) ~= 'propeller1' then error('whose?') end
         end",
        &[],
    );
    assert_eq!(kinds(&done), Vec::<Value>::new(), "{done}");
    assert_eq!(kind_of(&done, "propeller1"), "dummy");
}

#[test]
fn missing_signals_and_custom_data_are_substituted() {
    let asks = "function sysCall_init()
            angle = sim.getFloatSignal('compass')
            count = sim.getInt32Signal('count')
            data = sim.readCustomDataBlock(sim.getObject('/belt'), 'parameters')";
    let looks = "if angle or count or data then error('there is one') end end";
    assert_eq!(kinds(&stand_ins(&format!("{asks} {looks}"), &[])), Vec::<Value>::new());
    let uses =
        "print(string.format('%.1f %d', angle, count), #sim.unpackFloatTable(data) > 3, #sim.unpackTable(data)) end";
    let done = stand_ins(&format!("{asks} {uses}"), &[]);
    assert_eq!(kinds(&done), Vec::<Value>::new(), "{done}");
    // A stand-in value that only leads to a call to an unknown function is worse than no value.
    let worse = "local x = count + 1 sim.noSuchFunction() end";
    assert_eq!(kinds(&stand_ins(&format!("{asks} {worse}"), &[])), ["runtime"]);
}

#[test]
fn objects_of_a_type_registered_ones_and_models_are_made() {
    let done = stand_ins(
        "if (sim_call_type==sim_childscriptcall_initialization) then
            wheels = simGetObjectsInTree(simGetObjectAssociatedWithScript(sim_handle_self), sim_object_joint_type)
            simSetJointTargetVelocity(wheels[1], 1)
            ik = simGetIkGroupHandle('leg')
            simSetExplicitHandling(ik, 1)
            if simHandleIkGroup(ik) ~= 0 then error('ik') end
            if simHandleCollision(simGetCollisionHandle('hit')) ~= 0 then error('collision') end
            if simGetIkGroupHandle('leg') ~= ik then error('another one') end
            box = simLoadModel('models/furniture/chair.ttm')
            simSetObjectPosition(box, -1, {0, 0, 1})
            simSetGraphUserData(simGetObjectHandle('graph'), 'speed', 1)
            r, low = simGetObjectFloatParameter(simGetObjectHandle('floor1'), 17)
            if low >= 0 then error('no box') end
            simSetShapeColor('@backCompatibility1:' .. simGetObjectHandle('seat'), 'BODY', 0, {1, 0, 0})
         end",
        &[],
    );
    assert_eq!(kinds(&done), Vec::<Value>::new(), "{done}");
    for (name, kind) in
        [("child", "joint"), ("chair", "dummy"), ("graph", "graph"), ("floor1", "shape"), ("seat", "shape")]
    {
        assert_eq!(kind_of(&done, name), kind, "{name}");
    }
}

/// For vision sensors, -1 means "never handled", and a depth of 1 is at the far plane (tests/facts/script-api.md, 4).
#[test]
fn vision_sensors_are_blind_and_no_error() {
    let done = stand_ins(
        "function sysCall_init()
            eye = sim.getObject('/eye')
            local image, size = sim.getVisionSensorImg(eye)
            if #image ~= 3 * size[1] * size[2] or image:byte(1) ~= 0 then error('image') end
            local depth, size = sim.getVisionSensorDepth(eye)
            if sim.unpackFloatTable(depth)[1] ~= 1 or #depth ~= 4 * size[1] * size[2] then error('depth') end
            if sim.getVisionSensorRes(eye)[1] ~= size[1] then error('resolution') end
         end
         function sysCall_sensing()
            if sim.readVisionSensor(eye) ~= -1 then error('read') end
            local n, packet = sim.handleVisionSensor(eye)
            if n ~= 0 or #packet ~= 15 then error('handle') end
            sim.handleVisionSensor(sim.handle_all_except_explicit)
         end",
        &[],
    );
    assert_eq!(kinds(&done), Vec::<Value>::new(), "{done}");
    let old = "if sim_call_type == sim_childscriptcall_sensing then
            local image = simGetVisionSensorImage(simGetObjectHandle('eye') + sim_handleflag_greyscale, 0, 0, 2, 3)
            if #image ~= 6 then error('image') end
            local bytes, w, h = simGetVisionSensorCharImage(simGetObjectHandle('eye'))
            if #bytes ~= 3 * w * h then error('bytes') end
            if simGetVisionSensorDepthBuffer(simGetObjectHandle('eye'))[1] ~= 1 then error('depth') end
         end";
    assert_eq!(kinds(&stand_ins(old, &[])), Vec::<Value>::new());
}

/// The stages of the default main script (tests/facts/script-api.md, 1) run, including physics, so time advances.
#[test]
fn the_default_main_script_can_be_required() {
    let done = stand_ins("require('defaultMainScript')", &[]);
    assert_eq!(kinds(&done), Vec::<Value>::new(), "{done}");
    assert_eq!(done["sim_time_s"], 1.0);
    let others =
        "require('utils') include('/lua/graph_customization.lua') require('configUi') ui = ConfigUI('a', nil, nil)";
    assert_eq!(kinds(&stand_ins(others, &[])), Vec::<Value>::new());
    // A file of the user takes precedence.
    let place = TestFolder::new();
    place.write("utils.lua", "return {own = true}");
    place.write("s.lua", "function sysCall_init() if not require('utils').own then error('not mine') end end");
    let done = place.tatu(&["run", "--script", "s.lua", "--stand-ins", "--steps", "2", "--json"]).good().json();
    assert_eq!(kinds(&done), Vec::<Value>::new(), "{done}");
}

#[test]
fn unknown_functions_and_modules_are_not_substituted() {
    for (text, kind) in [
        ("simExtMyPlugin_go()", "unknown_function"),
        ("sim.noSuchFunction()", "unknown_function"),
        ("require('simIGL')", "unsupported"),
        ("require('my_own_module')", "runtime"),
        ("local x = nowhere + 1", "runtime"),
    ] {
        let done = stand_ins(&format!("function sysCall_init() {text} end"), &[]);
        assert_eq!(kinds(&done), [kind], "{text}");
    }
}

/// No stand-ins are created for names that scripts define themselves.
#[test]
fn a_script_may_use_names_of_the_library_for_its_own() {
    let done = stand_ins(
        "if (sim_call_type==sim_childscriptcall_initialization) then
            type, pcall, load, setmetatable, pairs = 1, 2, 3, 4, 5
         end
         if (sim_call_type==sim_childscriptcall_actuation) then
            firstTime = (firstTime or -1) + 1
            simSetScriptAttribute(sim_handle_self, sim_scriptattribute_executioncount, firstTime)
            if simGetScriptExecutionCount() ~= firstTime then error('count') end
            if table.maxn({1, 2}) ~= 2 then error('maxn') end
            math.randomseed(0.25)
            data = simUnpackTable(simPackTable({a = {b = {c = 1}, d = 2}, e = {f = 3}}))
            if data.a.b.c ~= 1 or data.a.d ~= 2 or data.e.f ~= 3 then error('tables') end
         end",
        &[],
    );
    assert_eq!(kinds(&done), Vec::<Value>::new(), "{done}");
}

#[test]
fn two_runs_are_equal_and_a_log_replays_without_the_script() {
    let place = TestFolder::new();
    place.write("s.lua", "function sysCall_actuation() sim.setObjectPosition(sim.getObject('/a'), -1, {1, 2, 3}) end");
    let run = |more: &[&str]| {
        let args = ["run", "--script", "s.lua", "--stand-ins", "--steps", "5", "--json"];
        place.tatu(&[&args, more].concat()).good().json()["hash"].clone()
    };
    let first = run(&["--log", "run.log"]);
    assert_eq!(run(&[]), first);
    std::fs::remove_file(place.path().join("s.lua")).unwrap();
    let replayed = place.tatu(&["run", "--replay", "run.log", "--json"]).good().json();
    assert_eq!(replayed["hash"], first);
}

/// Only main scripts can advance physics; see "A main script" in the guide.
#[test]
fn the_kind_is_found_from_the_text_or_given() {
    let main = "function sysCall_actuation() sim.handleDynamics(sim.getSimulationTimeStep()) end";
    assert_eq!(kinds(&stand_ins(main, &[])), Vec::<Value>::new());
    assert_eq!(kinds(&stand_ins(main, &["--as", "child"])), ["unsupported"]);
    // Time advances also if a main script does not handle dynamics.
    let still = "function sysCall_actuation() end";
    assert_eq!(stand_ins(still, &["--as", "main"])["sim_time_s"], 1.0);
    assert_eq!(stand_ins(still, &[])["sim_time_s"], 1.0);
    let module = "local m = {}\nfunction m.twice(x) return 2 * x end\nreturn m";
    assert_eq!(kinds(&stand_ins(module, &[])), Vec::<Value>::new());
    let addon = "function sysCall_info() return {autoStart=false} end\nfunction sysCall_init() end";
    assert_eq!(kinds(&stand_ins(addon, &[])), Vec::<Value>::new());
}

#[test]
fn arguments_without_a_scene_are_checked() {
    let place = TestFolder::scene("");
    place.write("s.lua", "");
    place.tatu(&["run", "--stand-ins"]).refused(&["--script"]);
    place.tatu(&["run", "scene.toml", "--script", "s.lua", "--stand-ins"]).refused(&["--stand-ins"]);
    place.tatu(&["run", "scene.toml", "--script", "s.lua"]).refused(&["OBJECT=FILE"]);
    place.tatu(&["run", "--script", "none.lua", "--stand-ins"]).refused(&["E105", "none.lua"]);
    place.tatu(&["run", "--script", "/a=s.lua", "--stand-ins"]).refused(&["E102", "object"]);
    place.tatu(&["run", "--script", "s.lua", "--as", "main"]).refused(&["--stand-ins"]);
    // Absolute paths of files also begin with a slash, like those of objects.
    let file = place.path().join("s.lua");
    place.tatu(&["run", "--script", file.to_str().unwrap(), "--stand-ins", "--steps", "1"]).good();
}

#[test]
fn a_run_with_a_scene_creates_no_missing_objects() {
    let place = TestFolder::new();
    let script = "simGetObjectHandle('x') simSetJointTargetVelocity(simGetObjectHandle('box'), 1)";
    place.write(
        "scene.toml",
        &format!("format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"box\"\nscript = {{ text = \"\"\"if sim_call_type == 0 then {script} end\"\"\" }}\n"),
    );
    let done = place.run(&["--steps", "2"]);
    let kinds: Vec<_> = done.errors().iter().map(|e| e["kind"].clone()).collect();
    assert_eq!(kinds, ["missing_object", "bad_argument"]);
}

#[test]
fn files_are_opened_in_the_folder_that_is_given() {
    let place = TestFolder::new();
    place.write("data/in.txt", "hello").write("outside.txt", "secret");
    place.write(
        "s.lua",
        "function sysCall_init()
            print(io.open('in.txt'):read('a'))
            io.open('out.txt', 'w'):write('written')
            for _, name in ipairs{'../outside.txt', '/etc/hostname', '../new.txt'} do
                local f, why = io.open(name, name:find('new') and 'w' or 'r')
                print(name, f, #why > 0)
            end
         end",
    );
    let args = ["run", "--script", "s.lua", "--stand-ins", "--steps", "1", "--files", "data"];
    let done = place.tatu(&args).good();
    assert_eq!(done.out.lines().next(), Some("hello"));
    for name in ["../outside.txt", "/etc/hostname", "../new.txt"] {
        assert!(done.out.contains(&format!("{name}\tnil\ttrue")), "{}", done.out);
    }
    assert_eq!(place.read("data/out.txt"), "written");
    assert!(!place.path().join("new.txt").exists());
    place.tatu(&["run", "--script", "s.lua", "--stand-ins", "--files", "none"]).refused(&["E105", "none"]);
}
