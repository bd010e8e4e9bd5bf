-- Carries a small cube from the dummy `pick` to the dummy `place`, and back, in an endless loop. The joints are the
-- only input, so the cube itself is not observed: the width at which the fingers close shows whether they hold it.
--
-- For other scripts, the controller writes custom data of arm_link_0: `state` is "moving" or "resting"; `part` is the
-- position at which the cube was put down, "pick" or "place", or "none" if the last attempt found no cube.

local SPEED = 1.2           -- rad/s, maximum speed of a joint; the motors reach 1.57
local LIFT = 0.06           -- m, height above a part from which the gripper moves straight down
local CLIMB = 0.12          -- m/s, maximum vertical speed
local DOWN = math.pi        -- rad, pitch of the gripper that points down
local TILT = math.rad(5)    -- rad, step by which the gripper is tilted where it cannot reach a position pointing down
local STEEP = math.rad(22)  -- rad, maximum tilt from vertical at which the fingers are aligned with the base's y axis
local OPEN, CLOSED = 0.0115, 0      -- m, positions of a finger
local EMPTY = 0.0008        -- m, a finger that closes farther than this holds nothing
local GRIP_TIME = 0.6       -- s, to open or close
-- rad: gripper above the middle of the arm, pointing ahead and down
local HOME = {2.967, 0.6, -1.5, 2.9, 2.923}

function sysCall_init()
    base = sim.getObject(':')
    joints = {}
    for i = 1, 5 do joints[i] = sim.getObject(':/arm_joint_' .. i) end
    finger = sim.getObject(':/gripper_finger_joint_l')
    pick, place = sim.getObject(':/pick'), sim.getObject(':/place')
    kinematics = sim.getScript(sim.scripttype_childscript, sim.getObject(':/kinematics'))
    rest = tonumber(sim.readCustomStringData(base, 'rest')) or 1
    sim.writeCustomStringData(base, 'state', 'moving')
end

local function command(angles)
    for i, joint in ipairs(joints) do sim.setJointTargetPosition(joint, angles[i]) end
end

-- Fraction of a path after a fraction of its time, with minimum jerk; the maximum speed is 1.875 times the mean.
local function ease(t)
    return t ^ 3 * (10 - 15 * t + 6 * t ^ 2)
end

-- Calls a function with the completed fraction of the path, once per step until it is 1.
local function glide(duration, act)
    local start = sim.getSimulationTime()
    repeat
        local t = math.min(1, (sim.getSimulationTime() - start) / duration)
        act(ease(t))
        sim.step()
    until t == 1
end

-- Moves all joints to their angles, so that they arrive at the same time.
local function move(angles)
    local from, far = {}, 0
    for i, joint in ipairs(joints) do
        from[i] = sim.getJointTargetPosition(joint)
        far = math.max(far, math.abs(angles[i] - from[i]))
    end
    glide(math.max(0.3, 1.875 * far / SPEED), function(s)
        local now = {}
        for i = 1, 5 do now[i] = from[i] + s * (angles[i] - from[i]) end
        command(now)
    end)
end

-- Returns the joint angles for a position of the gripper. Pointing down, its fingers close along the base's y axis, or
-- along x if `turned`; level, across the arm.
local function solve(position, pitch, turned)
    local roll = 0
    if pitch > DOWN - STEEP then
        local heading = math.atan(position[2], position[1] - 0.024)
        roll = heading - math.pi * math.floor(heading / math.pi + 0.5)
        if turned then roll = roll + (roll > 0 and -math.pi / 2 or math.pi / 2) end
    end
    return sim.callScriptFunction('inverse', kinematics, position, pitch, roll)
end

-- Returns the steepest pitch at which the gripper reaches a position and the point above it.
local function steepest(position)
    for i = 0, 18 do
        local pitch = DOWN - i * TILT
        if solve(position, pitch) and solve({position[1], position[2], position[3] + LIFT}, pitch) then return pitch end
    end
end

-- Moves straight up or down between two heights.
local function climb(position, pitch, turned, from, to)
    glide(1.875 * math.abs(to - from) / CLIMB, function(s)
        local angles = solve({position[1], position[2], position[3] + from + s * (to - from)}, pitch, turned)
        if angles then command(angles) end
    end)
end

local function grip(target)
    sim.setJointTargetPosition(finger, target)
    sim.wait(GRIP_TIME)
end

-- Moves to a dummy, opens or closes the gripper there, and moves up again. The gripper releases a quarter turn from the
-- orientation in which it grips, so that the next grip is on the other sides, which centres the cube along both axes.
local function visit(dummy, target)
    local position = sim.getObjectPosition(dummy, base)
    local pitch = steepest(position)
    if not pitch then
        error(string.format('%s: out of reach at %.3f %.3f %.3f m in the frame of arm_link_0',
            sim.getObjectAlias(dummy), position[1], position[2], position[3]))
    end
    local turned = target == OPEN
    move(solve({position[1], position[2], position[3] + LIFT}, pitch, turned))
    climb(position, pitch, turned, LIFT, 0)
    grip(target)
    climb(position, pitch, turned, 0, LIFT)
end

-- Returns whether there was something to carry.
local function carry(from, to)
    grip(OPEN)
    visit(from, CLOSED)
    if sim.getJointPosition(finger) < EMPTY then
        grip(OPEN)
        return false
    end
    visit(to, OPEN)
    return true
end

function sysCall_thread()
    local from, to = pick, place
    move(HOME)
    while true do
        sim.writeCustomStringData(base, 'state', 'moving')
        local done = carry(from, to)
        sim.writeCustomStringData(base, 'part', done and sim.getObjectAlias(to) or 'none')
        -- If there was nothing, the other position is tried next.
        from, to = to, from
        move(HOME)
        sim.writeCustomStringData(base, 'state', 'resting')
        sim.wait(rest)
    end
end
