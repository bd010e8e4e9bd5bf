-- Carries a cube between two boards. Every path is planned: the arm, the hand and the cube that it holds keep a distance
-- from the boards, the wall and the floor. The script follows the paths by the target positions of the joints.

local BOARDS = {{0.45, -0.30}, {0.45, 0.30}}      -- m: middles of the boards
local CUBE_HEIGHT = 0.045                         -- m: centre of the cube on a board
local CLEARANCE = 0.14                            -- m: height above the cube before it is gripped
local OPEN = 0.04                                 -- m: position of a finger
local MARGIN = 0.01                               -- m: by which the arm may deviate from its path
local SPEED = 0.7                                 -- rad/s: of all joints together, on average
local STATES = 200

local joints, finger, tip, cube, wall

-- Follows a path, at rest at both ends.
local function follow(path)
    local length = 0
    for i = 2, #path do
        local sum = 0
        for k = 1, #joints do sum = sum + (path[i][k] - path[i - 1][k]) ^ 2 end
        length = length + math.sqrt(sum)
    end
    local duration, start, share = math.max(length / SPEED, 0.5), sim.getSimulationTime(), 0
    while share < 1 do
        share = math.min((sim.getSimulationTime() - start) / duration, 1)
        local at = share * share * (3 - 2 * share) * (#path - 1) + 1
        local i = math.min(math.floor(at), #path - 1)
        for k, joint in ipairs(joints) do
            sim.setJointTargetPosition(joint, path[i][k] + (at - i) * (path[i + 1][k] - path[i][k]))
        end
        sim.step()
    end
    sim.wait(0.3)
end

-- Moves the tool to a place, pointing down, with the fingers along y.
local function move(place, height, options)
    options.tip, options.pose = tip, {place[1], place[2], height, 1, 0, 0, 0}
    options.states = STATES
    local path, reason = tatu.plan(joints, nil, options)
    if not path then error(string.format('no way to %.2f %.2f %.2f m: %s', place[1], place[2], height, reason)) end
    follow(path)
end

local function grip(position)
    sim.setJointTargetPosition(finger, position)
    sim.wait(0.6)
end

function sysCall_init()
    joints = {}
    for i = 1, 7 do joints[i] = sim.getObject(':/panda_joint' .. i) end
    finger = sim.getObject(':/flange/hand/panda_finger_joint1')
    tip = sim.getObject(':/flange/hand/panda_hand_tcp')
    cube, wall = sim.getObject('/cube'), sim.getObject('/wall')
end

function sysCall_thread()
    local low, high = CUBE_HEIGHT, CUBE_HEIGHT + CLEARANCE
    local from, to = 1, 2
    grip(OPEN)
    while true do
        move(BOARDS[from], high, {margin = MARGIN})
        move(BOARDS[from], low, {margin = 0.002})
        grip(0)
        -- The cube still stands on the board, which it may touch.
        move(BOARDS[from], high, {grasped = {cube}, avoid = {wall}})
        move(BOARDS[to], high, {grasped = {cube}, margin = MARGIN})
        move(BOARDS[to], low + 0.002, {grasped = {cube}, avoid = {wall}})
        grip(OPEN)
        move(BOARDS[to], high, {avoid = {wall}})
        from, to = to, from
    end
end
