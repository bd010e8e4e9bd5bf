//! Tests of the plugin templates, which are built with the system's compilers as their READMEs describe, and used from
//! Lua.

use std::fs;

use serde_json::Value;

use crate::kit::*;

/// Creates a scene that loads the C template and runs a script; `more` contains further scene entries.
fn with_c(script: &str, more: &str) -> TestFolder {
    let scene = format!("plugins = [\"template/c_command\"]\n{more}{}", watcher("caller", script));
    let place = TestFolder::scene(&scene);
    template(&place, "c_command");
    place
}

/// Returns the status lines of a run without errors, by step.
fn status_lines(place: &TestFolder, args: &[&str]) -> Vec<Vec<String>> {
    let lines = place.trace(&[], args);
    lines.iter().map(|l| l.status().iter().map(|s| s.to_string()).collect()).collect()
}

#[test]
fn c_receives_and_returns_values_of_all_kinds() {
    let script = "function sysCall_init()
        local got
        local about, n = example.describe(2, 'arm\\0\\xe9', {1, 2.5, 3}, function(sum) got = sum return {half = sum / 2, l = {1, 'x'}} end)
        assert(about.name == 'arm\\0\\xe9' and n == 3 and math.type(n) == 'integer')
        assert(#about.scaled == 3 and about.scaled[1] == 2 and about.scaled[2] == 5 and about.scaled[3] == 6)
        assert(about.sum == 6.5 and got == 6.5 and about.called.half == 3.25 and about.called.l[2] == 'x')
        about, n = example.describe(1, '', {}, function() end)
        assert(about.sum == 0 and n == 0 and #about.scaled == 0 and about.called == nil)
        -- Errors that the function raises pass through the C code.
        local ok, message = pcall(example.describe, 1, 'x', {1}, function() error('mine') end)
        assert(not ok and tostring(message):find('mine'), message)
        assert(example.count() == 1 and example.count() == 2)
    end";
    with_c(script, "").run(&["--steps", "1"]).good();
}

#[test]
fn c_stores_functions() {
    let script = "
        function sysCall_init() example.later(function() example.later(function() return 'second' end) return {'first'} end) end
        function sysCall_actuation()
            local ok, value = pcall(example.fire)
            sim.addStatusbarMessage(ok and (type(value) == 'table' and value[1] or value) or 'nothing: ' .. tostring(value))
        end";
    let told = status_lines(&with_c(script, ""), &["--steps", "3"]);
    assert_eq!((told[0][0].as_str(), told[1][0].as_str()), ("first", "second"));
    assert!(told[2][0].starts_with("nothing: ") && told[2][0].contains("there is no function to fire"), "{told:?}");
}

#[test]
fn c_checks_arguments_by_its_declaration() {
    let calls = [
        ("example.describe('much', 'arm', {1}, print)", "number"),
        ("example.describe(1, 'arm', {1, 'x'}, print)", "table"),
        ("example.describe(1, 'arm', {1}, 5)", "function"),
        ("example.describe(1, 'arm')", "table"),
        ("example.push(1, {1, 2})", "force"),
    ];
    for (call, name) in calls {
        let errors = with_c(&format!("function sysCall_init()\n{call}\nend"), "").run(&["--steps", "1"]).errors();
        let e = &errors[0];
        assert_eq!((e["kind"].as_str(), e["line"].as_u64()), (Some("bad_argument"), Some(2)), "{call}: {e}");
        assert!(e["message"].as_str().unwrap().contains(name), "{call}: the error does not name the parameter: {e}");
    }
}

#[test]
fn c_waits_for_the_next_step() {
    let script = "
        function sysCall_init()
            own = coroutine.create(function()
                for i = 1, 3 do sim.addStatusbarMessage(string.format('own %.2f', example.nextStep())) end
                return 'done'
            end)
            sim.addStatusbarMessage(tostring(pcall(example.nextStep)))
        end
        function sysCall_actuation()
            if coroutine.status(own) == 'suspended' then
                local ok, what = coroutine.resume(own)
                assert(ok, what)
                if what == 'done' then sim.addStatusbarMessage('done') end
            end
        end
        function sysCall_thread()
            for i = 1, 3 do sim.addStatusbarMessage(string.format('thread %.2f', example.nextStep())) end
        end";
    let told = status_lines(&with_c(script, ""), &["--steps", "6"]);
    let all = told.concat();
    // `init` is not a coroutine, so it cannot wait and gets an error.
    assert_eq!(all[0], "false", "{told:?}");
    for (who, step, time) in [("thread", 1, 0.05), ("thread", 2, 0.10), ("thread", 3, 0.15)] {
        assert!(told[step].contains(&format!("{who} {time:.2}")), "{who} in step {step}: {told:?}");
    }
    // A coroutine created by the script continues when the script resumes it, but not before the next step.
    let own: Vec<&String> = all.iter().filter(|t| t.starts_with("own")).collect();
    assert_eq!(own, ["own 0.05", "own 0.10", "own 0.15"], "{told:?}");
    assert_eq!(all.iter().filter(|t| *t == "done").count(), 1);
}

#[test]
fn c_fails_with_its_own_error_text() {
    let caught = "function sysCall_init()
        local ok, message = pcall(example.refuse, 'not today')
        assert(not ok and tostring(message):find('not today', 1, true), message)
        assert(example.count() == 1)
    end";
    with_c(caught, "").run(&["--steps", "1"]).good();

    let place = with_c("", "");
    place.write("own.lua", "function sysCall_actuation()\n    local a = 1\n    example.refuse('not today')\nend\n");
    let done = place.run(&["--steps", "3", "--script", "/caller=own.lua"]);
    let errors = done.errors();
    assert_eq!(errors.len(), 1, "{errors:?}");
    let e = &errors[0];
    assert_eq!(e["kind"], "bad_argument");
    assert_eq!((e["plugin"].as_str(), e["object"].as_str()), (Some("org.example.c_command"), Some("/caller")), "{e}");
    assert!(e["file"].as_str().unwrap().ends_with("own.lua") && e["line"] == 3, "{e}");
    assert!(e["message"].as_str().unwrap().contains("not today"), "{e}");
    done.reports(&["own.lua:3", "not today", "call example.count() instead"]);
}

/// Checks that a body of 2 kg without gravity, which `call` pushes in each step, has the velocity F t / m.
fn pushed(physics_dt: f64, call: &str, more: &str) {
    let script = format!(
        "function sysCall_init() body, force = sim.getObject('/body'), {{0.6, 0, 0.8}} end
        function sysCall_actuation() {call} end"
    );
    let body = cuboid("body", [0.2, 0.2, 0.2], [1.0, 0.0, 0.3], "dynamic = true\nrespondable = true\nmass_kg = 2.0");
    let scene = format!("gravity_m_s2 = [0.0, 0.0, 0.0]\nphysics_dt_s = {physics_dt}\n{body}{more}");
    let lines = with_c(&script, &scene).trace(&["/body"], &["--seconds", "2"]);
    let start = lines.iter().position(|l| l.object::<3>("/body", "linear_velocity")[0] != 0.0).unwrap();
    for line in &lines[start..] {
        let [x, y, z] = line.object("/body", "linear_velocity");
        let wanted = 1.0 * (line.time() - start as f64 * 0.05) / 2.0;
        let speed = f64::hypot(x, z);
        assert!(
            (speed / wanted - 1.0).abs() < 0.001,
            "{physics_dt}: {speed} m/s at {} s, {wanted} expected",
            line.time()
        );
        assert!((x / 0.6 - z / 0.8).abs() < 1e-3 * speed && y.abs() < 1e-9, "velocity not parallel to the force");
        assert!(line.object::<3>("/body", "angular_velocity").iter().all(|w| w.abs() < 1e-9), "the body rotates");
    }
}

#[test]
fn a_push_of_one_newton_does_what_it_should() {
    for physics_dt in [0.01, 0.005, 0.05] {
        pushed(physics_dt, "example.push(body, force)", "");
    }
}

#[test]
fn c_reads_a_sonar_through_another_plugin() {
    // Sonar 4 of the Pioneer detects the body 0.9 m from the robot. Before its first measurement it detects nothing.
    let robot = pioneer("function sysCall_init() end", "");
    let call = "local sonar = sim.getObject('/Pioneer_p3dx_ultrasonicSensor4')
        local pushed, seen = example.pushWhenNear(sonar, body, 1.5, force)
        local state, distance = sim.readProximitySensor(sonar)
        if not first then first = true assert(pushed == 0 and seen == nil)
        elseif sim.getSimulationTime() < 0.5 then assert(pushed == 1 and state == 1 and seen == distance, seen)
            assert(seen > 0.5 and seen < 1)
            assert(example.pushWhenNear(sonar, body, 0.1, force) == 0) end
        if pushed == 0 and sim.getSimulationTime() > 0 then example.push(body, force) end";
    pushed(0.01, call, &robot);
}

#[test]
#[cfg_attr(no_cxx, ignore = "needs a C++ compiler")]
fn cpp_receives_and_returns_values() {
    let script = "function sysCall_init()
        local about, n = examplecpp.describe(2, 'arm', {1, 2.5, 3}, function(sum) return sum / 2 end)
        assert(about.name == 'arm' and about.scaled[2] == 5 and about.sum == 6.5 and about.called == 3.25 and n == 3)
        local answers = examplecpp.map({1, 2, 3}, function(x) return x * x end)
        assert(#answers == 3 and answers[3] == 9)
        local ok, message = pcall(examplecpp.refuse, 'not today')
        assert(not ok and tostring(message):find('not today', 1, true), message)
        -- An exception passes through C++ frames, but not through the plugin interface.
        ok, message = pcall(examplecpp.map, {1}, function() error('mine') end)
        assert(not ok and tostring(message):find('mine', 1, true), message)
    end";
    let place = TestFolder::scene(&format!("plugins = [\"template/cpp_command\"]\n{}", watcher("caller", script)));
    template(&place, "cpp_command");
    place.run(&["--steps", "1"]).good();
}

#[test]
fn the_first_command_of_the_readme_works() {
    let readme = fs::read_to_string(root().join("plugin-api/README.md")).unwrap();
    let code = readme.split("```c\n").nth(1).unwrap().split("```").next().unwrap();
    let script = "function sysCall_init() assert(hello.twice(21) == 42) assert(not pcall(hello.twice)) end";
    let place = TestFolder::scene(&format!("plugins = [\".\"]\n{}", watcher("caller", script)));
    copy(&root().join("plugin-api/include"), &place.path().join("plugin-api/include"));
    place.write("hello.c", code);
    build(&readme, place.path());
    place.run(&["--steps", "1"]).good();
}

#[test]
#[cfg_attr(no_cxx, ignore = "needs a C++ compiler")]
fn lists_contain_the_plugins_found_and_their_paths() {
    let place = TestFolder::new();
    let folder = template(&place, "c_command");
    template(&place, "cpp_command");
    let path = std::env::join_paths([&folder, &place.path().join("template/cpp_command")]).unwrap();
    let list =
        |what| run(program(), place.path(), &["list", what, "--json"], &[("TATU_PLUGIN_PATH", path.to_str().unwrap())]);
    let (plugins, commands) = (list("plugins").good().json(), list("commands").good().json());
    for id in ["org.example.c_command", "org.example.cpp_command"] {
        let found = plugins.as_array().unwrap().iter().find(|p| p["id"] == id);
        let found = found.unwrap_or_else(|| panic!("{id} in {plugins}"));
        assert_eq!(found["kinds"], serde_json::json!(["command"]));
        assert!(found["path"].as_str().unwrap().contains(place.path().to_str().unwrap()));
    }
    let named = |name: &str| commands.as_array().unwrap().iter().find(|c| c["name"] == name).cloned();
    let describe = named("example.describe").unwrap();
    let keys: Vec<&Value> = describe["parameters"].as_array().unwrap().iter().map(|p| &p["name"]).collect();
    assert_eq!(keys, ["number", "text", "table", "function"]);
    assert_eq!(describe["plugin"], "org.example.c_command");
    assert!(named("examplecpp.map").is_some());
}

#[test]
fn a_rust_sensor_is_read_like_any_other() {
    // The face of the wall is 0.5057 m ahead. The sensor of the template rounds to 1 cm, and then to 10 cm.
    let place = TestFolder::scene(&format!(
        "{}[[object]]\nkind = \"sensor\"\nsensor = \"example_range\"\nalias = \"feeler\"\nstep_m = 0.01\nrange_m = 1.0\n{}",
        cuboid("wall", [1.0, 1.0, 0.2], [0.0, 0.0, 0.6057], ""),
        watcher(
            "reader",
            "local expected, n = 0.51, 0
            function sysCall_actuation()
                n = n + 1
                if n < 3 then return end
                sim.setFloatProperty(sim.getObject('/feeler'), 'example_range.step', 0.1)
                expected = 0.5
            end
            function sysCall_sensing()
                local state, distance, point, object = sim.readProximitySensor(sim.getObject('/feeler'))
                assert(state == 1 and object == sim.getObject('/wall'))
                assert(math.abs(distance - expected) < 1e-12 and math.abs(point[3] - 0.5057) < 1e-9, distance)
            end"
        )
    ));
    let file = library("tatu_template_rust_sensor");
    fs::create_dir(place.path().join("mine")).unwrap();
    fs::copy(program().with_file_name("deps").join(&file), place.path().join("mine").join(&file)).unwrap();
    let env = [("TATU_PLUGIN_PATH", "mine")];
    run(program(), place.path(), &["run", "scene.toml", "--steps", "3", "--json"], &env).good();
    let sensors = run(program(), place.path(), &["list", "sensors", "--json"], &env).good().json();
    let found = sensors.as_array().unwrap().iter().find(|s| s["id"] == "example_range").unwrap();
    assert_eq!(found["schemas"], serde_json::json!(["proximity/1"]));
    // Without its folder the scene is refused, and the error names what is missing.
    place.run(&[]).refused(&["scene.toml:", "example_range"]);
}
