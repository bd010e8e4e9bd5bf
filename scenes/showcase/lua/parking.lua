-- A car parks in parallel, backwards, between two parked cars, and leaves again.
--
-- Frame: the row of parked cars is the line y = 0, x points along the row; the robot is to the left of it. The encoders
-- of the rear wheels and the gyroscope predict the pose of the rear axle; a line fitted to the laser points on the
-- sides of the cars corrects y and the heading. The beam straight to the right detects the edges of the gap.
--
-- The rear wheels cannot measure the heading: they slip in a bend, because the motor drives both at the same speed.
--
-- Path: two tangent arcs of the same radius, first to the right, then to the left, each through the angle theta. They
-- shift the car sideways by 2 R (1 - cos theta), and back by 2 R sin theta.

local WHEELBASE = 0.3302        -- m
local RADIUS = 0.05             -- m, of the wheels
local HALF_WIDTH = 0.155        -- m, of the car
local REAR, FRONT = 0.12, 0.46  -- m, from the rear axle to the bumpers
local SCANNER_X = 0.265         -- m, ahead of the rear axle

local LANE = 0.36               -- m from the row, while searching
local TURN_RADIUS = 0.80        -- m, of the arcs
local LEAST_RADIUS = 0.745      -- m: minimum turning radius of the car
local STEER = math.atan(WHEELBASE / TURN_RADIUS)
local STEER_MOST = 0.418        -- rad
local LEAST_GAP = 1.08          -- m, for one move backwards; the car is 0.58 m long
local BEHIND = 0.09             -- m to the car behind, at the end of the second arc
local BEHIND_OUT = 0.06         -- m to the car behind, before leaving
local SEARCH, PARK, RETURN = 0.45, 0.3, 0.6     -- m/s
local BRAKE = 0.5               -- m/s^2
local LAG = 0.2                 -- s: the car follows a new speed with this time constant
local CREEP = 0.04              -- m/s: minimum speed
local SETTLE = 0.35             -- s: standstill while the wheels are steered
local PARKED = 4.0              -- s
local EDGE = 0.15               -- m: points this much farther away than the row belong to the gap
local FIRST = 0.3               -- m: edges at smaller x are ignored

local GREEN, BLUE, ORANGE = {0.15, 0.70, 0.30}, {0.15, 0.40, 0.90}, {0.95, 0.45, 0.10}

local function limit(value, most)
    return math.max(-most, math.min(most, value))
end

function sysCall_init()
    motor, servo = sim.getObject(':/motor_joint'), sim.getObject(':/steering_joint')
    laser, imu = sim.getObject(':/laser'), sim.getObject(':/imu')
    encoders = {sim.getObject(':/left_encoder'), sim.getObject(':/right_encoder')}
    turned = {0, 0}
    x, y, heading = 0, LANE, 0
    gap_drawing = sim.addDrawingObject(sim.drawing_lines, 5, 0, -1, 0, GREEN)
    plan_drawing = sim.addDrawingObject(sim.drawing_lines, 3, 0, -1, 0, BLUE)
    trail = sim.addDrawingObject(sim.drawing_lines + sim.drawing_cyclic, 3, 0, -1, 400, ORANGE)
    last_x, last_y, seen, front = x, y, 0, math.huge
    bias, samples = 0, 0        -- rad/s: reading of the gyroscope at rest
    state, since = 'rest', 0
end

---------------------------------------------------------------------------------------------------------- localization

local function predict()
    local ahead = 0
    for i, encoder in ipairs(encoders) do
        local at = tatu.read(encoder).position
        ahead, turned[i] = ahead + (at - turned[i]) * RADIUS / 2, at
    end
    velocity = ahead / sim.getSimulationTimeStep()
    local rate = tatu.read(imu).angular_velocity[3]
    if state == 'rest' then     -- at rest, the reading of the gyroscope is its bias
        samples = math.min(samples + 1, 500)
        bias = bias + (rate - bias) / samples
    end
    local turn = (rate - bias) * sim.getSimulationTimeStep()
    x, y = x + ahead * math.cos(heading + turn / 2), y + ahead * math.sin(heading + turn / 2)
    heading = heading + turn
end

