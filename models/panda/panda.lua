-- The Panda's demonstration: moves to the ready pose, draws a circle with the flange, and then holds the flange still
-- while the elbow swings to both sides, which only an arm with seven axes can do.

local READY = {0, -math.pi / 4, 0, -3 * math.pi / 4, 0, math.pi / 2, math.pi / 4}      -- rad
local MAX_VELOCITY = {2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61}                    -- rad/s
local MAX_ACCELERATION = {15, 7.5, 10, 12.5, 15, 20, 20}                               -- rad/s^2
local MAX_JERK = {7500, 3750, 5000, 6250, 7500, 10000, 10000}                          -- rad/s^3
local PACE = 0.3               -- fraction of the maximum velocities and accelerations that moves use
local CIRCLE_RADIUS = 0.12     -- m
local CIRCLE_TIME = 5          -- s
local SWING = 0.6              -- rad: amplitude of joint 7, which swings the elbow
local SWING_TIME = 6           -- s

local joints, kinematics

local function scaled(values, factor)
    local out = {}
    for i, value in ipairs(values) do out[i] = factor * value end
    return out
end

local function positions()
    local q = {}
    for i, joint in ipairs(joints) do q[i] = sim.getJointPosition(joint) end
    return q
end

local function move_to(q)
    sim.moveToConfig{
        joints = joints,
        targetPos = q,
        maxVel = scaled(MAX_VELOCITY, PACE),
        maxAccel = scaled(MAX_ACCELERATION, PACE),
        maxJerk = MAX_JERK,
    }
end

-- Targets for this step: the solution nearest to the current joint angles.
local function aim(pose, q7)
    local solutions = kinematics:inverse(pose, q7, positions())
    if #solutions == 0 then
        error(string.format('the pose at %.3f %.3f %.3f m is out of reach', pose[1], pose[2], pose[3]))
    end
    for i, joint in ipairs(joints) do sim.setJointTargetPosition(joint, solutions[1][i]) end
end

-- Calls act(phase) in each step, with a phase that grows from 0 to 1 and is at rest at both ends.
local function during(seconds, act)
    local start = sim.getSimulationTime()
    local t = 0
    while t < 1 do
        t = math.min((sim.getSimulationTime() - start) / seconds, 1)
        act(t * t * t * (10 + t * (6 * t - 15)))
        sim.step()
    end
end

function sysCall_init()
    joints = {}
    for i = 1, 7 do joints[i] = sim.getObject(':/panda_joint' .. i) end
    local script = sim.getScript(sim.scripttype_simulation, sim.getObject(':/kinematics'))
    kinematics = sim.getScriptFunctions(script)
end

function sysCall_thread()
    local ready = kinematics:forward(READY)
    while true do
        move_to(READY)
        sim.wait(0.5)
        during(CIRCLE_TIME, function(phase)
            local pose, angle = sim.copyTable(ready), 2 * math.pi * phase
            pose[2] = pose[2] + CIRCLE_RADIUS * math.sin(angle)
            pose[3] = pose[3] - CIRCLE_RADIUS * (1 - math.cos(angle))
            aim(pose, READY[7])
        end)
        sim.wait(0.5)
        during(SWING_TIME, function(phase)
            aim(ready, READY[7] + SWING * math.sin(2 * math.pi * phase))
        end)
        sim.wait(0.5)
    end
end
