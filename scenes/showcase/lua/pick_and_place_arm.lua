-- The Panda locates cubes in the images of a camera above its table, stacks them to a tower in a given order,
-- dismantles the tower, places the cubes at random positions, and starts over.
--
-- Inputs are the joints and the camera. Each action depends only on the last image, so a cube that a user moves, or a
-- tower that falls, only costs time. Lengths are in m in the frame of the arm's base, which stands on the table.

local CUBE = 0.045                        -- m: edge of a cube
local ORDER = {'blue', 'green', 'yellow', 'orange', 'red'}                            -- from the bottom of the tower up
local HUES = {red = 0, orange = 28, yellow = 52, green = 130, blue = 215}             -- degrees

local PAD = {0.52, 0.0}                   -- m: middle of the tower
local PAD_RADIUS = 0.07                   -- m: a cube whose middle is nearer than this stands on the pad
local FIELD = {x = {0.41, 0.64}, y = {0.13, 0.27}}      -- m: region in which cubes are placed, on both sides of the pad
local SPACING = 0.105                     -- m: minimum distance between placed cubes; the fingers need room

local CAMERA = {0.55, 0.0, 1.20}          -- m: the camera faces down; its x axis is that of the base
local LEAST_HEIGHT = 0.02                 -- m: lower points belong to the table
local TOP_BAND = 0.012                    -- m: points this far below the highest ones belong to a cube's upper face
local LEAST_POINTS = 40                   -- minimum number of points of an upper face

local TCP = 0.1034                        -- m: from the flange to the tool centre of the hand
local WAIT_AT = {0.33, 0.0, 0.42}         -- m: position in which the hand is outside the camera's view
local CLEARANCE = 0.10                    -- m: clearance between the tower and a cube that is carried over it
local OPEN = 0.04                         -- m: position of a finger
local GRIP_TIME = 0.5                     -- s
local LIFT_SPEED = 0.22                   -- m/s: mean speed of straight moves
local PACE = 0.40                         -- fraction of the maximum velocities and accelerations that moves use
local MAX_VELOCITY = {2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61}      -- rad/s
local MAX_ACCELERATION = {15, 7.5, 10, 12.5, 15, 20, 20}                 -- rad/s^2
local MAX_JERK = {7500, 3750, 5000, 6250, 7500, 10000, 10000}            -- rad/s^3

local joints, finger, kinematics, camera, marks

-- Vision --------------------------------------------------------------------------------------------------------------

-- Returns the hue of a colour in degrees, or nil if it is nearly grey.
local function hue(r, g, b)
    local most, least = math.max(r, g, b), math.min(r, g, b)
    local chroma = most - least
    if chroma < 0.35 * most or most < 30 then return nil end
    if most == r then return 60 * ((g - b) / chroma) % 360 end
    if most == g then return 60 * ((b - r) / chroma + 2) end
    return 60 * ((r - g) / chroma + 4)
end

local function nearest_name(h)
    local best, least
    for name, value in pairs(HUES) do
        local off = math.abs((h - value + 180) % 360 - 180)
        if not least or off < least then best, least = name, off end
    end
    return best
end

-- Returns the points of the image above the table, grouped by the colour of their cube.
local function coloured_points()
    sim.handleVisionSensor(camera)
    local image = tatu.read(camera)
    local fx, fy, cx, cy = table.unpack(image.intrinsics)
    local points, at = {}, 0
    for row = 0, image.rows - 1 do
        for column = 0, image.columns - 1 do
            local depth = string.unpack('<f', image.depth, 4 * at + 1)
            local height = CAMERA[3] - depth
            if height > LEAST_HEIGHT and height < 0.4 then
                local h = hue(image.rgb:byte(3 * at + 1, 3 * at + 3))
                if h then
                    local name = nearest_name(h)
                    points[name] = points[name] or {}
                    -- The camera is rotated by 180 degrees about its x axis, and its image has +x to the left.
                    table.insert(points[name], {
                        CAMERA[1] - (column - cx) * depth / fx, CAMERA[2] - (row - cy) * depth / fy, height})
                end
            end
            at = at + 1
        end
    end
    return points
end

