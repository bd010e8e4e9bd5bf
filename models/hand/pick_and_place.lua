-- A Panda with the Franka hand carries a cube from one board to the other, in an endless loop. The positions of the
-- boards are constants; the distance of the fingers shows whether the hand holds the cube.

local PLACES = {{0.45, -0.25}, {0.45, 0.25}}      -- m, in the frame of the arm's base: middles of the boards
local TABLE = 0.02                                -- m: height of the boards
local CUBE = 0.05                                 -- m: edge of the cube
local ABOVE = 0.15                                -- m: clearance above the cube
local TCP = 0.1034                                -- m: from the flange to the tool centre
local OPEN = 0.04                                 -- m: position of a finger
local MAX_VELOCITY = {2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61}      -- rad/s
local MAX_ACCELERATION = {15, 7.5, 10, 12.5, 15, 20, 20}                 -- rad/s^2
local MAX_JERK = {7500, 3750, 5000, 6250, 7500, 10000, 10000}            -- rad/s^3
local PACE = 0.25              -- fraction of the maximum velocities and accelerations that moves use
local DESCENT = 1.2            -- s: time of a straight move down or up

local joints, finger, kinematics

local function scaled(values)
    local out = {}
    for i, value in ipairs(values) do out[i] = PACE * value end
    return out
end

local function positions()
    local q = {}
    for i, joint in ipairs(joints) do q[i] = sim.getJointPosition(joint) end
    return q
end

-- Returns the joint angles for a hand that points down, with its tool centre at x, y, z and the line of its fingers
-- rotated by `yaw` from the y axis.
local function solve(x, y, z, yaw)
    -- The flange is rotated by 45 degrees relative to the hand.
    local half = yaw / 2 - math.pi / 8
    local pose = {x, y, z + TCP, math.cos(half), math.sin(half), 0, 0}
    -- The elbow stays in the vertical plane through the target if joint 7 compensates for bearing and yaw.
    local q7 = math.pi / 4 + math.atan(y, x) - yaw
    local solutions = kinematics:inverse(pose, q7, positions())
    if #solutions == 0 then error(string.format('the place at %.3f %.3f %.3f m is out of reach', x, y, z)) end
    return solutions[1]
end

local function move(x, y, z, yaw)
    sim.moveToConfig{
        joints = joints,
        targetPos = solve(x, y, z, yaw),
        maxVel = scaled(MAX_VELOCITY),
        maxAccel = scaled(MAX_ACCELERATION),
        maxJerk = MAX_JERK,
    }
    sim.wait(0.2)
end

-- Moves along z in a straight line, at rest at both ends.
local function lift(x, y, from, to, yaw)
    local start, t = sim.getSimulationTime(), 0
    while t < 1 do
        t = math.min((sim.getSimulationTime() - start) / DESCENT, 1)
        local q = solve(x, y, from + (to - from) * t * t * (3 - 2 * t), yaw)
        for i, joint in ipairs(joints) do sim.setJointTargetPosition(joint, q[i]) end
        sim.step()
    end
    sim.wait(0.2)
end

local function grip(position)
    sim.setJointTargetPosition(finger, position)
    sim.wait(0.6)
end

function sysCall_init()
    joints = {}
    for i = 1, 7 do joints[i] = sim.getObject(':/panda_joint' .. i) end
    finger = sim.getObject(':/flange/hand/panda_finger_joint1')
    kinematics = sim.getScriptFunctions(sim.getScript(sim.scripttype_simulation, sim.getObject(':/kinematics')))
end

function sysCall_thread()
    local low, high = TABLE + CUBE / 2, TABLE + CUBE / 2 + ABOVE
    local turn = 0
    while true do
        -- The fingers centre the cube along their line. Grips along y and along x alternate, so no error accumulates.
        local yaw = turn % 2 == 0 and 0 or math.pi / 2
        local from, to = PLACES[1 + turn % 2], PLACES[2 - turn % 2]
        grip(OPEN)
        move(from[1], from[2], high, yaw)
        lift(from[1], from[2], high, low, yaw)
        grip(0)
        local width = 2 * sim.getJointPosition(finger)
        if math.abs(width - CUBE) > 0.005 then
            error(string.format('the fingers have closed to %.4f m, expected a cube of %.4f m', width, CUBE))
        end
        lift(from[1], from[2], low, high, yaw)
        move(to[1], to[2], high, yaw)
        -- 1 mm higher, so that the cube drops onto the board instead of being pressed into it.
        lift(to[1], to[2], high, low + 0.001, yaw)
        grip(OPEN)
        lift(to[1], to[2], low + 0.001, high, yaw)
        turn = turn + 1
    end
end