-- Returns the distance of the rear axle to the row, and the heading relative to it, by least squares through the points
-- of the row, or nil if there are too few points.
local function fit_row(scan)
    local points, nearest = {}, math.huge
    for i = 1, #scan.distance // 2, 3 do
        local a, d = scan.angle[i], scan.distance[i]
        if a < math.rad(-40) and a > math.rad(-125) and d < 1.2 then
            local p = {SCANNER_X + d * math.cos(a), -d * math.sin(a)}
            points[#points + 1] = p
            nearest = math.min(nearest, p[2])
        end
    end
    local n, sx, sy, sxx, sxy, low, high = 0, 0, 0, 0, 0, math.huge, -math.huge
    for _, p in ipairs(points) do
        if p[2] < nearest + 0.07 then
            n, sx, sy, sxx, sxy = n + 1, sx + p[1], sy + p[2], sxx + p[1] * p[1], sxy + p[1] * p[2]
            low, high = math.min(low, p[1]), math.max(high, p[1])
        end
    end
    if n < 20 or high - low < 0.25 then return nil end
    local slope = (n * sxy - sx * sy) / (n * sxx - sx * sx)
    local angle = math.atan(slope)
    return (sy - slope * sx) / n * math.cos(angle), angle
end

-- Only while driving along the row: in the gap, the sides of the cars are not beside the robot.
local function correct(scan)
    local row, angle = fit_row(scan)
    if not row or math.abs(row - y) > 0.15 or math.abs(angle - heading) > 0.15 then return end
    y, heading = y + 0.15 * (row - y), heading + 0.1 * (angle - heading)
end

-- Returns the mean distance of five beams around a direction, m.
local function beam(scan, angle)
    local middle, sum = math.floor((angle - scan.angle[1]) / (scan.angle[2] - scan.angle[1]) + 0.5) + 1, 0
    for i = middle - 2, middle + 2 do sum = sum + math.min(3, scan.distance[i]) end
    return sum / 5
end

-------------------------------------------------------------------------------------------------------------- planning

local function draw_gap()
    sim.addDrawingObjectItem(gap_drawing, nil)
    for _, at in ipairs{gap_from, gap_to} do
        sim.addDrawingObjectItem(gap_drawing, {at, 0.05, 0.01, at, -2 * HALF_WIDTH, 0.01})
    end
end

-- Draws the path of the rear axle: the arcs backwards from (x, y) with heading 0.
local function plan()
    local aside = y + HALF_WIDTH
    theta = math.acos(1 - aside / (2 * TURN_RADIUS))
    sim.addDrawingObjectItem(plan_drawing, nil)
    local px, py = x, y
    for i = 1, 40 do
        local t = theta * (i <= 20 and i or 40 - i) / 20
        local nx = i <= 20 and x - TURN_RADIUS * math.sin(t) or x - TURN_RADIUS * (2 * math.sin(theta) - math.sin(t))
        local ny = i <= 20 and y - TURN_RADIUS * (1 - math.cos(t)) or
            y - aside + TURN_RADIUS * (1 - math.cos(t))
        sim.addDrawingObjectItem(plan_drawing, {px, py, 0.012, nx, ny, 0.012})
        px, py = nx, ny
    end
end

-- Returns where the rear axle must stop before reversing, so that the second arc ends at BEHIND from the car behind.
local function start_of_arcs()
    local angle = math.acos(1 - (LANE + HALF_WIDTH) / (2 * TURN_RADIUS))
    return gap_from + BEHIND + REAR + 2 * TURN_RADIUS * math.sin(angle)
end

-- Steering along the line y = LANE. `way`: 1 forward, -1 backwards, where steering turns the car the other way.
local function along_lane(way)
    return limit(-1.5 * (y - LANE) - way * 1.2 * heading, 0.3)
end

-- Returns a speed from which the car can stop within a distance, and whether to stop now.
local function approach(speed, distance)
    distance = distance - LAG * math.abs(velocity)
    return math.max(CREEP, math.min(speed, math.sqrt(2 * BRAKE * math.max(0, distance)))), distance < 0.003
end

-- Each state function returns speed (m/s), steering (rad) and the next state. `lasted`: s since the state began.
local states = {}
local LOOKS = {search = true, pass = true, centre = true, again = true}     -- states that use the laser

function states.search(lasted, scan)
    correct(scan)
    local at, depth = x + SCANNER_X, beam(scan, -math.pi / 2) - y
    if at < FIRST then gap_from = nil end
    if depth > EDGE then
        if not gap_from and at > FIRST then gap_from = at end
    elseif gap_from then
        gap_to = at
        if gap_to - gap_from > LEAST_GAP then
            print(string.format('gap of %.2f m found', gap_to - gap_from))
            draw_gap()
            return SEARCH, along_lane(1), 'pass'
        end
        gap_from = nil          -- too short
    end
    return SEARCH, along_lane(1), 'search'
end

function states.pass(lasted, scan)
    correct(scan)
    local speed, there = approach(SEARCH, start_of_arcs() - x)
    if there then
        plan()
        return 0, -STEER, 'arc_right'
    end
    return speed, along_lane(1), 'pass'
end

function states.arc_right(lasted)
    if lasted < SETTLE then return 0, -STEER, 'arc_right' end
    -- This arc ends where an arc to the left leads to the middle of the row.
    -- Both arcs contribute equally to the remaining shift, so this one accounts for half of it.
    local aside = (y + HALF_WIDTH - TURN_RADIUS * (1 - math.cos(heading))) / 2
    local speed, there = approach(PARK, aside / math.max(0.1, math.sin(heading)))
    if there then return 0, STEER, 'arc_left' end
    return -speed, -STEER, 'arc_right'
end

function states.arc_left(lasted)
    if lasted < SETTLE then return 0, STEER, 'arc_left' end
    -- The radius of the arc from here to the middle of the row corrects the error of the first arc.
    local radius = (y + HALF_WIDTH) / math.max(1e-4, 1 - math.cos(heading))
    local steer = heading > 0.15 and math.atan(WHEELBASE / math.max(LEAST_RADIUS, radius)) or STEER
    local speed, there = approach(PARK, heading * TURN_RADIUS)
    if there then return 0, 0, 'centre' end
    return -speed, steer, 'arc_left'
end

-- Forward, until the distances ahead and behind are equal.
function states.centre(lasted, scan)
    if lasted < SETTLE then return 0, 0, 'centre' end
    local room = (gap_to - gap_from - FRONT - REAR) / 2
    local speed, there = approach(PARK, beam(scan, 0) - (FRONT - SCANNER_X) - room)
    if there then
        print('parked')
        return 0, 0, 'parked'
    end
    return speed, limit(-3 * (y + HALF_WIDTH) - 1.5 * heading, 0.35), 'centre'
end

function states.parked(lasted)
    return 0, 0, lasted > PARKED and 'back' or 'parked'
end

function states.back()
    local speed, there = approach(PARK, x - (gap_from + BEHIND_OUT + REAR))
    if there then return 0, STEER_MOST, 'out_left' end
    return -speed, 0, 'back'
end

function states.out_left(lasted)
    if lasted < SETTLE then return 0, STEER_MOST, 'out_left' end
    local speed, there = approach(PARK, (theta - heading) * TURN_RADIUS)
    if there then return 0, -STEER, 'out_right' end
    return speed, STEER_MOST, 'out_left'
end

function states.out_right(lasted)
    if lasted < SETTLE then return 0, -STEER, 'out_right' end
    local speed, there = approach(PARK, heading * TURN_RADIUS)
    if there then return 0, 0, 'again' end
    return speed, -STEER, 'out_right'
end

-- Backwards along the row to the starting position.
function states.again(lasted, scan)
    if lasted < SETTLE then return 0, 0, 'again' end
    correct(scan)
    local speed, there = approach(RETURN, x)
    if there then
        gap_from = nil
        sim.addDrawingObjectItem(gap_drawing, nil)
        sim.addDrawingObjectItem(plan_drawing, nil)
        return 0, 0, 'rest'
    end
    return -speed, along_lane(-1), 'again'
end

function states.rest(lasted)
    return 0, 0, lasted > 1.5 and 'search' or 'rest'
end

function sysCall_actuation()
    local now = sim.getSimulationTime()
    if tatu.read(imu).sequence == 0 then return end     -- in the first step, nothing has been measured yet
    predict()
    local scan = LOOKS[state] and tatu.read(laser)
    local speed, steer, next_state = states[state](now - since, scan)
    if next_state ~= state then state, since = next_state, now end
    sim.setJointTargetVelocity(motor, speed / RADIUS)
    sim.setJointTargetPosition(servo, steer)
    if (x - last_x) ^ 2 + (y - last_y) ^ 2 > 0.02 ^ 2 then
        sim.addDrawingObjectItem(trail, {last_x, last_y, 0.008, x, y, 0.008})
        last_x, last_y = x, y
    end
end
