-- Carries a small cube from the dummy `pick` to the dummy `place`, and back, for ever. It reads nothing but its joints,
-- and does not see the cube: what the fingers close on tells it whether it holds something.
--
-- For other scripts, it writes custom data of arm_link_0: `state` is "moving" or "resting", `part` is where it has left
-- the cube: "pick", "place", or "none" as long as it has found none.

local SPEED = 1.2           -- rad/s, greatest speed of a joint; the motors reach 1.57
local LIFT = 0.06           -- m, height from which it goes straight down to a part
local CLIMB = 0.12          -- m/s, greatest speed of going up and down
local DOWN = math.pi        -- rad, pitch of the gripper that points down
local TILT = math.rad(5)    -- rad, step in which it gives up pointing down where it cannot reach otherwise
local STEEP = math.rad(22)  -- rad, from pointing down: up to here the fingers are turned to the base's y axis
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

-- Fraction of a way after a fraction of its time, with the least jerk; its greatest speed is 1.875 times the mean.
local function ease(t)
    return t ^ 3 * (10 - 15 * t + 6 * t ^ 2)
end

-- Calls a function of the fraction of the way that is done, once per step until it is 1.
local function glide(duration, act)
    local start = sim.getSimulationTime()
    repeat
        local t = math.min(1, (sim.getSimulationTime() - start) / duration)
        act(ease(t))
        sim.step()
    until t == 1
end

-- All joints go to their angles and arrive at the same time.
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

-- Joints for a position of the gripper. Pointing down, its fingers close along the base's y axis, or if `turned` along
-- x; level, across the arm.
local function solve(position, pitch, turned)
    local roll = 0
    if pitch > DOWN - STEEP then
        local heading = math.atan(position[2], position[1] - 0.024)
        roll = heading - math.pi * math.floor(heading / math.pi + 0.5)
        if turned then roll = roll + (roll > 0 and -math.pi / 2 or math.pi / 2) end
    end
    return sim.callScriptFunction('inverse', kinematics, position, pitch, roll)
end

-- The steepest pitch at which the gripper reaches a position and the point above it.
local function steepest(position)
    for i = 0, 18 do
        local pitch = DOWN - i * TILT
        if solve(position, pitch) and solve({position[1], position[2], position[3] + LIFT}, pitch) then return pitch end
    end
end

-- Straight up or down between two heights.
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

-- Goes to a dummy, opens or closes the gripper there, and comes up again. It lets go a quarter turn from how it grips,
-- so that it takes the cube by the other sides next time, which centres it both ways.
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
        -- Where there was nothing, it looks at the other place next.
        from, to = to, from
        move(HOME)
        sim.writeCustomStringData(base, 'state', 'resting')
        sim.wait(rest)
    end
end
