-- The demonstration of the arm: draws a circle with the tool, or, with a gripper at the flange, moves objects from one
-- row of positions to another and back.
--
-- Its only input is the joint angles. Poses are those of the flange in the frame of the foot, as 12 numbers; the script
-- of the object `kinematics` converts between poses and joint angles.

local JOINT_SPEED = 1.05           -- movements of the joints: maximum speed, rad/s
local JOINT_ACCELERATION = 1.4     -- movements of the joints: maximum acceleration, rad/s^2
local TOOL_SPEED = 0.25            -- straight movements: maximum speed, m/s
local TOOL_ACCELERATION = 1.2      -- straight movements: maximum acceleration, m/s^2

local HOME = {0, -math.pi / 2, math.pi / 2, -math.pi / 2, -math.pi / 2, 0}    -- tool down, rad

local CIRCLE_CENTRE = {0.45, 0.11, 0.30}    -- m
local CIRCLE_RADIUS = 0.12                  -- m
local CIRCLE_PERIOD = 6                     -- s

-- Positions of objects in the frame of the foot: x, y and z of their middle (m), and the rotation of the gripper about
-- the vertical (rad). The two rows are gripped in perpendicular directions, so that each grip corrects the offset of
-- the last.
local ROW_A = {{0.36, 0.30, 0.025, 0}, {0.46, 0.30, 0.025, 0}, {0.56, 0.30, 0.025, 0}}
local ROW_B = {{0.45, -0.14, 0.025, math.pi / 2}, {0.45, -0.25, 0.025, math.pi / 2}, {0.45, -0.36, 0.025, math.pi / 2}}
local CLEARANCE = 0.12                                                                -- height of approach, m
local GRIP_TIME = 0.8                                                                 -- s
local EMPTY = 0.05                 -- the gripper is empty if it comes this close to its closed angle, rad

local joints, kinematics, gripper

local function call(name, ...)
    return sim.callScriptFunction(name, kinematics, ...)
end

local function angles()
    local q = {}
    for i, joint in ipairs(joints) do q[i] = sim.getJointPosition(joint) end
    return q
end

local function command(q)
    for i, joint in ipairs(joints) do sim.setJointTargetPosition(joint, q[i]) end
end

-- Returns the duration of a smooth movement over a distance. Its `progress` is a polynomial of the fifth degree, with a
-- maximum speed of 1.875 and a maximum acceleration of 5.774 in units of distance and duration.
local function duration(distance, speed, acceleration)
    return math.max(1.875 * distance / speed, math.sqrt(5.774 * distance / acceleration), 0.1)
end

local function progress(part)
    return part * part * part * (10 + part * (6 * part - 15))
end

-- Calls a function with the progress of a movement, 0 to 1, once a step.
local function during(seconds, act)
    local start = sim.getSimulationTime()
    local part = 0
    while part < 1 do
        part = math.min(1, (sim.getSimulationTime() - start + sim.getSimulationTimeStep()) / seconds)
        act(progress(part))
        sim.step()
    end
end

-- Moves all joints to given angles, so that they arrive together.
local function move_joints(goal)
    local from, farthest = angles(), 0
    for i = 1, 6 do farthest = math.max(farthest, math.abs(goal[i] - from[i])) end
    during(duration(farthest, JOINT_SPEED, JOINT_ACCELERATION), function(s)
        local q = {}
        for i = 1, 6 do q[i] = from[i] + s * (goal[i] - from[i]) end
        command(q)
    end)
end

-- Returns the pose at a position, with the tool down as at home, rotated about the vertical.
local function tool_down(position, turn)
    local home, c, s = call('forward', HOME), math.cos(turn or 0), math.sin(turn or 0)
    local pose = {}
    for i = 1, 3 do
        pose[i] = c * home[i] - s * home[i + 4]
        pose[i + 4] = s * home[i] + c * home[i + 4]
        pose[i + 8] = home[i + 8]
    end
    pose[4], pose[8], pose[12] = position[1], position[2], position[3]
    return pose
end

-- Returns the joint angles for a pose that are nearest to given ones.
local function solve(pose, near)
    return call('nearest', pose, near)
        or error(string.format('flange at %.3f %.3f %.3f m: out of reach', pose[4], pose[8], pose[12]))
