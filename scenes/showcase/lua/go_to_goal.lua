-- Bug2 (Lumelsky and Stepanov, 1987): drives to goals that are given in its odometry frame, around unknown obstacles.
--
-- The robot drives along the line from its starting point to the goal. At an obstacle (the hit point), it stores the
-- distance to the goal, and follows the boundary on its right until it is on that line again, nearer to the goal than
-- at the hit point. It needs no map, only its odometry and the current scan.

local base = require 'turtlebot3_base'

local GOALS = {{3.8, 0.0}, {0.2, -1.25}, {0.3, 1.25}}      -- m, visited in order, in a loop
local REACHED = 0.06            -- m: distance at which a goal counts as reached
local PAUSE = 1.5               -- s at a goal
local HIT = 0.33                -- m, from the scanner: an obstacle in the lane that is nearer than this is a hit
local HALF_LANE = 0.14          -- m
local ON_LINE = 0.05            -- m: distance at which the robot counts as on the line
local NEARER = 0.15             -- m: minimum progress towards the goal since the hit point before leaving the boundary
local GAIN_HEADING = 2.0        -- rad/s per rad
local GAIN_LINE = 1.5           -- rad per m of offset from the line

-- Following the boundary
local KEEP = 0.27               -- m, from the scanner to the boundary
local FAR = 1.2                 -- m: farther obstacles are ignored
local FROM, TO = math.rad(-150), math.rad(40)   -- the sector that is searched for the boundary
local WINDOW = 4                -- beams to either side over which distances are averaged
local SAME = 0.03               -- m: beams up to this much longer than the shortest one hit the same spot
local GAIN_KEEP = 3.0           -- rad of approach per m
local GAIN_SIDE = 2.2           -- rad/s per rad
local STOP, SLOW = 0.20, 0.55   -- m to an obstacle ahead: the speed falls from SLOW to STOP

local YELLOW, ORANGE, RED, GREEN = {0.95, 0.80, 0.15}, {0.95, 0.40, 0.10}, {0.85, 0.12, 0.10}, {0.15, 0.60, 0.25}

function sysCall_init()
    -- The robot starts at the world's origin, so drawings in the odometry frame need no conversion.
    base.init(0, 0, 0)
    line_drawing = sim.addDrawingObject(sim.drawing_lines, 2, 0, -1, 0, YELLOW)
    trail = sim.addDrawingObject(sim.drawing_lines + sim.drawing_cyclic, 3, 0, -1, 1500, ORANGE)
    hits = sim.addDrawingObject(sim.drawing_spherepts + sim.drawing_cyclic, 0.06, 0, -1, 4, RED)
    leaves = sim.addDrawingObject(sim.drawing_spherepts + sim.drawing_cyclic, 0.06, 0, -1, 4, GREEN)
    last_x, last_y = 0, 0
    goal_number = 0
    want_speed, want_turn = 0, 0
    set_out(0, 0)
end

-- Selects the next goal: the line to it starts at the current position.
function set_out(x, y)
    goal_number = goal_number % #GOALS + 1
    goal = GOALS[goal_number]
    start = {x, y}
    state, hit_distance = 'to goal', nil
    sim.addDrawingObjectItem(line_drawing, nil)
    sim.addDrawingObjectItem(line_drawing, {x, y, 0.005, goal[1], goal[2], 0.005})
end

-- Returns the distance of (x, y) to the left of the line, and the direction of the line.
local function beside_line(x, y)
    local dx, dy = goal[1] - start[1], goal[2] - start[2]
    local length = math.sqrt(dx * dx + dy * dy)
    return (dx * (y - start[2]) - dy * (x - start[1])) / length, math.atan(dy, dx)
end

-- Returns the distance of the nearest obstacle in the lane along a direction relative to the robot.
local function free_way(scan, direction)
    local free = FAR
    for i, d in ipairs(scan.distance) do
        local a = base.wrap(scan.angle[i] - direction)
        if math.abs(a) < math.pi / 2 and d * math.abs(math.sin(a)) < HALF_LANE then
            free = math.min(free, d * math.cos(a))
        end
    end
    return free
