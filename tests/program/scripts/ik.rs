//! Tests of `simIK`: scripts of several versions solve the kinematics of arms of the scene.

use crate::kit::*;

/// A kinematic arm with links of 0.5 and 0.4 m, which turns about z, and a target.
const PLANAR_ARM: &str = "
[[object]]
kind = \"joint\"
alias = \"shoulder\"
mode = \"kinematic\"
[[object]]
kind = \"joint\"
alias = \"elbow\"
parent = \"/shoulder\"
position_m = [0.5, 0, 0]
mode = \"kinematic\"
[[object]]
kind = \"dummy\"
alias = \"tip\"
parent = \"/shoulder/elbow\"
position_m = [0.4, 0, 0]
[[object]]
kind = \"dummy\"
alias = \"target\"
position_m = [0.3, 0.6, 0]
";

/// Runs the body of an initialization in a scene, and checks that it ends with `it is ok`.
fn passes(scene: &str, body: &str) {
    ends_well(scene, &format!("function sysCall_init()\n{body}\nend"), "1");
}

/// Runs a script in a scene, and checks that it prints `it is ok`.
fn ends_well(scene: &str, script: &str, steps: &str) {
    let scene = format!("{scene}\n{}", watcher("w", script));
    let done = TestFolder::scene(&scene).tatu(&["run", "scene.toml", "--steps", steps]).good();
    assert!(done.out.contains("it is ok"), "{}{}", done.out, done.err);
}

const BEGIN: &str = "
local function object(path) return sim.getObject(path) end
local function near(a, b, by) assert(math.abs(a - b) < by, a .. ' instead of ' .. b) end
local function arm(mask)
    local env = simIK.createEnvironment()
    local group = simIK.createGroup(env)
    local element, copies, objects = simIK.addElementFromScene(
        env, group, -1, object('/tip'), object('/target'), mask)
    return env, group, element, copies, objects
end
";

#[test]
fn arm_reaches_its_target_with_the_scene() {
    let script = format!(
        "{BEGIN}
        local env, group, element, copies, objects = arm(simIK.constraint_x + simIK.constraint_y)
        simIK.setGroupCalculation(env, group, simIK.method_damped_least_squares, 0.1, 50)
        local shoulder, elbow = object('/shoulder'), object('/elbow')
        sim.setJointPosition(elbow, 0.5)
        assert(objects[copies[elbow]] == elbow)
        -- Nothing moves before the script asks for it.
        assert(simIK.getJointPosition(env, copies[elbow]) == 0)
        local result, flags, precision = simIK.handleGroup(env, group, {{syncWorlds = true}})
        assert(result == simIK.result_success and flags == 0 and precision[1] < 0.0005)
        local p = sim.getObjectPosition(object('/tip'))
        near(p[1], 0.3, 1e-3) near(p[2], 0.6, 1e-3)
        near(sim.getJointPosition(elbow), 1.470628906, 5e-3)

        -- A target that is out of reach leaves the scene as it is, unless errors are allowed.
        sim.setObjectPosition(object('/target'), {{1.2, 0.3, 0}})
        local before = sim.getJointPosition(elbow)
        simIK.setGroupCalculation(env, group, simIK.method_damped_least_squares, 1, 100)
        result, flags, precision = simIK.handleGroup(env, group, {{syncWorlds = true}})
        assert(result == simIK.result_fail and flags & simIK.calc_notwithintolerance ~= 0)
        near(precision[1], 0.336932, 1e-3)
        assert(sim.getJointPosition(elbow) == before)
        simIK.handleGroup(env, group, {{syncWorlds = true, allowError = true}})
        near(sim.getJointPosition(elbow), 0, 0.02)
        print('it is ok')"
    );
    passes(PLANAR_ARM, &script);
}

