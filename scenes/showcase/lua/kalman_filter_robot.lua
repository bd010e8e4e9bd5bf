-- Estimates the robot's pose by an extended Kalman filter, and steers along a figure of eight by the estimate.
--
-- State: x, y (m), heading (rad), offset of the gyroscope (rad/s).
-- Prediction: distance from the encoders, turn from the gyroscope.  Correction: position from the GPS.
-- Equations: Thrun, Burgard, Fox, "Probabilistic Robotics", chapter 3.3; the gate: chapter 7.

local Matrix = require 'matrix'

local WHEEL_RADIUS = 0.0975           -- m; as the data sheet states it, for both wheels
local TRACK = 0.331                   -- m, between the wheels
local COUNTS_PER_TURN = 76600         -- of an encoder, per turn of the wheel

-- Assumed uncertainty of the sensors: standard deviations.
local SIGMA_WAY = 0.02                -- m per square root of a metre rolled
local SIGMA_TURN = 0.003              -- rad per square root of a second
local SIGMA_DRIFT = 1e-4              -- rad/s per square root of a second, of the gyroscope's offset
local SIGMA_GPS = 0.4                 -- m, along x and y
local START_POSITION = 0.3            -- m
local START_HEADING = 0.1             -- rad
local START_OFFSET = 0.02             -- rad/s
local GATE = 9.21                     -- squared Mahalanobis distance that 1 % of good fixes exceed (chi-square)
local ELLIPSE = 5.99                  -- the distance for 5 %: the size of the drawn ellipse

local SPEED = 0.80                    -- m/s
local ACCELERATION = 0.5              -- m/s^2
local MAX_TURN = 1.2                  -- rad/s
local LENGTH, WIDTH = 5.0, 2.5        -- m, half the extents of the eight
local LOOK_AHEAD = 0.8                -- m
local PERIODS = 2                     -- eights until the run restarts
local STANDSTILL = 4.0                -- s at the start, in which fixes are collected
local HEADING = math.pi / 4           -- rad, at the start: a mark on the ground

local ORANGE, BLUE, MAGENTA = {1.0, 0.55, 0.10}, {0.25, 0.55, 1.0}, {0.85, 0.20, 0.75}

function sysCall_init()
    left, right = sim.getObject(':/Pioneer_p3dx_leftMotor'), sim.getObject(':/Pioneer_p3dx_rightMotor')
    left_encoder, right_encoder = sim.getObject(':/left_encoder'), sim.getObject(':/right_encoder')
    imu, gps = sim.getObject(':/imu'), sim.getObject(':/gps')
    odometry_trail = sim.addDrawingObject(sim.drawing_lines, 2, 0, -1, 0, ORANGE)
    trail = sim.addDrawingObject(sim.drawing_lines, 3, 0, -1, 0, MAGENTA)
    ellipse = sim.addDrawingObject(sim.drawing_lines, 3, 0, -1, 0, MAGENTA)
    fixes = sim.addDrawingObject(sim.drawing_points, 5, 0, -1, 0, BLUE)
    run, speed, fix = 0, 0, 0
    first_x, first_y = {}, {}         -- m, of the fixes at the start
end

-- Sensors --------------------------------------------------------------------

-- Returns the distance (m) and turn (rad) that the wheels have rolled since the last call.
local function rolled()
    local l, r = tatu.read(left_encoder).ticks, tatu.read(right_encoder).ticks
    local per_count = 2 * math.pi * WHEEL_RADIUS / COUNTS_PER_TURN
    local way_left, way_right = (l - (last_left or l)) * per_count, (r - (last_right or r)) * per_count
    last_left, last_right = l, r
    return (way_left + way_right) / 2, (way_right - way_left) / TRACK
end

-- Returns a new fix of the GPS, x and y in m, or nil.
local function new_fix()
    local reading = tatu.read(gps)
    if reading.sequence == fix then return end
    fix = reading.sequence
    if reading.valid == 1 then return reading.position[1], reading.position[2] end
end

-- Filter ---------------------------------------------------------------------

local function predict(way, rate, dt)
    local turn = (rate - state:get(4)) * dt
    local h = state:get(3) + turn / 2
    local c, s = math.cos(h), math.sin(h)
    state = state + Matrix{way * c, way * s, turn, 0}
    -- Derivatives of the new state by the old one, and by the errors of distance and turn.
    local F = Matrix{
        {1, 0, -way * s, way * s * dt / 2},
        {0, 1, way * c, -way * c * dt / 2},
        {0, 0, 1, -dt},
        {0, 0, 0, 1},
    }
    local G = Matrix{{c, -way * s / 2}, {s, way * c / 2}, {0, 1}, {0, 0}}
    local Q = Matrix.diag{SIGMA_WAY ^ 2 * math.abs(way), SIGMA_TURN ^ 2 * dt}
    P = F * P * F:t() + G * Q * G:t() + Matrix.diag{0, 0, 0, SIGMA_DRIFT ^ 2 * dt}
end

local H = Matrix{{1, 0, 0, 0}, {0, 1, 0, 0}}
local R = Matrix.diag{SIGMA_GPS ^ 2, SIGMA_GPS ^ 2}