end

-- Moves the flange in a straight line, tool down.
local function move_straight(from, to, turn)
    local q = angles()
    local distance = math.sqrt((to[1] - from[1]) ^ 2 + (to[2] - from[2]) ^ 2 + (to[3] - from[3]) ^ 2)
    during(duration(distance, TOOL_SPEED, TOOL_ACCELERATION), function(s)
        local point = {}
        for i = 1, 3 do point[i] = from[i] + s * (to[i] - from[i]) end
        q = solve(tool_down(point, turn), q)
        command(q)
    end)
end

local function draw_circles()
    local function point(turn)
        return {CIRCLE_CENTRE[1] + CIRCLE_RADIUS * math.cos(turn), CIRCLE_CENTRE[2] + CIRCLE_RADIUS * math.sin(turn),
            CIRCLE_CENTRE[3]}
    end
    local q = solve(tool_down(point(0)), HOME)
    move_joints(q)
    local start = sim.getSimulationTime()
    while true do
        local time = sim.getSimulationTime() - start
        -- Within the first turn the speed rises smoothly.
        local turns = time < CIRCLE_PERIOD and time ^ 2 / CIRCLE_PERIOD ^ 2 / 2 or time / CIRCLE_PERIOD - 0.5
        q = solve(tool_down(point(2 * math.pi * turns)), q)
        command(q)
        sim.step()
    end
end

-- Returns the gripper below the flange, if there is one: its driven joint is the first that follows no other. `reach`
-- is the distance of its frame `tcp` from the flange.
local function find_gripper()
    local flange = sim.getObject(':/flange')
    local tcp = sim.getObject(':/flange/tcp', {noError = true})
    for _, joint in ipairs(sim.getObjectsInTree(flange, sim.object_joint_type)) do
        if tcp ~= -1 and tatu.get(joint, 'joint.follows') == '' then
            local _, range = sim.getJointInterval(joint)
            return {joint = joint, open = range[1], closed = range[1] + range[2],
                reach = sim.getObjectPosition(tcp, flange)[3]}
        end
    end
end

-- Opens or closes the gripper, and waits until it has finished.
local function grip(angle)
    sim.setJointTargetPosition(gripper.joint, angle)
    sim.wait(GRIP_TIME)
end

-- Returns the positions of the flange with the gripper at an object's position, and above it.
local function at(place)
    local low = {place[1], place[2], place[3] + gripper.reach}
    return low, {low[1], low[2], low[3] + CLEARANCE}
end

-- Grips at a position. Returns whether an object is held.
local function pick(place)
    local low, high = at(place)
    local turn = place[4]
    move_joints(solve(tool_down(high, turn), HOME))
    grip(gripper.open)
    move_straight(high, low, turn)
    grip(gripper.closed)
    move_straight(low, high, turn)
    return math.abs(sim.getJointPosition(gripper.joint) - gripper.closed) > EMPTY
end

local function put(place)
    local low, high = at(place)
    local turn = place[4]
    move_joints(solve(tool_down(high, turn), HOME))
    move_straight(high, low, turn)
    grip(gripper.open)
    move_straight(low, high, turn)
end

-- Moves the objects of one row to the other, then back, until neither row has objects.
local function sort_rows()
    local from, to, found = ROW_A, ROW_B, true
    while true do
        local any = false
        for i = 1, #from do
            if pick(from[i]) then
                put(to[i])
                any = true
            end
        end
        move_joints(HOME)
        if not any and not found then sim.wait(5) end
        from, to, found = to, from, any
    end
end

function sysCall_init()
    joints = {}
    for i, name in ipairs{'shoulder_pan', 'shoulder_lift', 'elbow', 'wrist_1', 'wrist_2', 'wrist_3'} do
        joints[i] = sim.getObject(':/' .. name .. '_joint')
    end
    kinematics = sim.getScript(sim.scripttype_simulation, sim.getObject(':/kinematics'))
    gripper = find_gripper()
end

function sysCall_thread()
    if gripper then sort_rows() else draw_circles() end
end
