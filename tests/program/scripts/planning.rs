//! Tests of `tatu.plan` and `simOMPL`: scripts plan paths of balls, cars and arms, which leave the scene as it was.

use crate::kit::*;

/// A ball of radius 0.1 before a wall whose end is at y = 0.2, and a car.
const WALL: &str = "
[[object]]
kind = \"shape\"
alias = \"ball\"
primitive = \"sphere\"
size_m = [0.2, 0.2, 0.2]
position_m = [-0.8, -0.5, 0.5]
[[object]]
kind = \"shape\"
alias = \"wall\"
primitive = \"box\"
size_m = [0.1, 1.2, 1.0]
position_m = [0, -0.4, 0.5]
[[object]]
kind = \"shape\"
alias = \"car\"
primitive = \"box\"
size_m = [0.3, 0.2, 0.1]
position_m = [-0.7, -0.6, 0.1]
orientation_deg = [10, 20, 90]
";

/// A Panda on the floor with a shelf before it.
const PANDA: &str = "
[[object]]
kind = \"shape\"
alias = \"floor\"
primitive = \"plane\"
respondable = true
[[model]]
model = \"panda\"
controller = false
[[object]]
kind = \"shape\"
alias = \"pillar\"
primitive = \"box\"
size_m = [0.1, 0.1, 1.0]
position_m = [0.5, 0.0, 0.5]
respondable = true
";

const BEGIN: &str = "
local function task(kind, object, low, high)
    local space = simOMPL.createStateSpace('s', simOMPL.StateSpaceType[kind], object, low, high, 1)
    local task = simOMPL.createTask('t')
    simOMPL.setStateSpace(task, {space})
    simOMPL.setAlgorithm(task, simOMPL.Algorithm.RRTConnect)
    return task, space