#[test]
fn scripts_of_version_4_2_solve_and_apply() {
    let script = format!(
        "{BEGIN}
        local env = simIK.createEnvironment()
        local group = simIK.createIkGroup(env)
        simIK.setIkGroupCalculation(env, group, simIK.method_pseudo_inverse, 0, 20)
        local element, copies = simIK.addIkElementFromScene(env, group, -1, object('/tip'), object('/target'), 3)
        sim.setJointPosition(object('/elbow'), 0.5)
        assert(simIK.applyIkEnvironmentToScene(env, group, true) == simIK.result_success)
        near(sim.getObjectPosition(object('/tip'))[1], 0.3, 1e-3)
        assert(simIK.computeJacobian(env, group, 0))
        local j, size = simIK.getJacobian(env, group)
        assert(#j == 4 and size[1] == 2 and size[2] == 2)
        -- The determinant of the Jacobian is l1 l2 sin(q2).
        near(simIK.getManipulability(env, group), 0.5 * 0.4 * math.sin(1.470628906), 1e-3)
        print('it is ok')"
    );
    passes(&format!("dialect = \"4.2\"\n{PLANAR_ARM}"), &script);
}

#[test]
fn frames_and_joints_are_created_and_moved() {
    let script = format!(
        "{BEGIN}
        local env = simIK.createEnvironment()
        local base = simIK.createJoint(env, simIK.jointtype_prismatic, 'slide')
        local tip = simIK.createDummy(env, 'tip')
        simIK.setObjectParent(env, tip, base)
        simIK.setJointPosition(env, base, 0.25)
        near(simIK.getObjectPose(env, tip)[3], 0.25, 1e-12)
        assert(simIK.getObjectHandle(env, 'tip') == tip and not simIK.doesObjectExist(env, 'other'))
        -- Until version 4.5, the frame to which a pose is relative came before it.
        simIK.setObjectPose(env, tip, {{0, 0, 0.1, 0, 0, 0, 1}}, base)
        near(simIK.getObjectPose(env, tip)[3], 0.1, 1e-12)
        simIK.setObjectPose(env, tip, -1, {{0, 0, 0.4, 0, 0, 0, 1}})
        near(simIK.getObjectMatrix(env, tip)[12], 0.4, 1e-12)
        local p, q, a = simIK.getObjectTransformation(env, tip, simIK.handle_world)
        near(p[3], 0.4, 1e-12) near(q[4], 1, 1e-12) near(a[1], 0, 1e-12)
        local handle, name, isJoint, kind = simIK.getObjects(env, 0)
        assert(handle == base and name == 'slide' and isJoint and kind == simIK.jointtype_prismatic)
        assert(simIK.getObjects(env, 2) == nil)
        local copy = simIK.duplicateEnvironment(env)
        simIK.eraseObject(env, tip)
        assert(not simIK.doesObjectExist(env, tip) and simIK.doesObjectExist(copy, tip))
        simIK.eraseEnvironment(copy)
        assert(not pcall(simIK.getObjects, copy, 0))
        print('it is ok')"
    );
    passes("", &script);
}

#[test]
fn configurations_are_found_within_limits() {
    let script = format!(
        "{BEGIN}
        local env, group, element, copies = arm(3)
        local joints = {{copies[object('/shoulder')], copies[object('/elbow')]}}
        for _, joint in ipairs(joints) do simIK.setJointInterval(env, joint, false, {{-math.pi, 2 * math.pi}}) end
        local found = simIK.findConfigs(env, group, joints, {{findMultiple = true}})
        assert(#found == 2)
        near(math.abs(found[1][2]), 1.470628906, 5e-3)
        near(found[1][2] + found[2][2], 0, 1e-2)
        assert(simIK.getJointPosition(env, joints[2]) == 0)
        -- A callback refuses one of the two elbows.
        local up = simIK.findConfigs(env, group, joints, {{findMultiple = true, cb = function(q) return q[2] > 0 end}})
        assert(#up == 1 and up[1][2] > 0)
        local one = simIK.findConfig(env, group, joints, 0.1, 0.5, nil, function(q, data) return q[2] * data > 0 end, -1)
        assert(one[2] < 0)
        simIK.setJointInterval(env, joints[2], false, {{-1, 2}})
        assert(simIK.findConfig(env, group, joints) == nil)
        -- With a full turn of room, there are alternatives.
        simIK.setJointInterval(env, joints[2], false, {{-2 * math.pi, 4 * math.pi}})
        simIK.setJointPosition(env, joints[2], 1)
        assert(#simIK.getAlternateConfigs(env, joints) == 4)
        print('it is ok')"
    );
    passes(PLANAR_ARM, &script);
}

#[test]
fn path_of_a_straight_motion_is_generated() {
    let script = format!(
        "{BEGIN}
        local env, group, element, copies = arm(3)
        local joints = {{copies[object('/shoulder')], copies[object('/elbow')]}}
        simIK.setJointPosition(env, joints[2], 1.0)
        local tip = copies[object('/tip')]
        local from = simIK.getObjectPose(env, tip)
        local path = simIK.generatePath(env, group, joints, tip, 11)
        assert(#path == 22)
        for i = 1, 11 do
            local q1, q2, t = path[2 * i - 1], path[2 * i], (i - 1) / 10
            local x = 0.5 * math.cos(q1) + 0.4 * math.cos(q1 + q2)
            local y = 0.5 * math.sin(q1) + 0.4 * math.sin(q1 + q2)
            near(x, from[1] + (0.3 - from[1]) * t, 1e-3)
            near(y, from[2] + (0.6 - from[2]) * t, 1e-3)
        end
        assert(#simIK.generatePath(env, group, joints, tip, 11, function(q) return q[1] < -100 end) == 0)
        print('it is ok')"
    );
    passes(PLANAR_ARM, &script);
}

/// The usual script of an arm, of version 4.5 and later, with a real arm whose joints are driven by motors.
#[test]
fn dynamic_arm_follows_its_target_in_every_direction() {
    let scene = "
[[object]]
model = \"ur5\"
alias = \"arm\"
controller = false
[[object]]
kind = \"dummy\"
alias = \"target\"
";
    let script = "
function sysCall_init()
    local tip
    for _, part in ipairs(sim.getObjectsInTree(sim.getObject('/arm'))) do
        if sim.getObjectAlias(part) == 'tool0' then tip = part end
    end
    target = sim.getObject('/target')
    sim.setObjectPose(target, sim.getObjectPose(tip))
    start = sim.getObjectPosition(target)
    env = simIK.createEnvironment()
    undamped = simIK.createGroup(env)
    simIK.setGroupCalculation(env, undamped, simIK.method_pseudo_inverse, 0, 6)
    simIK.addElementFromScene(env, undamped, sim.getObject('/arm'), tip, target, simIK.constraint_pose)
    damped = simIK.createGroup(env)
    simIK.setGroupCalculation(env, damped, simIK.method_damped_least_squares, 1, 99)
    simIK.addElementFromScene(env, damped, sim.getObject('/arm'), tip, target, simIK.constraint_pose)
    tool = tip
end
function sysCall_actuation()
    local t = sim.getSimulationTime()
    local s = math.min(t, 1)
    sim.setObjectPosition(target, {start[1] - 0.1 * s, start[2] + 0.15 * s, start[3] - 0.1 * s})
    if simIK.handleGroup(env, undamped, {syncWorlds = true}) ~= simIK.result_success then
        simIK.handleGroup(env, damped, {syncWorlds = true})
        print('the undamped group failed')
    end
end
function sysCall_sensing()
    if sim.getSimulationTime() > 2.4 and not said then
        said = true
        local a, b = sim.getObjectPosition(tool), sim.getObjectPosition(target)
        local error = math.sqrt((a[1] - b[1])^2 + (a[2] - b[2])^2 + (a[3] - b[3])^2)
        print(error < 0.002 and 'it is ok' or 'the tool is off by ' .. error)
    end
end";
    ends_well(scene, script, "60");
}

/// Groups as the importer of V-REP scenes stores them: the second one is solved if the first has failed.
fn with_groups(flags: [u8; 2]) -> String {
    let group = |name: &str, handle: i64, method: u8, iterations: u32, damping: f64, after: i64, flags: u8| {
        format!(
            r#"{{"name":"{name}","handle":{handle},"method":{method},"max_iterations":{iterations},"damping":{damping},"after":{after},"flags":{flags},"elements":[{{"tip":3,"target":4,"base":-1,"axes":-1,"constraints":3,"precision":[0.0005,0.0017],"weights":[1,1],"enabled":true}}]}}"#
        )
    };
    let groups = [
        group("Arm", 2_030_000, 0, 20, 0.1, -1, flags[0]),
        group("Rescue", 2_030_001, 1, 100, 1.0, 2_030_000, flags[1]),
    ];
    let mut scene = format!(
        "data = {{ \"\\u0001registered\" = '{{\"collections\":[],\"collisions\":[],\"distances\":[],\
         \"windows\":[],\"ik_joints\":[1,2],\"ik_groups\":[{}]}}' }}\n{PLANAR_ARM}",
        groups.join(",")
    );
    for (handle, alias) in ["shoulder", "elbow", "tip", "target"].iter().enumerate() {
        let line = format!("alias = \"{alias}\"\n");
        scene = scene.replace(&line, &format!("{line}data = {{ \"\\u0001handle\" = \"{}\" }}\n", handle + 1));
    }
    scene
}

#[test]
fn groups_of_old_scenes_are_solved_in_their_order() {
    // Flags of the groups: 1 enables a group, 2 restores the joint positions if the tip misses its target, and 8 solves
    // the group only if the one before it has failed.
    let scene = with_groups([1 | 2, 1 | 8]);
    let script = format!(
        "{BEGIN}
        local arm, rescue = sim.getIkGroupHandle('Arm'), sim.getIkGroupHandle('Rescue')
        local elbow = object('/elbow')
        sim.setJointPosition(elbow, 0.5)
        assert(sim.handleIkGroup(sim.handle_all_except_explicit) == 1)
        local p = sim.getObjectPosition(object('/tip'))
        near(p[1], 0.3, 1e-3) near(p[2], 0.6, 1e-3)
        -- Out of reach: the first group fails and restores, the second one stretches the arm.
        sim.setObjectPosition(object('/target'), {{1.2, 0.3, 0}})
        assert(sim.handleIkGroup(arm) == 2)
        near(sim.getJointPosition(elbow), 1.470628906, 5e-3)
        assert(sim.handleIkGroup(sim.handle_all) == 2)
        near(sim.getJointPosition(elbow), 0, 0.02)
        -- A check does not move any joint.
        sim.setObjectPosition(object('/target'), {{0.3, 0.6, 0}})
        sim.setJointPosition(elbow, 0.5)
        local result, q = sim.checkIkGroup(arm, {{object('/shoulder'), elbow}})
        assert(result == 1 and sim.getJointPosition(elbow) == 0.5)
        near(q[2], 1.470628906, 5e-3)
        sim.computeJacobian(arm, 0)
        local m, size = sim.getIkGroupMatrix(arm, 0)
        -- Rows are the joints from tip to base, and the matrix is returned column by column.
        assert(size[1] == 2 and size[2] == 2)
        near(m[1] * m[4] - m[2] * m[3], -0.5 * 0.4 * math.sin(0.5), 1e-6)
        local path = sim.generateIkPath(arm, {{object('/shoulder'), elbow}}, 5)
        assert(#path == 10)
        near(path[2], 0.5, 1e-6) near(path[10], 1.470628906, 5e-3)
        print('it is ok')"
    );
    passes(&scene, &script);
}

#[test]
fn joint_outside_of_the_ik_mode_is_a_link() {
    let scene = with_groups([1, 0]).replace("\"ik_joints\":[1,2]", "\"ik_joints\":[1]");
    let script = format!(
        "{BEGIN}
        sim.setJointPosition(object('/elbow'), 0.5)
        local result = sim.handleIkGroup(sim.getIkGroupHandle('Arm'))
        assert(result == 2 and sim.getJointPosition(object('/elbow')) == 0.5)
        print('it is ok')"
    );
    passes(&scene, &script);
}

#[test]
fn hostile_arguments_raise_errors() {
    let script = "
        local env = simIK.createEnvironment()
        local group = simIK.createGroup(env)
        local dummy = simIK.createDummy(env)
        local joint = simIK.createJoint(env, simIK.jointtype_revolute)
        local nan = 0 / 0
        for i, call in ipairs{
            function() simIK.createGroup(99) end,
            function() simIK.handleGroup(env, 99) end,
            function() simIK.handleGroup(env, {group, 99}) end,
            function() simIK.getJointPosition(env, 99) end,
            function() simIK.setJointPosition(env, joint, nan) end,
            function() simIK.setJointPosition(env, dummy, 'x') end,
            function() simIK.setJointMode(env, joint, 7) end,
            function() simIK.setJointInterval(env, joint, false, {0, -1}) end,
            function() simIK.setObjectPose(env, dummy, {1, 2}) end,
            function() simIK.setObjectPose(env, dummy, {nan, 0, 0, 0, 0, 0, 1}) end,
            function() simIK.setObjectPose(env, dummy, {0, 0, 0, 0, 0, 0, 0}) end,
            function() simIK.setObjectParent(env, joint, joint) end,
            function() simIK.setGroupCalculation(env, group, 9, 0, 1) end,
            function() simIK.setGroupCalculation(env, group, 1, -1, 1) end,
            function() simIK.setGroupCalculation(env, group, 1, 0, 1e9) end,
            function() simIK.setElementConstraints(env, group, 5, 3) end,
            function() simIK.findConfig(env, group, {joint}) end,
            function() simIK.getAlternateConfigs(env, {dummy}) end,
            function() simIK.addElementFromScene(env, group, -1, 12345, -1, 7) end,
            function() simIK.createEnvironment() local e while true do e = simIK.createEnvironment() end end,
        } do
            local good, text = pcall(call)
            assert(not good, 'call ' .. i .. ' raised no error')
        end
        -- A joint that depends on itself does not hang.
        simIK.setJointDependency(env, joint, joint)
        assert(simIK.getJointPosition(env, joint) == 0)
        print('it is ok')";
    passes("", script);
}

#[test]
fn environments_are_in_snapshots() {
    let script = "
function sysCall_init()
    env = simIK.createEnvironment()
    joint = simIK.createJoint(env, simIK.jointtype_prismatic)
    n = 0
end
function sysCall_actuation()
    n = n + 1
    simIK.setJointPosition(env, joint, n)
    print('position ' .. math.floor(simIK.getJointPosition(env, joint)))
end";
    let place = TestFolder::scene(&watcher("w", script));
    place.tatu(&["run", "scene.toml", "--steps", "3", "--snapshot-at", "0.1", "snapshot"]).good();
    let done = place.tatu(&["run", "scene.toml", "--from", "snapshot", "--steps", "1"]).good();
    assert!(done.out.contains("position 3"), "{}{}", done.out, done.err);
}

#[test]
fn modes_and_explicit_handling_decide_what_old_groups_move() {
    let script = format!(
        "{BEGIN}
        local shoulder, elbow, tip = object('/shoulder'), object('/elbow'), object('/tip')
        sim.setLinkDummy(tip, object('/target'))
        local group = simCreateIkGroup(0, {{1, 50}}, {{0.1}})
        simCreateIkElement(group, 0, {{tip, -1, -1, 3}})
        simSetJointMode(elbow, sim.jointmode_ik, 0)
        assert(sim.getJointMode(elbow) == sim.jointmode_ik)
        -- A passive joint does not move, and so the target is not reached.
        simSetJointMode(shoulder, sim.jointmode_passive, 0)
        sim.setJointPosition(elbow, 0.5)
        assert(simHandleIkGroup(group) == 2)
        assert(sim.getJointPosition(shoulder) == 0)
        simSetJointMode(shoulder, sim.jointmode_ik, 0)
        assert(simHandleIkGroup(group) == 1)
        near(sim.getObjectPosition(tip)[2], 0.6, 1e-3)
        -- An explicit group is solved only on request.
        assert(simHandleIkGroup(sim.handle_all_except_explicit) == 1)
        simSetExplicitHandling(group, 1)
        assert(simGetExplicitHandling(group) == 1)
        assert(simHandleIkGroup(sim.handle_all_except_explicit) == 0 and simHandleIkGroup(group) == 1)
        simSetExplicitHandling(group, 0)
        assert(simHandleIkGroup(sim.handle_all_except_explicit) == 1)
        -- A hybrid joint stays where it is, and its motor drives it to what is found.
        local position = sim.getJointPosition(elbow)
        sim.setJointMode(elbow, sim.jointmode_ik, 1)
        local mode, options = sim.getJointMode(elbow)
        assert(mode == sim.jointmode_ik and options == 1)
        assert(sim.getJointPosition(elbow) == position and sim.getJointTargetPosition(elbow) == position)
        assert(not pcall(sim.setJointMode, elbow, 9, 0))
        print('it is ok')"
    );
    passes(PLANAR_ARM, &script);
}
