-- A micromouse: explores a maze of square cells, and then drives the shortest known path to the goal.
--
-- Map. The cells are numbered by their distance to the target (flood fill, breadth first); walls that were not observed
-- yet count as open. From each cell, the robot drives to the neighbour with the smallest number. In each cell, it
-- checks for walls to the left, ahead and to the right, and renumbers the cells. From the goal, it does the same with
-- the start as the target, which explores more cells. For the fast run, only observed passages count as open.
--
-- Pose. An extended Kalman filter predicts with the wheel encoders, and corrects with the distances that four infrared
-- sensors measure to walls on the map (Thrun, Burgard, Fox, "Probabilistic Robotics", chapters 3 and 7). Only the start
-- and the size of the maze are given.

local Matrix = require 'matrix'

-- The maze
local N = 8                     -- cells in a row and in a column
local CELL = 0.12               -- m
local THICK = 0.01              -- m, of the walls
local GOALS = {{3, 3}, {3, 4}, {4, 3}, {4, 4}}      -- cells, from 0: column, row
local START = {{0, 0}}

-- The robot: e-puck2
local RADIUS = 0.02             -- m, of the wheels
local TRACK = 0.052             -- m, between the wheels
local TOP_SPEED = 7.536         -- rad/s, of a wheel
local RANGE = 0.07              -- m, of the infrared sensors
local SENSORS = {               -- x, y (m) and heading (rad) on the robot; ps0 and ps7 face ahead, ps2 and ps5 sideways
    ps0 = {0.030, -0.010, math.rad(-17.2)}, ps2 = {0.0, -0.031, math.rad(-90)},
    ps7 = {0.030, 0.010, math.rad(17.1)}, ps5 = {0.0, 0.031, math.rad(90)},
}
local ORDER = {'ps0', 'ps2', 'ps5', 'ps7'}

-- Driving
local EXPLORE = 0.12            -- m/s
local FAST = 0.145              -- m/s
local ACCELERATION = 0.5        -- m/s^2
local TURN = 4.0                -- rad/s
local TURN_ACCELERATION = 20.0  -- rad/s^2
local GAIN_HEADING = 8.0        -- rad/s per rad
local GAIN_ASIDE = 8.0          -- rad of heading per m of offset from the middle of the corridor
local LOOK = 0.02               -- m before the middle of a cell, where walls are checked and the next heading is chosen
local WALL_AHEAD = 0.060        -- m: a smaller reading of ps0 or ps7 at that point means a wall (which reads 0.047)
local WALL_ASIDE = 0.050        -- m: the limit for ps2 and ps5 (which read 0.024)
local PAUSE = 1.5               -- s at the goal and at the start

-- The filter
local SIGMA_TRAVEL = 0.02       -- m per square root of a metre of travel, of each wheel
local SIGMA_INFRARED = 0.002    -- m: includes noise, the width of the cone and the tolerances of real walls
local GATE = 3.0                -- standard deviations: beyond this, the beam hit another object or the end of a wall

-- Headings count 0 to 3: along +x, +y, -x, -y.
local DX, DY = {[0] = 1, 0, -1, 0}, {[0] = 0, 1, 0, -1}

--------------------------------------------------------------------------------------------------------------- the map

-- A wall is on one side of a cell; both cells share it. true: wall, false: passage, nil: unknown.
local walls = {}

local function key(cx, cy, heading)
    if heading == 0 then return 'x', cx + 1, cy end
    if heading == 2 then return 'x', cx, cy end
    if heading == 1 then return 'y', cy + 1, cx end
    return 'y', cy, cx
end

local function get_wall(axis, line, lane)
    if line == 0 or line == N then return true end      -- the outer walls
    return walls[axis .. line * N + lane]
end

local function set_wall(cx, cy, heading, there)
    local axis, line, lane = key(cx, cy, heading)
    if line == 0 or line == N or walls[axis .. line * N + lane] ~= nil then return end
    walls[axis .. line * N + lane] = there
    changed = true
end

local function wall_of(cx, cy, heading)
    return get_wall(key(cx, cy, heading))
end