local function correct(x, y)
    local innovation = Matrix{x, y} - H * state
    local S = H * P * H:t() + R
    if innovation:dot(S:solve(innovation)) > GATE then return end   -- a reflection, most likely
    local K = S:solve(H * P):t()
    state = state + K * innovation
    local rest = Matrix.eye(4) - K * H
    P = rest * P * rest:t() + K * R * K:t()      -- Joseph form: P stays symmetric and positive definite
end

-- Course ---------------------------------------------------------------------

local function eight(phase)
    return LENGTH * math.sin(phase), WIDTH * math.sin(2 * phase)
end

-- Moves the pursued point along the course until it is LOOK_AHEAD away, and turns towards it.
local function steer(x, y, heading)
    local tx, ty = eight(phase)
    while math.sqrt((tx - x) ^ 2 + (ty - y) ^ 2) < LOOK_AHEAD do
        phase = phase + 0.01
        tx, ty = eight(phase)
    end
    local bearing = math.atan(ty - y, tx - x) - heading
    bearing = math.atan(math.sin(bearing), math.cos(bearing))
    return math.max(-MAX_TURN, math.min(MAX_TURN, 2 * speed * math.sin(bearing) / LOOK_AHEAD))
end

local function drive(wanted, turn)
    local most = ACCELERATION * sim.getSimulationTimeStep()
    speed = speed + math.max(-most, math.min(most, wanted - speed))
    sim.setJointTargetVelocity(left, (speed - turn * TRACK / 2) / WHEEL_RADIUS)
    sim.setJointTargetVelocity(right, (speed + turn * TRACK / 2) / WHEEL_RADIUS)
end

-- Drawing --------------------------------------------------------------------

local function draw_ellipse()
    local x, y = state:get(1), state:get(2)
    local values, axes = Matrix{{P:get(1, 1), P:get(1, 2)}, {P:get(2, 1), P:get(2, 2)}}:eigen()
    local a, b = math.sqrt(ELLIPSE * values[1]), math.sqrt(ELLIPSE * values[2])
    local last
    sim.addDrawingObjectItem(ellipse, nil)
    for i = 0, 32 do
        local u, v = a * math.cos(i * math.pi / 16), b * math.sin(i * math.pi / 16)
        local point = {x + u * axes:get(1, 1) + v * axes:get(1, 2), y + u * axes:get(2, 1) + v * axes:get(2, 2), 0.04}
        if last then
            sim.addDrawingObjectItem(ellipse, {last[1], last[2], last[3], point[1], point[2], point[3]})
        end
        last = point
    end
    local h = state:get(3)
    sim.addDrawingObjectItem(ellipse, {x, y, 0.3, x + 0.5 * math.cos(h), y + 0.5 * math.sin(h), 0.3})
end

local function draw()
    draw_ellipse()
    local x, y = state:get(1), state:get(2)
    if math.abs(x - drawn[1]) + math.abs(y - drawn[2]) > 0.08 then
        sim.addDrawingObjectItem(trail, {drawn[1], drawn[2], 0.03, x, y, 0.03})
        sim.addDrawingObjectItem(odometry_trail, {drawn[3], drawn[4], 0.02, odometry.x, odometry.y, 0.02})
        drawn = {x, y, odometry.x, odometry.y}
    end
end

-- Steps ----------------------------------------------------------------------

-- For the referee.
local function publish()
    sim.setInt32Signal('run', run)
    sim.setFloatSignal('odometry_x', odometry.x)
    sim.setFloatSignal('odometry_y', odometry.y)
    sim.setFloatSignal('ekf_x', state:get(1))
    sim.setFloatSignal('ekf_y', state:get(2))
end

-- Odometry starts at the filter's estimate, so that both start with the same error.
local function begin_run()
    run = run + 1
    phase = 0
    odometry = {x = state:get(1), y = state:get(2), heading = state:get(3)}
    drawn = {odometry.x, odometry.y, odometry.x, odometry.y}
    for _, drawing in ipairs{trail, odometry_trail, fixes} do sim.addDrawingObjectItem(drawing, nil) end
    publish()
end

local function median(numbers)
    table.sort(numbers)
    return numbers[math.ceil(#numbers / 2)]
end

-- At the start, the robot stands still and uses the median of its fixes, which is robust to reflections.
local function stand()
    local x, y = new_fix()
    if x then
        table.insert(first_x, x)
        table.insert(first_y, y)
    end
    if sim.getSimulationTime() < STANDSTILL then return end
    state = Matrix{median(first_x), median(first_y), HEADING, 0}
    P = Matrix.diag{START_POSITION ^ 2, START_POSITION ^ 2, START_HEADING ^ 2, START_OFFSET ^ 2}
    begin_run()
end

function sysCall_actuation()
    if run == 0 then return end
    if phase > 2 * math.pi * PERIODS then begin_run() end
    drive(SPEED, steer(state:get(1), state:get(2), state:get(3)))
end

function sysCall_sensing()
    local way, turn = rolled()
    if run == 0 then return stand() end
    local mean = odometry.heading + turn / 2
    odometry.x = odometry.x + way * math.cos(mean)
    odometry.y = odometry.y + way * math.sin(mean)
    odometry.heading = odometry.heading + turn

    predict(way, tatu.read(imu).angular_velocity[3], sim.getSimulationTimeStep())
    local x, y = new_fix()
    if x then
        correct(x, y)
        sim.addDrawingObjectItem(fixes, {x, y, 0.05})
    end
    draw()
    publish()
end