-- Returns middle, height and rotation of the upper face that points belong to, or nil if there are too few points.
local function upper_face(points)
    if #points < LEAST_POINTS then return nil end
    table.sort(points, function(a, b) return a[3] > b[3] end)
    local top = points[#points // 10 + 1][3]
    local face, x, y, z = {}, 0, 0, 0
    for _, p in ipairs(points) do
        if p[3] > top - TOP_BAND then
            face[#face + 1] = p
            x, y, z = x + p[1], y + p[2], z + p[3]
        end
    end
    if #face < LEAST_POINTS then return nil end
    x, y, z = x / #face, y / #face, z / #face
    -- A square has quarter-turn symmetry, so the mean of the fourth powers of its points, as complex numbers about the
    -- middle, has four times its angle. That mean is negative for a square along the axes.
    local re, im = 0, 0
    for _, p in ipairs(face) do
        local u, v = p[1] - x, p[2] - y
        local a, b = u * u - v * v, 2 * u * v
        re, im = re + a * a - b * b, im + 2 * a * b
    end
    return {x = x, y = y, top = z, yaw = math.atan(-im, -re) / 4}
end

-- Draws a frame around the upper face of each detected cube.
local function draw(cubes)
    sim.addDrawingObjectItem(marks, nil)
    local base = sim.getObjectPosition(sim.getObject(':'))
    for _, cube in pairs(cubes) do
        local corners = {}
        for i = 0, 4 do
            local angle = cube.yaw + math.pi / 4 + i * math.pi / 2
            corners[i] = {base[1] + cube.x + 0.78 * CUBE * math.cos(angle),
                base[2] + cube.y + 0.78 * CUBE * math.sin(angle), base[3] + cube.top + 0.002}
        end
        for i = 1, 4 do
            local a, b = corners[i - 1], corners[i]
            sim.addDrawingObjectItem(marks, {a[1], a[2], a[3], b[1], b[2], b[3]})
        end
    end
end

-- Returns the cubes that the camera detects, by colour.
local function look()
    local cubes = {}
    for name, points in pairs(coloured_points()) do cubes[name] = upper_face(points) end
    draw(cubes)
    return cubes
end

local function on_pad(cube)
    return math.sqrt((cube.x - PAD[1]) ^ 2 + (cube.y - PAD[2]) ^ 2) < PAD_RADIUS
end

-- Returns the colour of the highest cube on the pad, and the cube.
local function top_of_pad(cubes)
    local best
    for name, cube in pairs(cubes) do
        if on_pad(cube) and (not best or cube.top > cubes[best].top) then best = name end
    end
    return best, cubes[best]
end

-- Motion --------------------------------------------------------------------------------------------------------------

local function positions()
    local q = {}
    for i, joint in ipairs(joints) do q[i] = sim.getJointPosition(joint) end
    return q
end

local function scaled(values)
    local out = {}
    for i, value in ipairs(values) do out[i] = PACE * value end
    return out
end

-- Returns the joint angles for a hand that points down, with the line of its fingers rotated by `yaw` from the y axis,
-- and the tool centre at x, y, z.
local function solve(x, y, z, yaw)
    local half = yaw / 2 - math.pi / 8      -- the flange is rotated by 45 degrees relative to the hand
    local pose = {x, y, z + TCP, math.cos(half), math.sin(half), 0, 0}
    -- The elbow stays in the vertical plane through the target if joint 7 compensates for bearing and yaw.
    local solutions = kinematics:inverse(pose, math.pi / 4 + math.atan(y, x) - yaw, positions())
    if #solutions == 0 then error(string.format('the place at %.3f %.3f %.3f m is out of reach', x, y, z)) end
    return solutions[1]
end

local function move(x, y, z, yaw)
    sim.moveToConfig{
        joints = joints, targetPos = solve(x, y, z, yaw),
        maxVel = scaled(MAX_VELOCITY), maxAccel = scaled(MAX_ACCELERATION), maxJerk = MAX_JERK,
    }
    sim.wait(0.1)
end

-- Moves along z in a straight line, at rest at both ends.
local function lift(x, y, from, to, yaw)
    local seconds = math.max(0.5, math.abs(to - from) / LIFT_SPEED)
    local start, t = sim.getSimulationTime(), 0
    while t < 1 do
        t = math.min((sim.getSimulationTime() - start) / seconds, 1)
        local q = solve(x, y, from + (to - from) * t * t * t * (10 + t * (6 * t - 15)), yaw)
        for i, joint in ipairs(joints) do sim.setJointTargetPosition(joint, q[i]) end
        sim.step()
    end
    sim.wait(0.15)      -- targets are reached after two steps
end

local function grip(position)
    sim.setJointTargetPosition(finger, position)
    sim.wait(GRIP_TIME)
end

-- Moves the hand out of the camera's view, and returns the cubes that the camera detects.
local function go_and_look()
    move(WAIT_AT[1], WAIT_AT[2], WAIT_AT[3], 0)
    return look()
end

-- Grips a detected cube, and lifts it to a height. Returns whether the fingers hold it.
local function pick(cube, high)
    local z = cube.top - CUBE / 2
    move(cube.x, cube.y, high, cube.yaw)
    lift(cube.x, cube.y, high, z, cube.yaw)
    grip(0)
    local width = 2 * sim.getJointPosition(finger)
    local held = math.abs(width - CUBE) < 0.006
    if not held then grip(OPEN) end
    lift(cube.x, cube.y, z, high, cube.yaw)
    return held
end

-- Puts down the held cube, with its middle at the height z.
local function put(x, y, z, yaw, high)
    move(x, y, high, yaw)
    lift(x, y, high, z + 0.001, yaw)      -- the cube drops the last millimetre instead of being pressed down
    grip(OPEN)
    lift(x, y, z + 0.001, high, yaw)
end

-- The task ------------------------------------------------------------------------------------------------------------

-- Returns a random position in the field with enough room around it.
local function free_place(cubes)
    for _ = 1, 500 do
        local side = math.random() < 0.5 and -1 or 1
        local x = FIELD.x[1] + math.random() * (FIELD.x[2] - FIELD.x[1])
        local y = side * (FIELD.y[1] + math.random() * (FIELD.y[2] - FIELD.y[1]))
        local room = true
        for _, cube in pairs(cubes) do
            room = room and math.sqrt((cube.x - x) ^ 2 + (cube.y - y) ^ 2) > SPACING
        end
        if room then return x, y end
    end
    error('no free place in the field for another cube')
end

-- Removes cubes from the pad, the highest first, until it is empty.
local function clear_pad()
    local cubes = go_and_look()
    local name, cube = top_of_pad(cubes)
    while name do
        local high = cube.top + CLEARANCE
        if pick(cube, high) then
            cubes[name] = nil
            local x, y = free_place(cubes)
            put(x, y, CUBE / 2, math.rad(math.random(-40, 40)), high)
        end
        cubes = go_and_look()
        name, cube = top_of_pad(cubes)
    end
end

-- Builds the tower. Returns whether the camera confirms each step.
local function build_tower()
    for level, name in ipairs(ORDER) do
        local high = level * CUBE + CLEARANCE
        local held = false
        while not held do
            local cube = go_and_look()[name]
            if cube and not on_pad(cube) then
                held = pick(cube, high)
            elseif cube then
                return false
            else
                sim.wait(1)      -- a user has removed it
            end
        end
        put(PAD[1], PAD[2], (level - 0.5) * CUBE, 0, high)
        local seen = select(2, top_of_pad(go_and_look()))
        if not seen or math.abs(seen.top - level * CUBE) > CUBE / 3 then return false end
    end
    return true
end

function sysCall_init()
    joints = {}
    for i = 1, 7 do joints[i] = sim.getObject(':/panda_joint' .. i) end
    finger = sim.getObject(':/flange/hand/panda_finger_joint1')
    camera = sim.getObject('/stand/camera')
    kinematics = sim.getScriptFunctions(sim.getScript(sim.scripttype_simulation, sim.getObject(':/kinematics')))
    marks = sim.addDrawingObject(sim.drawing_lines, 3, 0, -1, 40, {1, 1, 1})
end

function sysCall_thread()
    grip(OPEN)
    while true do
        clear_pad()
        if build_tower() then sim.wait(2) end
    end
end