-- Returns the distances to the targets in cells. `cautious`: only observed passages count as open.
local function flood(targets, cautious)
    local number, queue = {}, {}
    for _, t in ipairs(targets) do
        number[t[1] * N + t[2]] = 0
        queue[#queue + 1] = t
    end
    local head = 1
    while queue[head] do
        local cx, cy = queue[head][1], queue[head][2]
        head = head + 1
        for h = 0, 3 do
            local w = wall_of(cx, cy, h)
            local x, y = cx + DX[h], cy + DY[h]
            if (w == false or (w == nil and not cautious)) and not number[x * N + y] then
                number[x * N + y] = number[cx * N + cy] + 1
                queue[#queue + 1] = {x, y}
            end
        end
    end
    return number
end

-- Returns the heading to the neighbour with the smallest number; among equals, straight ahead is preferred.
local function best_heading(number, cx, cy, heading, cautious)
    local best, least
    for _, turn in ipairs{0, 1, 3, 2} do
        local h = (heading + turn) % 4
        local w = wall_of(cx, cy, h)
        local n = number[(cx + DX[h]) * N + cy + DY[h]]
        if n and (w == false or (w == nil and not cautious)) and (not least or n < least) then best, least = h, n end
    end
    return best
end

-------------------------------------------------------------------------------------------------------------- the pose

local function wrap(a)
    return (a + math.pi) % (2 * math.pi) - math.pi
end

local function predict(left_travel, right_travel)
    local ahead, turn = (left_travel + right_travel) / 2, (right_travel - left_travel) / TRACK
    local h = pose:get(3) + turn / 2
    local c, s = math.cos(h), math.sin(h)
    pose = pose + Matrix{ahead * c, ahead * s, turn}
    local F = Matrix{{1, 0, -ahead * s}, {0, 1, ahead * c}, {0, 0, 1}}
    local V = Matrix{{c / 2, c / 2}, {s / 2, s / 2}, {-1 / TRACK, 1 / TRACK}}
    local q = SIGMA_TRAVEL ^ 2
    local Q = Matrix.diag{q * math.abs(left_travel) + 1e-12, q * math.abs(right_travel) + 1e-12}
    P = F * P * F:t() + V * Q * V:t()
end

-- Returns the distance from (x, y) along (ux, uy) to the next wall on the map that crosses x (axis 1) or y (axis 2),
-- and the position of its face.
local function cast(axis, x, y, ux, uy)
    local along, aside, step, drift = x, y, ux, uy
    if axis == 2 then along, aside, step, drift = y, x, uy, ux end
    if math.abs(step) < 1e-6 then return math.huge end
    local line = step > 0 and math.ceil(along / CELL) or math.floor(along / CELL)
    local face = line * CELL - (step > 0 and 1 or -1) * THICK / 2
    local d = (face - along) / step
    local lane = math.floor((aside + d * drift) / CELL)
    if d <= 0 or line < 0 or line > N or lane < 0 or lane >= N then return math.huge end
    return get_wall(axis == 1 and 'x' or 'y', line, lane) and d or math.huge
end

local function correct(sensor, measured)
    local x, y, h = pose:get(1), pose:get(2), pose:get(3)
    local c, s = math.cos(h), math.sin(h)
    local rx, ry = c * sensor[1] - s * sensor[2], s * sensor[1] + c * sensor[2]
    local ux, uy = math.cos(h + sensor[3]), math.sin(h + sensor[3])
    local dx, dy = cast(1, x + rx, y + ry, ux, uy), cast(2, x + rx, y + ry, ux, uy)
    local expected = math.min(dx, dy)
    if expected > RANGE then return end
    -- d = (face - x - rx) / ux: derivatives with respect to x, y and the heading.
    local H
    if dx < dy then H = Matrix{{-1 / ux, 0, (ry + expected * uy) / ux}}
    else H = Matrix{{0, -1 / uy, (-rx - expected * ux) / uy}} end
    local S = (H * P * H:t()):get(1, 1) + SIGMA_INFRARED ^ 2
    local off = measured - expected
    if off * off > GATE ^ 2 * S then return end
    local K = P * H:t() / S
    pose = pose + K * off
    P = (Matrix.eye(3) - K * H) * P
end

--------------------------------------------------------------------------------------------------------------- drawing

local HEIGHT = 0.0605           -- m: lines on top of the walls
local SHADES = 8

local function new_drawings()
    seen_walls = sim.addDrawingObject(sim.drawing_lines, 5, 0, -1, 0, {0.90, 0.15, 0.12})
    way = sim.addDrawingObject(sim.drawing_lines, 4, 0, -1, 0, {1.0, 1.0, 1.0})
    shades = {}
    for i = 0, SHADES - 1 do
        local t = i / (SHADES - 1)
        shades[i] = sim.addDrawingObject(sim.drawing_triangles, 1, 0, -1, 0,
            {0.10 + 0.85 * t, 0.35 + 0.40 * t, 0.75 - 0.55 * t})
    end
end

-- Draws the cells by their number, the observed walls, and the path from this cell to the target.
local function draw(number, cx, cy, heading, cautious)
    for i = 0, SHADES - 1 do sim.addDrawingObjectItem(shades[i], nil) end
    sim.addDrawingObjectItem(seen_walls, nil)
    sim.addDrawingObjectItem(way, nil)
    local edge, z = 0.012, 0.0010
    for x = 0, N - 1 do
        for y = 0, N - 1 do
            local n = number[x * N + y]
            if n and n > 0 then
                local shade = shades[math.min(SHADES - 1, n // 2)]
                local x0, x1 = x * CELL + edge, (x + 1) * CELL - edge
                local y0, y1 = y * CELL + edge, (y + 1) * CELL - edge
                sim.addDrawingObjectItem(shade, {x0, y0, z, x1, y0, z, x1, y1, z})
                sim.addDrawingObjectItem(shade, {x0, y0, z, x1, y1, z, x0, y1, z})
            end
            if wall_of(x, y, 0) and x < N - 1 then
                local at = (x + 1) * CELL
                sim.addDrawingObjectItem(seen_walls, {at, y * CELL, HEIGHT, at, (y + 1) * CELL, HEIGHT})
            end
            if wall_of(x, y, 1) and y < N - 1 then
                local at = (y + 1) * CELL
                sim.addDrawingObjectItem(seen_walls, {x * CELL, at, HEIGHT, (x + 1) * CELL, at, HEIGHT})
            end
        end
    end
    for _ = 1, N * N do
        if number[cx * N + cy] == 0 then break end
        heading = best_heading(number, cx, cy, heading, cautious)
        if not heading then break end
        local x, y = cx + DX[heading], cy + DY[heading]
        sim.addDrawingObjectItem(way,
            {(cx + 0.5) * CELL, (cy + 0.5) * CELL, 0.002, (x + 0.5) * CELL, (y + 0.5) * CELL, 0.002})
        cx, cy = x, y
    end
end

--------------------------------------------------------------------------------------------------------------- driving

-- The runs, in order; the last two are repeated.
local RUNS = {
    {name = 'explore', targets = GOALS, speed = EXPLORE}, {name = 'explore back', targets = START, speed = EXPLORE},
    {name = 'fast', targets = GOALS, speed = FAST, cautious = true},
    {name = 'back', targets = START, speed = FAST, cautious = true},
}

function sysCall_init()
    left, right = sim.getObject(':/ePuck_leftJoint'), sim.getObject(':/ePuck_rightJoint')
    left_encoder, right_encoder = sim.getObject(':/left_encoder'), sim.getObject(':/right_encoder')
    infrared = {}
    for name in pairs(SENSORS) do infrared[name] = sim.getObject(':/' .. name) end
    pose = Matrix{CELL / 2, CELL / 2, math.pi / 2}
    P = Matrix.diag{1e-6, 1e-6, 1e-4}
    last_left, last_right = 0, 0
    cx, cy, heading = 0, 0, 1   -- the cell to whose middle the robot drives, and its heading
    run, state, wake = 1, 'think', 0
    speed, rate = 0, 0
    new_drawings()
end

-- Returns the distances of the infrared sensors; infinity if nothing is detected.
local function read_infrared()
    local d = {}
    for name, sensor in pairs(infrared) do
        local found, distance = sim.readProximitySensor(sensor)
        d[name] = found == 1 and distance or math.huge
    end
    return d
end

local function look_for_walls(d)
    set_wall(cx, cy, heading, math.min(d.ps0, d.ps7) < WALL_AHEAD)
    set_wall(cx, cy, (heading + 1) % 4, d.ps5 < WALL_ASIDE)
    set_wall(cx, cy, (heading + 3) % 4, d.ps2 < WALL_ASIDE)
end

-- Checks for walls and returns the next heading, or nil at the target.
local function think(d)
    if RUNS[run].cautious == nil then look_for_walls(d) end
    local r = RUNS[run]
    local number = flood(r.targets, r.cautious)
    draw(number, cx, cy, heading, r.cautious)
    if number[cx * N + cy] == 0 then return nil end
    return best_heading(number, cx, cy, heading, r.cautious)
end

-- At the target of a run: the next run begins after a pause.
local function finish(now)
    run = run < #RUNS and run + 1 or #RUNS - 1
    wake = now + PAUSE
    return 'wait'
end

-- Returns the remaining distance to the middle of the cell, and the offset to the left of that line.
local function to_go()
    local x, y = pose:get(1) - (cx + 0.5) * CELL, pose:get(2) - (cy + 0.5) * CELL
    return -(x * DX[heading] + y * DY[heading]), y * DX[heading] - x * DY[heading]
end

-- Each state function returns the desired speed (m/s) and yaw rate (rad/s), and the next state.
local states = {}

function states.wait(now)
    return 0, 0, now >= wake and 'think' or 'wait'
end

function states.think(now, d)
    local go = think(d)
    if not go then return 0, 0, finish(now) end
    next_heading = go
    return 0, 0, 'turn'
end

function states.turn()
    local off = wrap(next_heading * math.pi / 2 - pose:get(3))
    if math.abs(off) < 0.02 and math.abs(rate) < 0.6 then
        heading = next_heading
        cx, cy = cx + DX[heading], cy + DY[heading]
        next_heading, at_target = nil, false
        return 0, 0, 'drive'
    end
    local most = math.min(TURN, math.sqrt(2 * 0.6 * TURN_ACCELERATION * math.abs(off)), 15 * math.abs(off))
    return 0, (off > 0 and 1 or -1) * most, 'turn'
end

function states.drive(now, d)
    local ahead, aside = to_go()
    if ahead < LOOK and not next_heading and not at_target then
        next_heading = think(d)
        at_target = not next_heading
        if next_heading == heading then         -- straight ahead, without a stop
            cx, cy, next_heading = cx + DX[heading], cy + DY[heading], nil
            ahead = ahead + CELL
        end
    end
    if (next_heading or at_target) and ahead < 0.001 then
        if at_target then return 0, 0, finish(now) end
        return 0, 0, 'turn'
    end
    -- After the decision, the robot stops at the middle of this cell; LOOK is long enough to brake.
    local stop = (next_heading or at_target) and ahead or ahead + CELL
    local want = math.max(0.01, math.min(RUNS[run].speed, math.sqrt(2 * 0.8 * ACCELERATION * math.max(0, stop))))
    local course = heading * math.pi / 2 - math.max(-0.5, math.min(0.5, GAIN_ASIDE * aside))
    return want, GAIN_HEADING * wrap(course - pose:get(3)), 'drive'
end

local function toward(value, target, most)
    return value + math.max(-most, math.min(most, target - value))
end

function sysCall_actuation()
    local l, r = tatu.read(left_encoder), tatu.read(right_encoder)
    if l.sequence == 0 then return end
    predict((l.position - last_left) * RADIUS, (r.position - last_right) * RADIUS)
    last_left, last_right = l.position, r.position
    local d = read_infrared()
    for _, name in ipairs(ORDER) do
        if d[name] < RANGE then correct(SENSORS[name], d[name]) end
    end

    local now, dt = sim.getSimulationTime(), sim.getSimulationTimeStep()
    local want_speed, want_rate
    want_speed, want_rate, state = states[state](now, d)
    speed = toward(speed, want_speed, ACCELERATION * dt)
    rate = toward(rate, want_rate, TURN_ACCELERATION * dt)
    local turn = rate * TRACK / 2
    sim.setJointTargetVelocity(left, math.max(-TOP_SPEED, math.min(TOP_SPEED, (speed - turn) / RADIUS)))
    sim.setJointTargetVelocity(right, math.max(-TOP_SPEED, math.min(TOP_SPEED, (speed + turn) / RADIUS)))
    -- The estimate, which the referee compares with the true position.
    sim.setFloatSignal('maze_x', pose:get(1))
    sim.setFloatSignal('maze_y', pose:get(2))
end
