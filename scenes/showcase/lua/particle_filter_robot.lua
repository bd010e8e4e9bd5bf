-- Localizes the robot in a known apartment by a particle filter on laser and encoders, while it wanders about.
--
-- Monte Carlo localization with random particles against kidnapping (Augmented_MCL), the likelihood field of a scan and
-- the low-variance sampler: Thrun, Burgard, Fox, "Probabilistic Robotics", chapters 8.3, 6.4 and 4.3.

local plan = require 'apartment_plan'

local WHEEL_RADIUS = 0.033            -- m
local TRACK = 0.160                   -- m, between the wheels
local COUNTS_PER_TURN = 4096          -- of an encoder
local SCANNER_X = -0.032              -- m, of the scanner ahead of the axle
local SCAN_TIME = 0.2                 -- s from the first to the last beam

local LOST, SURE = 1500, 300          -- particles while the position is unknown, and once it is known
local SURE_SPREAD = 0.12              -- m; below this spread, the position is known
local BEAM_STEP = 30                  -- every 30th beam is used: 12 of 360
local RANGE = 1.3                     -- m; farther echoes are not used, so that many positions look alike at first
local CELL = 0.05                     -- m, of the likelihood field
local SIGMA_HIT = 0.08                -- m: standard deviation of a beam's end from a surface
local FLOOR = 0.05                    -- likelihood of an unmapped object, relative to a beam's end on a surface
local TEMPER = 0.2                    -- exponent of the likelihood: neighbouring beams do not err independently
local NOISE_WAY, NOISE_TURN = 0.10, 0.10      -- standard deviation of a motion, relative to its size
local LEAST_WAY, LEAST_TURN = 0.004, 0.015    -- m, rad: the minimum standard deviations of a motion
local SLOW, FAST = 0.03, 0.30         -- gains of the two averages of the weights, which show whether scans still fit
local RESAMPLE = 0.6                  -- minimum effective fraction of the particles; below it, they are resampled
local NEAR = 0.30                     -- m around the best particle, within which the estimate is averaged

local MAX_SPEED = 0.20                -- m/s
local SPOT_TURN = 1.0                 -- rad/s, on the spot
local HALF_LANE = 0.16                -- m: half the width of the lane that must be free
local STOP, GO = 0.32, 0.50           -- m ahead: an obstacle within STOP starts a turn; a lane free up to GO ends it
local SLOW_DOWN = 0.80                -- m ahead

local RED, GREEN, BLUE = {0.90, 0.12, 0.12}, {0.10, 0.65, 0.25}, {0.10, 0.40, 0.95}

function sysCall_init()
    left, right = sim.getObject(':/wheel_left_joint'), sim.getObject(':/wheel_right_joint')
    left_encoder, right_encoder = sim.getObject(':/wheel_left_encoder'), sim.getObject(':/wheel_right_encoder')
    scanner = sim.getObject(':/base_scan')
    cloud = sim.addDrawingObject(sim.drawing_lines, 2, 0, -1, 0, RED)
    scan_points = sim.addDrawingObject(sim.drawing_points, 6, 0, -1, 0, BLUE)
    mark = sim.addDrawingObject(sim.drawing_lines, 5, 0, -1, 0, GREEN)
    x, y, heading = 0, 0, 0           -- odometry, relative to the pose at the start
    history = {}
    scan_number = 0
    build_field()
    particles = {}
    for i = 1, LOST do particles[i] = anywhere() end
    weight_slow, weight_fast = 0, 0
    spread = math.huge
end

-- Map ------------------------------------------------------------------------

