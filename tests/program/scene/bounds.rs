//! Tests that every input refuses excessive numbers with an error, and that such numbers never hang a run.

use crate::kit::*;

#[test]
fn steps_have_bounds() {
    let place = TestFolder::scene("");
    for (set, words) in [
        ("scene.dt_s=inf", "`dt_s`: expected a number from 0.000001 to 100, found inf"),
        ("scene.dt_s=1e5", "`dt_s`: expected a number from 0.000001 to 100, found 100000"),
        ("scene.dt_s=1e300", "`dt_s`: expected a number from 0.000001 to 100"),
        ("scene.dt_s=1e-9", "`dt_s`: expected a number from 0.000001 to 100"),
        ("scene.dt_s=nan", "`dt_s`"),
        ("scene.physics_dt_s=1e-9", "`physics_dt_s`: expected a number from 0.000001 to 100"),
        ("scene.physics_dt_s=inf", "`physics_dt_s`"),
        ("scene.gravity_m_s2=[0, 0, -1e300]", "`gravity_m_s2`"),
        ("scene.physics_substeps=100000", "`physics_substeps`"),
        ("scene.seed=1e40", "`seed`"),
    ] {
        place.run(&["--set", set, "--seconds", "1"]).refused(&[words]);
        let (key, value) = set.split_once('=').unwrap();
        let key = key.strip_prefix("scene.").unwrap();
        TestFolder::scene(&format!("{key} = {value}\n")).run(&["--seconds", "1"]).refused(&[key]);
    }
    let both = ["--set", "scene.dt_s=50", "--set", "scene.physics_dt_s=0.0001", "--seconds", "100"];
    place.run(&both).refused(&["a step of 50 s would have 500000 physics steps of 0.0001 s", "at most 100000"]);
}

/// The memory for readings and images of all sensors together is limited, including copies of sensors and changed
/// parameters.
#[test]
fn sensors_have_a_bound_of_memory_together() {
    let camera = "[[object]]\nkind = \"sensor\"\nsensor = \"depth_camera\"\nalias = \"cam\"\n";
    let place = TestFolder::scene(&format!("{camera}columns = 8192\nrows = 8192\npoints = true\nincidence = true\n"));
    // 67 million pixels with 48 bytes each while they are rendered, and readings of at least 4 bytes a pixel.
    place.run(&["--steps", "1"]).refused(&["E402", "/cam", "the limit is 4096 MB", "use fewer pixels or sensors"]);
    // 5,000 images of 640 x 480 pixels would need 74 GB while they are rendered.
    let scene = format!(
        "{camera}columns = 640\nrows = 480\n{}",
        watcher(
            "d",
            "function sysCall_init()
            local cam, made = sim.getObject('/cam'), 0
            local ok, why
            repeat
                ok, why = pcall(sim.copyPasteObjects, {cam}, 0)
                made = made + 1
            until not ok or made == 5000
            print('told', made < 5000, why)
        end"
        )
    );
    // The machine may have less free memory than the limit.
    let done = TestFolder::scene(&scene).run(&["--steps", "1", "--set", "/cam.explicit=true"]);
    done.reports(&["told\ttrue", "use fewer pixels or sensors"]);
}

/// The number of values is checked before memory for them is allocated.
#[test]
fn values_of_a_call_have_a_bound() {
    let script = "function sysCall_init()
            local data = ('x'):rep(64 << 20)
            for _, unpack in ipairs({sim.unpackUInt8Table, sim.unpackTable}) do
                local ok, why = pcall(unpack, data)
                assert(not ok and why:find('exceed the limit of 256 MB'), why)
            end
            assert(#sim.unpackUInt8Table(data, 0, 1000000) == 1000000)
            print('done')
        end";
    TestFolder::scene(&watcher("d", script)).run(&["--steps", "1"]).good().reports(&["done"]);
}

#[test]
fn drives_survive_extreme_targets() {
    let joint = "[[object]]\nkind = \"shape\"\nalias = \"base\"\n[[object]]\nkind = \"joint\"\nalias = \"j\"\nparent = \"/base\"\ncontrol = \"velocity\"\nmax_force_nm = 1.0\n\
                 [[object]]\nkind = \"shape\"\nalias = \"w\"\nparent = \"/base/j\"\ndynamic = true\n";
    for line in [
        "sim.setJointTargetVelocity(j, 1e308) sim.setJointMaxForce(j, 1e308)",
        "sim.setJointTargetVelocity(j, -1e308) sim.setJointMaxForce(j, 1e3)",
        "sim.setObjectInt32Param(j, 2039, 8) sim.setJointTargetPosition(j, 1e308)",
        "sim.setObjectFloatParam(j, 2018, 1e308)",
        "sim.setObjectPosition(j, {1e308, -1e308, 1e308})",
    ] {
        let script = format!(
            "function sysCall_init() j = sim.getObject('/base/j') end\nfunction sysCall_actuation() pcall(function() {line} end) end"
        );
        let place = TestFolder::scene(&format!("{joint}{}", watcher("hand", &script)));
        let done = place.run(&["--seconds", "0.5"]);
        // The run may report a body that flies away, but the program must not crash.
        assert!(done.code <= 1 && !done.err.contains("panicked"), "{line}: exit {}\n{}", done.code, done.err);
    }
}
