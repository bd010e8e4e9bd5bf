//! Tests of the ways in which scripts for V-REP grasp: a parent that holds, and a suction pad that closes a loop.

use crate::kit::*;

/// A hand on a vertical slide, with a force sensor and a pad below it, and a cube of 0.5 kg on the floor.
const HAND: &str = r#"
[[object]]
kind = "shape"
alias = "floor"
primitive = "plane"
respondable = true
[[object]]
kind = "shape"
alias = "base"
size_m = [0.1, 0.1, 0.1]
position_m = [0, 0, 1.5]
[[object]]
kind = "joint"
alias = "slide"
parent = "base"
type = "prismatic"
mode = "dynamic"
control = "position"
max_force_n = 500
limits_m = [-1, 1]
position_m = [0, 0, -0.5]
[[object]]
kind = "shape"
alias = "hand"
parent = "slide"
size_m = [0.1, 0.1, 0.1]
dynamic = true
mass_kg = 1
respondable = true
[[object]]
kind = "force_sensor"
alias = "connector"
parent = "hand"
position_m = [0, 0, -0.05]
[[object]]
kind = "dummy"
alias = "padA"
parent = "hand"
position_m = [0, 0.0, -0.05]
[[object]]
kind = "shape"
alias = "cube"
size_m = [0.1, 0.1, 0.1]
dynamic = true
mass_kg = 0.5
respondable = true
position_m = [0, 0, 0.05]
[[object]]
kind = "dummy"
alias = "padB"
"#;

const BEGIN: &str = "
local function object(path) return sim.getObject(path) end
local function near(a, b, by) assert(math.abs(a - b) < by, a .. ' instead of ' .. b) end
local slide, cube, connector = object('/base/slide'), object('/cube'), object('/base/slide/hand/connector')
local function height() return sim.getObjectPosition(cube)[3] end
local function drive(to)
    sim.setJointTargetPosition(slide, to)
    sim.wait(3)
end
";

fn grasps(body: &str) {
    let script = format!("function sysCall_thread()\n{BEGIN}\n{body}\nprint('it is ok')\nsim.stopSimulation()\nend");
    let scene = format!("{HAND}\n{}", watcher("w", &script));
    let done = TestFolder::scene(&scene).tatu(&["run", "scene.toml", "--seconds", "30"]).good();
    assert!(done.out.contains("it is ok"), "{}{}", done.out, done.err);
}

#[test]
fn cube_is_carried_by_the_force_sensor_that_becomes_its_parent() {
    grasps(
        "drive(-0.85)
        sim.setObjectParent(cube, connector, true)
        drive(0)
        near(height(), 0.9, 1e-3)
        -- The sensor feels the weight of the cube.
        local result, force = sim.readForceSensor(connector)
        near(force[3], -0.5 * 9.81, 1e-2)
        sim.setObjectParent(cube, -1, true)
        sim.wait(1)
        near(height(), 0.05, 1e-3)",
    );
}

#[test]
fn cube_is_carried_by_a_suction_pad_while_its_dummies_are_linked() {
    grasps(
        "local pad, on_cube = object('/base/slide/hand/padA'), object('/padB')
        drive(-0.85)
        sim.setObjectPose(on_cube, sim.getObjectPose(pad))
        sim.setObjectParent(on_cube, cube, true)
        sim.setLinkDummy(pad, on_cube)
        sim.setObjectInt32Param(pad, sim.dummyintparam_link_type, sim.dummy_linktype_dynamics_loop_closure)
        drive(0)
        near(height(), 0.9, 2e-3)
        sim.setLinkDummy(pad, -1)
        sim.wait(1)
        near(height(), 0.05, 1e-3)
        assert(not pcall(sim.setObjectInt32Param, pad, sim.dummyintparam_link_type, 1))",
    );
}