-- Computes the likelihood of a beam's end in each cell of the map, and the cells in which the robot can be.
function build_field()
    columns, rows = math.ceil(plan.width / CELL) + 4, math.ceil(plan.depth / CELL) + 4
    left_edge, bottom_edge = -columns * CELL / 2, -rows * CELL / 2
    field, places = {}, {}
    for index = 0, columns * rows - 1 do
        local px = left_edge + (index % columns + 0.5) * CELL
        local py = bottom_edge + (index // columns + 0.5) * CELL
        local distance = plan.distance(px, py)
        field[index] = math.log(FLOOR + math.exp(-distance * distance / (2 * SIGMA_HIT * SIGMA_HIT)))
        local inside = math.abs(px) < plan.width / 2 and math.abs(py) < plan.depth / 2
        if inside and distance > 0.12 then table.insert(places, {px, py}) end
    end
end

-- A particle is x, y (m), heading (rad), weight.
function anywhere()
    local place = places[math.random(#places)]
    return {place[1] + (math.random() - 0.5) * CELL, place[2] + (math.random() - 0.5) * CELL,
        (math.random() * 2 - 1) * math.pi, 1}
end

-- Odometry -------------------------------------------------------------------

local function integrate(now)
    local l, r = tatu.read(left_encoder).ticks, tatu.read(right_encoder).ticks
    local per_count = 2 * math.pi * WHEEL_RADIUS / COUNTS_PER_TURN
    local way_left, way_right = (l - (last_left or l)) * per_count, (r - (last_right or r)) * per_count
    last_left, last_right = l, r
    local ahead, turn = (way_left + way_right) / 2, (way_right - way_left) / TRACK
    x = x + ahead * math.cos(heading + turn / 2)
    y = y + ahead * math.sin(heading + turn / 2)
    heading = heading + turn
    table.insert(history, {time = now, x = x, y = y, heading = heading})
    if #history > 8 then table.remove(history, 1) end
end

-- Returns the pose at a time within the last few steps, interpolated between two stored poses.
local function pose_at(time)
    local after = #history
    while after > 2 and history[after - 1].time > time do after = after - 1 end
    local b = history[after]
    local a = history[math.max(1, after - 1)]
    local part = b.time > a.time and (time - a.time) / (b.time - a.time) or 1
    part = math.max(0, math.min(1, part))
    return a.x + part * (b.x - a.x), a.y + part * (b.y - a.y), a.heading + part * (b.heading - a.heading)
end

-- Filter ---------------------------------------------------------------------

local function gauss(sigma)
    return sigma * math.sqrt(-2 * math.log(1 - math.random())) * math.cos(2 * math.pi * math.random())
end

-- Returns the ends of some beams in the robot's frame. Each was sent from the pose at that time; the last one now.
local function beam_ends(scan, now)
    local ends, beams = {}, #scan.distance
    local c, s = math.cos(heading), math.sin(heading)
    for i = 1, beams, BEAM_STEP do
        local distance = scan.distance[i]
        if distance < RANGE then
            local px, py, h = pose_at(now - SCAN_TIME * (1 - (i - 1) / (beams - 1)))
            local a = h + scan.angle[i]
            local dx = px + SCANNER_X * math.cos(h) + distance * math.cos(a) - x
            local dy = py + SCANNER_X * math.sin(h) + distance * math.sin(a) - y
            table.insert(ends, {c * dx + s * dy, c * dy - s * dx})
        end
    end
    return ends
end

-- Moves all particles by the odometry's motion since the last scan, each with an independent random error.
local function move()
    local old = moved_from or {x, y, heading}
    moved_from = {x, y, heading}
    local dx, dy, turn = x - old[1], y - old[2], heading - old[3]
    local ahead = dx * math.cos(old[3] + turn / 2) + dy * math.sin(old[3] + turn / 2)
    local sigma_way = NOISE_WAY * math.abs(ahead) + LEAST_WAY
    local sigma_turn = NOISE_TURN * math.abs(turn) + LEAST_TURN
    for _, p in ipairs(particles) do
        local way, by = ahead + gauss(sigma_way), turn + gauss(sigma_turn)
        p[1] = p[1] + way * math.cos(p[3] + by / 2)
        p[2] = p[2] + way * math.sin(p[3] + by / 2)
        p[3] = p[3] + by
    end
end

local function likelihood(p, ends)
    local c, s, sum = math.cos(p[3]), math.sin(p[3]), 0
    local px, py = (p[1] - left_edge) / CELL, (p[2] - bottom_edge) / CELL
    c, s = c / CELL, s / CELL
    local outside = math.log(FLOOR)
    for _, e in ipairs(ends) do
        local column, row = (px + c * e[1] - s * e[2]) // 1, (py + s * e[1] + c * e[2]) // 1
        if column >= 0 and column < columns and row >= 0 and row < rows then
            sum = sum + field[row * columns + column]
        else
            sum = sum + outside
        end
    end
    return math.exp(TEMPER * sum)
end

-- Weights the particles by the scan, and tracks how well scans fit: if they fit worse than before, some particles must
-- be placed at random. Returns the fraction of such particles.
local function weigh(ends)
    local total, fit = 0, 0
    for _, p in ipairs(particles) do
        local value = likelihood(p, ends)
        fit = fit + value
        p[4] = p[4] * value
        total = total + p[4]
    end
    for _, p in ipairs(particles) do p[4] = p[4] / total end
    fit = fit / #particles
    weight_slow = weight_slow + SLOW * (fit - weight_slow)
    weight_fast = weight_fast + FAST * (fit - weight_fast)
    return math.max(0, 1 - weight_fast / weight_slow)
end

-- Resamples particles in proportion to their weights, at equal distances along the sum of the weights.
local function resample(count, random_part)
    local drawn, i = {}, 1
    local at, sum = math.random() / count, particles[1][4]
    for _ = 1, count do
        while at > sum and i < #particles do
            i = i + 1
            sum = sum + particles[i][4]
        end
        local p = particles[i]
        table.insert(drawn, math.random() < random_part and anywhere() or {p[1], p[2], p[3], 1})
        at = at + 1 / count
    end
    for _, p in ipairs(drawn) do p[4] = 1 / count end
    particles = drawn
end

local function carrying()
    local squares = 0
    for _, p in ipairs(particles) do squares = squares + p[4] * p[4] end
    return 1 / squares
end

-- Returns the mean of the particles near the best one, and the spread of all.
local function estimate()
    local best = particles[1]
    for _, p in ipairs(particles) do if p[4] > best[4] then best = p end end
    local total, mx, my, mc, ms, square = 0, 0, 0, 0, 0, 0
    for _, p in ipairs(particles) do
        local dx, dy = p[1] - best[1], p[2] - best[2]
        square = square + p[4] * (dx * dx + dy * dy)
        if dx * dx + dy * dy < NEAR * NEAR then
            local w = p[4]
            total, mx, my = total + w, mx + w * p[1], my + w * p[2]
            mc, ms = mc + w * math.cos(p[3]), ms + w * math.sin(p[3])
        end
    end
    guess = {mx / total, my / total, math.atan(ms, mc)}
    spread = math.sqrt(square)
end

local function localize(scan, now)
    local ends = beam_ends(scan, now)
    move()
    local random_part = weigh(ends)
    estimate()
    if random_part > 0.05 or carrying() < RESAMPLE * #particles then
        local count = random_part < 0.05 and spread < SURE_SPREAD and SURE or LOST
        resample(count, random_part)
    end
    return ends
end

-- Driving --------------------------------------------------------------------

-- Returns the free length of the lane ahead (m), and the side with more room: 1 left, -1 right.
local function look(scan)
    local free, room = math.huge, 0
    for i, distance in ipairs(scan.distance) do
        local a = scan.angle[i]
        if math.abs(a) < math.pi / 2 and distance < math.huge then
            local ahead, aside = distance * math.cos(a), distance * math.sin(a)
            if math.abs(aside) < HALF_LANE then free = math.min(free, ahead) end
            room = room + (a > 0 and 1 or -1) * math.min(distance, 1)
        end
    end
    return free, room > 0 and 1 or -1
end

-- Drives on, and turns on the spot in front of obstacles; a chosen side is retained until the lane is free.
local function wander(scan)
    local free, roomy = look(scan)
    if free < STOP or (side and free < GO) then
        side = side or roomy
        return 0, side * SPOT_TURN
    end
    side = nil
    return MAX_SPEED * math.max(0.3, math.min(1, (free - STOP) / (SLOW_DOWN - STOP))), 0
end

-- Drawing --------------------------------------------------------------------

local function draw(ends)
    local items = {}
    for i, p in ipairs(particles) do
        local n = 6 * (i - 1)
        items[n + 1], items[n + 2], items[n + 3] = p[1], p[2], 0.02
        items[n + 4], items[n + 5], items[n + 6] = p[1] + 0.10 * math.cos(p[3]), p[2] + 0.10 * math.sin(p[3]), 0.02
    end
    sim.addDrawingObjectItem(cloud, nil)
    sim.addDrawingObjectItem(cloud, items)

    local gx, gy, c, s = guess[1], guess[2], math.cos(guess[3]), math.sin(guess[3])
    sim.addDrawingObjectItem(scan_points, nil)
    for _, e in ipairs(ends) do
        sim.addDrawingObjectItem(scan_points, {gx + c * e[1] - s * e[2], gy + s * e[1] + c * e[2], 0.32})
    end
    sim.addDrawingObjectItem(mark, nil)
    local radius, corners, z = 0.16, 16, 0.24
    for i = 1, corners do
        local a, b = 2 * math.pi * i / corners, 2 * math.pi * (i + 1) / corners
        sim.addDrawingObjectItem(mark, {gx + radius * math.cos(a), gy + radius * math.sin(a), z,
            gx + radius * math.cos(b), gy + radius * math.sin(b), z})
    end
    sim.addDrawingObjectItem(mark, {gx, gy, z, gx + 0.28 * c, gy + 0.28 * s, z})
end

-- Steps ----------------------------------------------------------------------

function sysCall_sensing()
    local now = sim.getSimulationTime() + sim.getSimulationTimeStep()      -- sensors measure at the end of the step
    integrate(now)
    local scan = tatu.read(scanner)
    if scan.sequence == scan_number then return end
    scan_number = scan.sequence
    speed, turn = wander(scan)
    if #history < 5 then return end       -- without a history, the beams of a scan have no poses
    draw(localize(scan, now))
    -- For the referee.
    sim.setFloatSignal('guess_x', guess[1])
    sim.setFloatSignal('guess_y', guess[2])
    sim.setFloatSignal('guess_heading', guess[3])
    sim.setFloatSignal('spread', spread)
    sim.setInt32Signal('particles', #particles)
end

function sysCall_actuation()
    if not speed then return end
    sim.setJointTargetVelocity(left, (speed - turn * TRACK / 2) / WHEEL_RADIUS)
    sim.setJointTargetVelocity(right, (speed + turn * TRACK / 2) / WHEEL_RADIUS)
end
