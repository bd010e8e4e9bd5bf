--- sim.moveToConfig
function sysCall_thread()
    local joint = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_kinematic, 0)
    local data = sim.moveToConfig{joints = {joint}, targetPos = {0.5}, maxVel = {4}, maxAccel = {90}, maxJerk = {9000}}
    assert(data.pos[1] == 0.5)
    assert(math.abs(sim.getJointPosition(joint) - 0.5) < 1e-6)
end
--- sim.moveToPose
function sysCall_thread()
    local d = sim.createDummy(0.01)
    sim.moveToPose{object = d, targetPose = {0.2, 0, 1, 0, 0, 0, 1}, maxVel = {2, 2, 9, 2}, maxAccel = {90, 90, 90, 90},
        maxJerk = {900, 900, 900, 900}}
    assert(math.abs(sim.getObjectPosition(d)[3] - 1) < 1e-6)
end
--- sim.moveToConfig_init
local m = sim.moveToConfig_init{pos = {0}, targetPos = {1}, maxVel = {1}, maxAccel = {9}, maxJerk = {99}}
local result, data = sim.moveToConfig_step(m)
assert(result == 0 and data.pos[1] > 0 and data.pos[1] < 1)
sim.moveToConfig_cleanup(m)
-- Limits must be above 0.
local ok, e = pcall(sim.moveToConfig_init, {pos = {0}, targetPos = {1}, maxVel = {0}})
assert(not ok and tostring(e):find('`maxVel` must be a number above 0', 1, true))
--- sim.moveToConfig_step
local m = sim.moveToConfig_init{pos = {0}, targetPos = {1}, maxVel = {1}, maxAccel = {9}, maxJerk = {99}}
local result, data
repeat
    result, data = sim.moveToConfig_step(m)
until result ~= 0
assert(data.pos[1] == 1)
--- sim.moveToConfig_cleanup
local m = sim.moveToConfig_init{pos = {0}, targetPos = {1}, maxVel = {1}, maxAccel = {9}, maxJerk = {99}}
sim.moveToConfig_cleanup(m)
assert(not pcall(sim.moveToConfig_step, m))
--- sim.moveToPose_init
local m = sim.moveToPose_init{pose = {0, 0, 0, 0, 0, 0, 1}, targetPose = {0, 0, 1, 0, 0, 0, 1}, maxVel = {1, 1, 1, 1},
    maxAccel = {9, 9, 9, 9}, maxJerk = {99, 99, 99, 99}}
local result, data = sim.moveToPose_step(m)
assert(result == 0 and data.pose[3] > 0 and data.pose[3] < 1)
--- sim.moveToPose_step
local m = sim.moveToPose_init{pose = {0, 0, 0, 0, 0, 0, 1}, targetPose = {0, 0, 1, 0, 0, 0, 1}, maxVel = {1, 1, 1, 1},
    maxAccel = {9, 9, 9, 9}, maxJerk = {99, 99, 99, 99}}
local result, data
repeat
    result, data = sim.moveToPose_step(m)
until result ~= 0
assert(data.pose[3] == 1)
--- sim.moveToPose_cleanup
local m = sim.moveToPose_init{pose = {0, 0, 0, 0, 0, 0, 1}, targetPose = {0, 0, 1, 0, 0, 0, 1}, maxVel = {1, 1, 1, 1},
    maxAccel = {9, 9, 9, 9}, maxJerk = {99, 99, 99, 99}}
sim.moveToPose_cleanup(m)
assert(not pcall(sim.moveToPose_step, m))
--- sim.rmlMoveToJointPositions
function sysCall_thread()
    local joint = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_kinematic, 0)
    local result, at = sim.rmlMoveToJointPositions({joint}, -1, nil, nil, {4}, {90}, {9000}, {0.5})
    assert(result == 1 and at[1] == 0.5)
end
--- sim.rmlMoveToPosition
function sysCall_thread()
    local d = sim.createDummy(0.01)
    local result, p = sim.rmlMoveToPosition(d, -1, -1, nil, nil, {9, 9, 9, 9}, {90, 90, 90, 90}, {900, 900, 900, 900}, {0, 0, 1})
    assert(result == 1 and p[3] == 1)
end
--- sim.moveToPosition
function sysCall_thread()
    local d = sim.createDummy(0.01)
    sim.moveToPosition(d, -1, {0, 0, 0.5}, nil, 2, 0)
    assert(math.abs(sim.getObjectPosition(d)[3] - 0.5) < 1e-6)
end
--- sim.moveToObject
function sysCall_thread()
    local a, b = sim.createDummy(0.01), sim.createDummy(0.01)
    sim.setObjectPosition(b, {0, 0, 2})
    sim.moveToObject(a, b, 3, 0, 4, 0)
    assert(math.abs(sim.getObjectPosition(a)[3] - 2) < 1e-6)
end
--- sim.moveToJointPositions
function sysCall_thread()
    local joint = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_kinematic, 0)
    sim.moveToJointPositions({joint}, {0.4}, 4, 90)
    assert(math.abs(sim.getJointPosition(joint) - 0.4) < 1e-6)
end
--- sim.generateTimeOptimalTrajectory
local points, times = sim.generateTimeOptimalTrajectory({0, 0.5, 1}, {0, 0.5, 1}, {-1, 1}, {-2, 2}, 100)
assert(#points == 100 and points[100] == 1)
assert(math.abs(times[100] - 1.5) < 1e-3)       -- as a trapezoid of 1 m/s and 2 m/s^2
