-- An artificial potential field (Khatib, 1986): the goal attracts the robot, and obstacles in its scan repel it. The
-- other robots are ordinary obstacles; their positions are not communicated.
--
-- Attraction and repulsion alone have local minima, where both cancel out: head-on in front of a pillar or another
-- robot. A part of the repulsion is therefore rotated by 90 degrees, so that the field flows around obstacles, always
-- with the obstacle on the left: two robots that meet both keep to the right.

local base = require 'turtlebot3_base'

-- The first position of each robot, and the position to which it drives and from which it returns: x, y (m) and heading
-- (deg), in the arena's frame.
local ROBOTS = {
    red = {start = {-1.5, -1.0, 35}, goal = {1.5, 1.0}, color = {0.90, 0.20, 0.15}},
    blue = {start = {1.5, 1.0, 215}, goal = {-1.5, -1.0}, color = {0.20, 0.45, 0.95}},
    green = {start = {-1.5, 1.0, -35}, goal = {1.5, -1.0}, color = {0.20, 0.70, 0.30}},
    yellow = {start = {1.5, -1.0, 145}, goal = {-1.5, 1.0}, color = {0.95, 0.75, 0.10}},
}
local ROUND = 36                -- s: period after which the robots change places again

-- The field; forces are dimensionless.
local ATTRACTION = 1.0          -- magnitude far from the goal
local NEAR_GOAL = 0.4           -- m: within this distance, the attraction falls linearly to 0 (parabolic potential)
local REPULSION = 0.08
local EDGE = 0.15               -- m
local REACH = 0.55              -- m: obstacles farther away do not repel
local LEAST = 0.13              -- m: smaller distances are clamped to this value
local SWIRL = 0.8               -- fraction of the repulsion that is rotated by 90 degrees
local ARRIVED = 0.05            -- m

local SPEED = 0.18              -- m/s at a force of 1
local GAIN_TURN = 2.5           -- rad/s per rad between the heading and the force
local ARROW = 0.35              -- m: drawn length of a force of 1
local ARROW_Z = 0.22            -- m: height of the arrows

function sysCall_init()
    local me = ROBOTS[sim.getObjectAlias(sim.getObject('..'))]
    base.init(me.start[1], me.start[2], math.rad(me.start[3]))
    places = {me.goal, me.start}
    wait_from = -1
    want_speed, want_turn = 0, 0
    local lines = sim.drawing_lines
    trail = sim.addDrawingObject(lines + sim.drawing_cyclic, 2.5, 0, -1, 250, me.color)
    arrows = {
        attraction = sim.addDrawingObject(lines, 4, 0, -1, 0, {0.10, 0.75, 0.30}),
        repulsion = sim.addDrawingObject(lines, 4, 0, -1, 0, {0.95, 0.20, 0.55}),
        total = sim.addDrawingObject(lines, 4, 0, -1, 0, {0.05, 0.05, 0.06}),
    }
    last_x, last_y = me.start[1], me.start[2]
end

local function attraction(dx, dy)
    local distance = math.sqrt(dx * dx + dy * dy)
    local size = ATTRACTION * math.min(1, distance / NEAR_GOAL) / math.max(distance, 1e-6)
    return size * dx, size * dy
end

-- Returns the force of one obstacle, whose nearest point is at a distance (m) and in a direction (rad).
local function push(distance, direction)
    distance = math.max(distance, LEAST)
    local size = REPULSION * (1 / distance - 1 / REACH) / (distance * distance)
    return -size * math.cos(direction), -size * math.sin(direction)
end

-- Returns the sum of the forces of all obstacles, in the frame of the robot. Neighbouring beams whose distances differ
-- by less than EDGE belong to one obstacle, regardless of their number.
local function repulsion(scan)
    local d, n, first = scan.distance, #scan.distance, 1
    for i = 1, n do
        if d[i] >= REACH then first = i break end       -- start outside of any obstacle
    end
    local fx, fy, nearest = 0, 0, nil
    for k = 0, n do
        local i = (first + k - 1) % n + 1
        local before = d[(i - 2) % n + 1]
        if nearest and (k == n or d[i] >= REACH or math.abs(d[i] - before) > EDGE) then
            local px, py = push(d[nearest], scan.angle[nearest])
            fx, fy, nearest = fx + px, fy + py, nil
        end
        if k < n and d[i] < REACH and (not nearest or d[i] < d[nearest]) then nearest = i end
    end
    return fx, fy
end

local function draw_arrow(drawing, x, y, fx, fy)
    local size = math.sqrt(fx * fx + fy * fy)
    local scale = ARROW * math.min(1, 2 / math.max(size, 1e-6))
    sim.addDrawingObjectItem(drawing, nil)
    sim.addDrawingObjectItem(drawing, {x, y, ARROW_Z, x + scale * fx, y + scale * fy, ARROW_Z})
end

local function decide(scan, x, y, heading, goal)
    local ax, ay = attraction(goal[1] - x, goal[2] - y)
    local c, s = math.cos(heading), math.sin(heading)
    local rx, ry = repulsion(scan)
    rx, ry = c * rx - s * ry, s * rx + c * ry
    -- The swirl: only around obstacles on the side of the goal.
    local against = -(rx * ax + ry * ay) / math.max(1e-6, math.sqrt((rx * rx + ry * ry) * (ax * ax + ay * ay)))
    local swirl = SWIRL * math.max(0, against)
    local sx, sy = -swirl * ry, swirl * rx
    local fx, fy = ax + rx + sx, ay + ry + sy
    draw_arrow(arrows.attraction, x, y, ax, ay)
    draw_arrow(arrows.repulsion, x, y, rx + sx, ry + sy)
    draw_arrow(arrows.total, x, y, fx, fy)
    local off = base.wrap(math.atan(fy, fx) - heading)
    want_turn = GAIN_TURN * off
    want_speed = SPEED * math.min(1, math.sqrt(fx * fx + fy * fy)) * math.max(0, math.cos(off)) ^ 2
end

function sysCall_actuation()
    local x, y, heading = base.odometry()
    local goal = places[math.floor(sim.getSimulationTime() / ROUND) % 2 + 1]
    local scan = base.new_scan()
    if scan then decide(scan, x, y, heading, goal) end
    if (goal[1] - x) ^ 2 + (goal[2] - y) ^ 2 < ARRIVED ^ 2 then want_speed, want_turn = 0, 0 end
    if (x - last_x) ^ 2 + (y - last_y) ^ 2 > 0.03 ^ 2 then
        sim.addDrawingObjectItem(trail, {last_x, last_y, 0.006, x, y, 0.006})
        last_x, last_y = x, y
    end
    base.drive(want_speed, want_turn)
end
