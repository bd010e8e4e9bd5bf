//! Tests of a plugin in safe Rust that returns different declarations at each call, reads what it is modifying, keeps
//! references to removed objects and leaves a thread running. It gets an error, or its first declaration remains in
//! effect, and it never reads memory that it does not own.

use std::fs;

use crate::kit::*;

/// Creates a scene beside the plugin.
fn place(scene: &str) -> TestFolder {
    let place = TestFolder::new();
    let file = library("tatu_testing_misbehaves_safely");
    fs::create_dir(place.path().join("mine")).unwrap();
    fs::copy(program().with_file_name("deps").join(&file), place.path().join("mine").join(&file)).unwrap();
    place.write("scene.toml", &format!("format = 1\n[scene]\nplugins = [\"mine\"]\n{scene}"));
    place
}

fn sensor(kind: &str, alias: &str) -> String {
    format!("[[object]]\nkind = \"sensor\"\nsensor = \"{kind}\"\nalias = \"{alias}\"\n")
}

#[test]
fn the_first_declaration_applies() {
    let script = "function sysCall_sensing()
        local r = tatu.read(sim.getObject('/eye'))
        assert(r.grown == 1 + sim.getSimulationTime(), tostring(r.grown))
        assert(r.rows == 2 and r.columns == 2 and #r.image == 16 and string.unpack('<f', r.image) == 3)
        assert(r.b == nil)
        local a = tatu.read(sim.getObject('/aim'))
        assert(a.rays == 3 and a.sequence > 0)
        sim.getObject('/built')
    end";
    let model = "[[model]]\nmodel = \"misbehaves_safely\"\n";
    let engine =
        "[[object]]\nkind = \"actuator\"\nactuator = \"misbehaves_safely\"\nalias = \"engine\"\nparent = \"/ball\"\n";
    let scene = sensor("misbehaves_safely", "eye")
        + &sensor("misbehaves_safely_aim", "aim")
        + &cuboid("ball", [0.1; 3], [0.0, 0.0, 2.0], "dynamic = true\nmass_kg = 1.0\n")
        + engine
        + model
        + &watcher("looker", script);
    let done = place(&scene).run(&["--steps", "5"]).good();
    assert!(!done.err.contains("warning") && !done.err.contains("error"), "{}", done.err);
}

#[test]
fn an_image_that_the_host_refuses_is_not_written_to() {
    let script = "function sysCall_init()
        local eye = sim.getObject('/eye')
        local ok, why = pcall(tatu.set, eye, 'misbehaves_safely.image', 3000000)
        assert(not ok, why)
        assert(tatu.get(eye, 'misbehaves_safely.image') == 2)
        tatu.set(eye, 'misbehaves_safely.image', 5)
    end
    function sysCall_sensing()
        local r = tatu.read(sim.getObject('/eye'))
        assert(r.rows == 5 and #r.image == 100)
    end";
    let scene = sensor("misbehaves_safely", "eye") + &watcher("looker", script);
    place(&scene).run(&["--steps", "3"]).good();
}

#[test]
fn a_reading_stays_as_it_was_when_its_sensor_measures_again_and_goes() {
    let script = "function sysCall_cleanup()
        local before = tatu.read(sim.getObject('/eye')).grown
        assert(before > 1)
        assert(misbehaves_safely.hold(sim.getObject('/eye')) == before)
        assert(not pcall(sim.getObject, '/eye'))
        print('held')
    end";
    let scene = sensor("misbehaves_safely", "eye") + &watcher("looker", script);
    place(&scene).run(&["--steps", "3"]).good().reports(&["held"]);
}

#[test]
fn a_parallel_command_changes_only_drives() {
    let script = "script = { side_by_side = true, text = '''
        function sysCall_init() self = sim.getObject('.') end
        function sysCall_actuation()
            -- In the first step they run one after the other.
            if sim.getSimulationTime() == 0 then return end
            local ok, why = pcall(misbehaves_safely.set, self)
            assert(not ok and tostring(why):find('side_by_side'), why)
        end
        ''' }\n";
    let looker = |name: &str| format!("[[object]]\nkind = \"dummy\"\nalias = \"{name}\"\n{script}");
    let scene = looker("looker") + &looker("other") + &looker("third");
    for threads in ["1", "2"] {
        place(&scene).run(&["--steps", "3", "--threads", threads]).good();
    }
}

#[test]
fn a_thread_that_outlives_its_service_is_refused() {
    let scene = format!("[[service]]\nid = \"misbehaves_safely\"\n{}", watcher("d", ""));
    place(&scene)
        .run(&["--steps", "20"])
        .good()
        .reports(&["plugin `tatu.testing.misbehaves_safely`: a thread of its own"]);
}