end
local function everything()
    local all = {}
    for _, object in ipairs(sim.getObjectsInTree(sim.handle_scene)) do
        all[#all + 1] = object
        for _, x in ipairs(sim.getObjectPose(object, -1)) do all[#all + 1] = string.format('%a', x) end
        if sim.getObjectType(object) == sim.object_joint_type then
            all[#all + 1] = string.format('%a', sim.getJointPosition(object))
        end
    end
    return table.concat(all, ' ')
end
";

/// Runs the body of an initialization in a scene, and returns what it prints.
fn prints(scene: &str, body: &str) -> String {
    let script = format!("function sysCall_init()\n{BEGIN}\n{body}\nprint('it is ok')\nend");
    let done = TestFolder::scene(&format!("{scene}\n{}", watcher("w", &script)))
        .tatu(&["run", "scene.toml", "--steps", "1"])
        .good();
    assert!(done.out.contains("it is ok"), "{}{}", done.out, done.err);
    done.out
}

#[test]
fn every_run_finds_the_same_path_and_leaves_the_scene() {
    let body = "
        local ball, wall = sim.getObject('/ball'), sim.getObject('/wall')
        local task = task('position2d', ball, {-1, -1}, {1, 1})
        simOMPL.setCollisionPairs(task, {ball, sim.handle_all})
        simOMPL.setStartState(task, simOMPL.readState(task))
        simOMPL.setGoalState(task, {0.8, -0.5})
        simOMPL.setup(task)
        local before = everything()
        local solved, path = simOMPL.compute(task, 4, -1, 200)
        assert(solved and #path >= 400 and path[#path] == -0.5)
        assert(everything() == before)
        for i = 1, #path, 2 do
            simOMPL.writeState(task, {path[i], path[i + 1]})
            assert(sim.checkCollision(ball, wall) == 0, i)
            print(string.format('%a %a', path[i], path[i + 1]))
        end";
    let scene = format!("dialect = \"4.6\"\n{WALL}");
    let (first, second) = (prints(&scene, body), prints(&scene, body));
    let path = |text: &str| text.lines().filter(|l| l.contains("0x")).map(str::to_owned).collect::<Vec<_>>();
    assert!(path(&first).len() >= 200);
    assert_eq!(path(&first), path(&second));
}

#[test]
fn names_of_algorithms_have_a_planner() {
    prints(
        &format!("dialect = \"4.6\"\n{WALL}"),
        "
        local ball, wall = sim.getObject('/ball'), sim.getObject('/wall')
        local task = task('position2d', ball, {-1, -1}, {1, 1})
        simOMPL.setCollisionPairs(task, {ball, wall})
        simOMPL.setStartState(task, {-0.8, -0.5})
        simOMPL.setGoalState(task, {0.8, -0.5})
        local count = 0
        for name, number in pairs(simOMPL.Algorithm) do
            count = count + 1
            local known, why = pcall(simOMPL.setAlgorithm, task, number)
            if name == 'pRRT' or name == 'pSBL' then
                assert(not known and why:find('not supported'))
            else
                assert(known and simOMPL.compute(task, 0.1, -1, 0) and simOMPL.hasExactSolution(task), name)
            end
        end
        assert(count == 25 and simOMPL.Algorithm.BKPIECE1 == 30003 and simOMPL.StateSpaceType.dubins == 50006)",
    );
}

#[test]
fn scripts_of_version_3_4_plan_with_a_named_function() {
    let script = "
        function isFree(state) return math.abs(state[1]) > 0.2 or state[2] > 0.3 end
        ball = simGetObjectHandle('ball')
        local space = simExtOMPL_createStateSpace('s', sim_ompl_statespacetype_position2d, ball, {-1, -1}, {1, 1}, 1)
        local task = simExtOMPL_createTask('t')
        assert(type(task) == 'number' and simExtOMPL_setStateSpace(task, {space}) == 1)
        simExtOMPL_setAlgorithm(task, sim_ompl_algorithm_RRTConnect)
        simExtOMPL_setStateValidationCallback(task, 'isFree')
        simExtOMPL_setStartState(task, {-0.8, -0.5})
        simExtOMPL_setGoalState(task, {0.8, -0.5})
        local res, path = simExtOMPL_compute(task, 4, -1, 50)
        assert(res > 0 and #path >= 100)
        for i = 1, #path, 2 do assert(math.abs(path[i]) > 0.19 or path[i + 1] > 0.29) end
        print('it is ok')";
    let script = format!("if sim_call_type == sim_childscriptcall_initialization then\n{script}\nend");
    let done = TestFolder::scene(&format!("dialect = \"3.4\"\n{WALL}\n{}", watcher("w", &script)))
        .tatu(&["run", "scene.toml", "--steps", "1"])
        .good();
    assert!(done.out.contains("it is ok"), "{}{}", done.out, done.err);
}

#[test]
fn cars_drive_around_and_stay_tilted() {
    prints(
        &format!("dialect = \"4.6\"\n{WALL}"),
        "
        local car, wall = sim.getObject('/car'), sim.getObject('/wall')
        local task, space = task('dubins', car, {-1, -1}, {1, 1})
        simOMPL.setDubinsParams(space, 0.2, false)
        simOMPL.setStateSpace(task, {space})
        simOMPL.setCollisionPairs(task, {car, wall})
        local start = simOMPL.readState(task)
        assert(math.abs(start[3] - math.rad(90)) < 1e-9, start[3])
        simOMPL.setStartState(task, start)
        simOMPL.setGoalState(task, {0.6, -0.5, math.rad(-90)})
        local solved, path = simOMPL.compute(task, 10, -1, 100)
        assert(solved and simOMPL.hasExactSolution(task))
        for i = 1, simOMPL.getPathStateCount(task, path) do
            local state = simOMPL.getPathState(task, path, i)
            simOMPL.writeState(task, state)
            assert(sim.checkCollision(car, wall) == 0)
            local p, e = sim.getObjectPosition(car, -1), sim.getObjectOrientation(car, -1)
            assert(math.abs(p[1] - state[1]) < 1e-9 and math.abs(p[3] - 0.1) < 1e-9)
            assert(math.abs(e[1] - math.rad(10)) < 1e-6 and math.abs(e[2] - math.rad(20)) < 1e-6)
            -- The car moves to where it points.
            if i > 1 then
                local last = simOMPL.getPathState(task, path, i - 1)
                local x, y = state[1] - last[1], state[2] - last[2]
                assert(x * math.cos(last[3]) + y * math.sin(last[3]) > -1e-6)
            end
        end",
    );
}

#[test]
fn mistakes_are_named_in_a_sentence() {
    prints(
        &format!("dialect = \"4.6\"\n{WALL}"),
        "
        local ball, nan, inf = sim.getObject('/ball'), 0/0, math.huge
        local task, space = task('pose3d', ball, {-1, -1, 0}, {1, 1, 1})
        local function refuses(words, f, ...)
            local done, why = pcall(f, ...)
            assert(not done and tostring(why):find(words, 1, true), words .. ': ' .. tostring(why))
        end
        local types = simOMPL.StateSpaceType
        refuses('is not a type', simOMPL.createStateSpace, 's', 7, ball, {0}, {1}, 1)
        refuses('1 numbers; expected 2', simOMPL.createStateSpace, 's', types.position2d, ball, {0}, {1, 1}, 1)
        refuses('0 numbers; expected 2', simOMPL.createStateSpace, 's', types.position2d, ball, {}, {}, 1)
        refuses('finite', simOMPL.createStateSpace, 's', types.position2d, ball, {0, nan}, {1, 1}, 1)
        refuses('finite', simOMPL.createStateSpace, 's', types.position2d, ball, {0, 0}, {1, inf}, 1)
        refuses('the lower first', simOMPL.createStateSpace, 's', types.position2d, ball, {0, 2}, {1, 1}, 1)
        refuses('weight', simOMPL.createStateSpace, 's', types.position2d, ball, {0, 0}, {1, 1}, 1, -1)
        refuses('is not a joint', simOMPL.createStateSpace, 's', types.joint_position, ball, {0}, {1}, 1)
        refuses('no object', simOMPL.createStateSpace, 's', types.position2d, 99999, {0, 0}, {1, 1}, 1)
        refuses('radius', simOMPL.setDubinsParams, space, 0, true)
        refuses('no planning task', simOMPL.setup, 'nothing_7')
        refuses('expected the handle', simOMPL.setup, {})
        refuses('table of state spaces', simOMPL.setStateSpace, task, {})
        refuses('no state space', simOMPL.setStateSpace, task, {12345})
        refuses('3 numbers; expected 7', simOMPL.setStartState, task, {0, 0, 0})
        refuses('number 2 is', simOMPL.setStartState, task, {0, nan, 0, 0, 0, 0, 1})
        refuses('no start state', simOMPL.compute, task, 1)
        simOMPL.setStartState(task, {0.8, 0, 0.5, 0, 0, 0, 1})
        refuses('no goal', simOMPL.compute, task, 1)
        refuses('table of states', simOMPL.setGoalStates, task, {})
        refuses('state 2', simOMPL.setGoalStates, task, {{0, 0, 0, 0, 0, 0, 1}, {1}})
        refuses('resolution', simOMPL.setStateValidityCheckingResolution, task, nan)
        refuses('not an algorithm', simOMPL.setAlgorithm, task, 1)
        refuses('tolerance', simOMPL.setGoal, task, ball, ball, nan)
        simOMPL.setGoalState(task, {-0.8, 0, 0.5, 0, 0, 0, 1})
        refuses('time', simOMPL.compute, task, nan)
        refuses('at most', simOMPL.compute, task, 0.1, 0.1, 1e9)
        refuses('function', simOMPL.setStateValidationCallback, task, 7)
        refuses('no state 9', simOMPL.getPathState, task, {0, 0, 0, 0, 0, 0, 1}, 9)
        refuses('a multiple of 7', simOMPL.getReversedPath, task, {0, 0})
        simOMPL.setCollisionPairs(task, {ball, 88888})
        refuses('no object', simOMPL.compute, task, 1)
        -- A function of the script that fails ends the search, with its own words.
        simOMPL.setStateValidationCallback(task, function() error('own words') end)
        refuses('own words', simOMPL.compute, task, 1)
        simOMPL.setStateValidationCallback(task, function() return simOMPL.compute(task, 1) end)
        pcall(simOMPL.compute, task, 0.01)
        simOMPL.setStateValidationCallback(task, function() return false end)
        local solved, path = simOMPL.compute(task, 1)
        assert(solved == false and #path == 0)
        local joint = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_passive, 0)
        sim.setJointInterval(joint, false, {-1, 2})
        refuses('table of joints', tatu.plan, {})
        refuses('named twice', tatu.plan, {joint, joint}, {0, 0})
        refuses('2 numbers; expected 1', tatu.plan, {joint}, {0, 0})
        refuses('number 1 is', tatu.plan, {joint}, {nan})
        refuses('there is no goal', tatu.plan, {joint})
        refuses('option tip', tatu.plan, {joint}, nil, {pose = {0, 0, 0, 0, 0, 0, 1}})
        refuses('7', tatu.plan, {joint}, nil, {tip = joint, pose = {0}})
        refuses('option checks', tatu.plan, {joint}, {0}, {checks = 0})
        refuses('option avoid', tatu.plan, {joint}, {0}, {avoid = 'all'})
        local path, reason = tatu.plan({joint}, {3})
        assert(path == nil and reason:find('beyond its limits'), reason)",
    );
}

#[test]
fn endless_functions_end_with_the_budget_of_their_script() {
    let script = format!(
        "function sysCall_init()\n{BEGIN}
        local task = task('position2d', sim.getObject('/ball'), {{-1, -1}}, {{1, 1}})
        simOMPL.setStateValidationCallback(task, function() while true do end end)
        simOMPL.setStartState(task, {{0, 0}})
        simOMPL.setGoalState(task, {{1, 1}})
        simOMPL.compute(task, 10)\nend"
    );
    let place = TestFolder::scene(&format!("dialect = \"4.6\"\n{WALL}\n{}", watcher("w", &script)));
    let done = place.run(&["--steps", "3", "--set", "scene.budget.instructions=2000000"]);
    let errors = done.errors();
    assert_eq!((errors.len(), errors[0]["code"].as_str()), (1, Some("F206")), "{errors:?}");
}

#[test]
fn panda_passes_a_pillar_to_a_pose_and_the_scene_stays() {
    prints(
        &format!("dialect = \"4.6\"\n{PANDA}"),
        "
        local joints, tip = {}, sim.getObject('/panda/flange')
        for i = 1, 7 do joints[i] = sim.getObject('/panda/panda_joint' .. i) end
        local robot = sim.getObject('/panda')
        local collection = sim.createCollection(0)
        sim.addItemToCollection(collection, sim.handle_tree, sim.getObject('/panda/panda_link2'), 0)
        local before = everything()
        local start = {1.2, 0.6, 0, -1.6, 0, 2.2, 0.8}
        local path, reason = tatu.plan(joints, nil, {
            tip = tip, pose = {0.35, -0.35, 0.4, 1, 0, 0, 0}, start = start, states = 60,
        })
        assert(path, reason)
        assert(#path >= 60 and everything() == before)
        local again = tatu.plan(joints, nil, {
            tip = tip, pose = {0.35, -0.35, 0.4, 1, 0, 0, 0}, start = start, states = 60,
        })
        for i, configuration in ipairs(again) do
            for k = 1, 7 do assert(configuration[k] == path[i][k]) end
        end
        for _, configuration in ipairs(path) do
            for i = 1, 7 do sim.setJointPosition(joints[i], configuration[i]) end
            assert(sim.checkCollision(collection, sim.getObject('/pillar')) == 0)
            assert(sim.checkCollision(collection, sim.getObject('/floor')) == 0)
        end
        local p = sim.getObjectPosition(tip, -1)
        assert(math.abs(p[1] - 0.35) < 1e-3 and math.abs(p[2] + 0.35) < 1e-3 and math.abs(p[3] - 0.4) < 1e-3)
        -- The margin is one to what stays, not between links.
        local wide = tatu.plan(joints, nil, {
            tip = tip, pose = {0.35, -0.35, 0.4, 1, 0, 0, 0}, start = start, margin = 0.02,
        })
        assert(wide)
        for _, configuration in ipairs(wide) do
            for i = 1, 7 do sim.setJointPosition(joints[i], configuration[i]) end
            local near, data = sim.checkDistance(collection, sim.getObject('/pillar'), 0.019)
            assert(near == 0, 'nearer than the margin')
        end
        -- Reasons: a goal in the pillar, a pose beyond reach, a start in the floor.
        local none, why = tatu.plan(joints, nil, {tip = tip, pose = {0.5, 0, 0.5, 1, 0, 0, 0}, start = start})
        assert(none == nil and why:find('the goal is not valid') and why:find('pillar'), why)
        none, why = tatu.plan(joints, nil, {tip = tip, pose = {2, 0, 0.5, 1, 0, 0, 0}, start = start})
        assert(none == nil and why:find('no configuration reaches the pose'), why)
        none, why = tatu.plan(joints, start, {start = {1.6, 1.6, 0, -1.7, 0, 1.6, 0}})
        assert(none == nil and why:find('the start is not valid') and why:find('floor'), why)",
    );
}

#[test]
fn grasped_objects_must_pass_too() {
    prints(
        "dialect = \"4.6\"\n",
        "
        local joint = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_passive, 0)
        sim.setJointInterval(joint, false, {-1, 2})
        local hand = sim.createPureShape(0, 8, {0.1, 0.1, 0.1}, 1)
        sim.setObjectParent(hand, joint, false)
        local rod = sim.createPureShape(0, 8, {0.8, 0.05, 0.05}, 1)
        local block = sim.createPureShape(0, 8, {0.1, 0.1, 0.1}, 1)
        sim.setObjectPosition(block, -1, {0.3, 0, 0.5})
        assert(tatu.plan({joint}, {1}, {avoid = {block}}))
        local path, reason = tatu.plan({joint}, {1}, {avoid = {block}, grasped = {rod}, checks = 5000})
        assert(path == nil and reason:find('no path was found within'), reason)",
    );
}

#[test]
fn tasks_and_their_paths_survive_a_snapshot() {
    let script = format!(
        "function sysCall_init()\n{BEGIN}
        made = task('position2d', sim.getObject('/ball'), {{-1, -1}}, {{1, 1}})
        simOMPL.setCollisionPairs(made, {{sim.getObject('/ball'), sim.getObject('/wall')}})
        simOMPL.setStartState(made, {{-0.8, -0.5}})
        simOMPL.setGoalState(made, {{0.8, -0.5}})\nend
        function sysCall_actuation()
            local solved, path = simOMPL.compute(made, 2, -1, 20)
            print(string.format('%.2f %a %a', sim.getSimulationTime(), path[9], path[10]))
        end"
    );
    let place = TestFolder::scene(&format!("dialect = \"4.6\"\n{WALL}\n{}", watcher("w", &script)));
    let whole = place.tatu(&["run", "scene.toml", "--steps", "6", "--snapshot-at", "0.15", "snap"]).good();
    let rest = place.tatu(&["run", "scene.toml", "--from", "snap", "--steps", "3"]).good();
    let paths = |text: &str| text.lines().filter(|l| l.contains("0x")).map(str::to_owned).collect::<Vec<_>>();
    let (whole, rest) = (paths(&whole.out), paths(&rest.out));
    assert!(rest.len() >= 3 && rest.iter().all(|line| whole.contains(line)), "{whole:?}\n{rest:?}");
}