end

-- Returns distance and bearing of the boundary: of the nearest point on the right, averaged over the beams that hit it.
local function boundary(scan)
    local n, least, at, smoothed = #scan.distance, FAR, nil, {}
    for i, a in ipairs(scan.angle) do
        if a >= FROM and a <= TO then
            local sum = 0
            for k = i - WINDOW, i + WINDOW do sum = sum + math.min(FAR, scan.distance[(k - 1) % n + 1]) end
            smoothed[i] = sum / (2 * WINDOW + 1)
            if smoothed[i] < least then least, at = smoothed[i], a end
        end
    end
    if not at then return end
    local sum, count = 0, 0
    for i, a in ipairs(scan.angle) do
        if smoothed[i] and smoothed[i] < least + SAME and math.abs(a - at) < math.rad(40) then
            sum, count = sum + a, count + 1
        end
    end
    return least, sum / count
end

local function slow_down(scan)
    return math.max(0, math.min(1, (free_way(scan, 0) - STOP) / (SLOW - STOP)))
end

local function to_goal(scan, x, y, heading, distance)
    local aside, along = beside_line(x, y)
    local course = along - base.limit(GAIN_LINE * aside, 1.0)
    if distance < 0.3 then course = math.atan(goal[2] - y, goal[1] - x) end
    local off = base.wrap(course - heading)
    local free = math.min(free_way(scan, off), distance)
    if math.abs(off) < 0.3 and free < HIT and free < distance then
        state, hit_distance = 'boundary', distance
        sim.addDrawingObjectItem(hits, {x, y, 0.03})
        print(string.format('hit point at %.2f, %.2f', x, y))
    end
    want_turn = GAIN_HEADING * off
    want_speed = base.MAX_SPEED * math.max(0, 1 - math.abs(off) / 0.8) * math.min(1, 0.15 + distance / 0.4)
    want_speed = want_speed * math.max(0.3, slow_down(scan))
end

local function follow_boundary(scan, x, y, heading, distance)
    local aside = beside_line(x, y)
    if math.abs(aside) < ON_LINE and distance < hit_distance - NEARER then
        local way = free_way(scan, base.wrap(math.atan(goal[2] - y, goal[1] - x) - heading))
        if way > HIT + 0.1 or way > distance then
            state = 'to goal'
            sim.addDrawingObjectItem(leaves, {x, y, 0.03})
            print(string.format('leaves the boundary at %.2f, %.2f', x, y))
            return
        end
    end
    local gap, bearing = boundary(scan)
    if not gap then
        want_speed, want_turn = 0.1, -0.5       -- boundary lost: search for it on the right
        return
    end
    local approach = base.limit(GAIN_KEEP * (gap - KEEP), math.rad(45))
    want_turn = base.limit(GAIN_SIDE * (bearing + math.pi / 2 - approach), base.MAX_TURN)
    want_speed = base.MAX_SPEED * slow_down(scan) * math.max(0.25, 1 - math.abs(want_turn) / base.MAX_TURN)
end

local function draw_trail(x, y)
    if (x - last_x) ^ 2 + (y - last_y) ^ 2 < 0.02 ^ 2 then return end
    sim.addDrawingObjectItem(trail, {last_x, last_y, 0.01, x, y, 0.01})
    last_x, last_y = x, y
end

function sysCall_actuation()
    local x, y, heading = base.odometry()
    local now = sim.getSimulationTime()
    draw_trail(x, y)
    local distance = math.sqrt((goal[1] - x) ^ 2 + (goal[2] - y) ^ 2)
    if state == 'rest' then
        if now > wake then set_out(x, y) end
    elseif distance < REACHED then
        state, wake = 'rest', now + PAUSE
        want_speed, want_turn = 0, 0
        print(string.format('goal %d: reached at %.1f s', goal_number, now))
    else
        local scan = base.new_scan()
        if scan then (state == 'boundary' and follow_boundary or to_goal)(scan, x, y, heading, distance) end
    end
    base.drive(want_speed, want_turn)
end
