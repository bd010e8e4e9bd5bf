-- The NXTway-GS balances on two wheels, drives a slalom between poles and withstands pushes.
--
-- Balance, in each physics step: a linear-quadratic regulator, computed here from the constants of the robot. Pitch is
-- the integrated gyroscope rate; wheel angles are measured by encoders.
-- Localization, in each scene step: an extended Kalman filter predicts with the encoders and corrects with a beacon
-- that reports the robot's position to within centimetres (Thrun, Burgard, Fox, "Probabilistic Robotics", chapter 3).

local Matrix = require 'matrix'

-- The robot: NXTway-GS model constants, Y. Yamamoto, 2008.
local GRAVITY = 9.81            -- m/s^2
local RADIUS = 0.04             -- m, of the wheels
local WHEEL_MASS = 0.03         -- kg
local BODY_MASS = 0.6           -- kg
local BODY_HEIGHT = 0.072       -- m: centre of mass above the axle
local BODY_INERTIA = BODY_MASS * BODY_HEIGHT ^ 2 / 3        -- kg m^2, about its centre of mass
local WHEEL_INERTIA = WHEEL_MASS * RADIUS ^ 2 / 2           -- kg m^2
local ROTOR = 1e-5              -- kg m^2, of a motor
local KT, KB, OHM, FRICTION = 0.317, 0.468, 6.69, 0.0022    -- N m/A, V s/rad, ohm, N m s/rad: of a motor
local SUPPLY = 8.0              -- V
local WIDTH = 0.1423            -- m: between the wheels, as calibrated by turning

-- Weights of the regulator: angle of the wheels, pitch, their rates; voltage.
local STATE_WEIGHT, VOLTAGE_WEIGHT = {1, 1000, 1, 1}, 100
local TURN_GAIN = 3.0           -- V per rad of error of the angle between right and left wheel
local SMOOTH_TIME = 0.0072      -- s: filter time constant of the encoder angle, which is quantized to whole degrees
local CORRECTION = 1.5e-4       -- rad/s of pitch per rad of the wheels: compensates for the drift of the gyroscope
local ACCELERATION = 4.0        -- rad/s^2 of the wheels: maximum rate of change of the target speeds

-- The filter: standard deviations.
local WAY_SIGMA = 0.02          -- relative, of the distance driven
local SLIP_SIGMA = 0.05         -- rad of heading for each rad turned
local WANDER_SIGMA = 0.004      -- m, rad in each step
local BEACON_SIGMA = 0.02       -- m

-- The course: a slalom to the far end and back, between poles on the x axis.
local POLES, SPACING = 3, 0.7          -- count; m, also from the start to the first pole
local SWING = 0.34              -- m: maximum distance from the line of the poles
local SPEED = 0.28              -- m/s
local LOOK_AHEAD = 0.16         -- m: distance of the point of the course that the robot drives towards
local BEARING_GAIN = 2.5        -- 1/s
local TURN_MOST = 2.0           -- rad/s

local left, right, left_encoder, right_encoder, gyro, beacon, trail
local gain, forward
local pitch, smooth, wheel_goal, turn_goal = 0, nil, 0, 0    -- rad
local speed, turn, want_speed, want_turn = 0, 0, 0, 0       -- rad/s: mean of the wheels, right minus left
local way_angle, way_difference = 0, 0                      -- rad: current mean and difference of the wheels
local x, P                                                  -- the filter's state x, y, heading and its covariance
local last_angle, last_difference, last_fix = 0, 0, 0
local course, at = {}, 1

local function clamp(value, most) return math.max(-most, math.min(most, value)) end
local function toward(value, goal, most) return value + clamp(goal - value, most) end
local function wrapped(angle) return (angle + math.pi) % (2 * math.pi) - math.pi end

-- Balance -------------------------------------------------------------------------------------------------------------

-- The linear model dx/dt = A x + B u of the upright robot: x contains the angle of the wheels in the world, the pitch,
-- and their rates; u is the voltage of both motors.
local function linear_model()
    local torque, brake = KT / OHM, KT * KB / OHM + FRICTION      -- N m/V, N m s/rad: of a motor
    local couple = BODY_MASS * BODY_HEIGHT * RADIUS - 2 * ROTOR
    local inertia = Matrix{
        {(2 * WHEEL_MASS + BODY_MASS) * RADIUS ^ 2 + 2 * WHEEL_INERTIA + 2 * ROTOR, couple},
        {couple, BODY_MASS * BODY_HEIGHT ^ 2 + BODY_INERTIA + 2 * ROTOR},
    }
    local tip = inertia:solve(Matrix{0, BODY_MASS * GRAVITY * BODY_HEIGHT})
    local drag = inertia:solve(Matrix{-2 * brake, 2 * brake})
    local push = inertia:solve(Matrix{2 * torque, -2 * torque})
    local A = Matrix{
        {0, 0, 1, 0},
        {0, 0, 0, 1},
        {0, tip:get(1), drag:get(1), -drag:get(1)},
        {0, tip:get(2), drag:get(2), -drag:get(2)},
    }
    return A, Matrix{0, 0, push:get(1), push:get(2)}
end

-- The exact model over a time step with constant voltage: the exponential of [A B; 0 0].
local function over_step(A, B, dt)
    local rows = {}
    for i = 1, 4 do
        rows[i] = {}
        for k = 1, 4 do rows[i][k] = A:get(i, k) * dt end
        rows[i][5] = B:get(i) * dt
    end
    rows[5] = {0, 0, 0, 0, 0}
    local E, a, b = Matrix(rows):exp(), {}, {}
    for i = 1, 4 do
        a[i] = {}
        for k = 1, 4 do a[i][k] = E:get(i, k) end
        b[i] = E:get(i, 5)
    end
    return Matrix(a), Matrix(b)
end

-- The gain of the regulator: Riccati's equation, iterated until convergence.
local function lqr(A, B, Q, R)
    local P = Q
    for _ = 1, 20000 do
        local K = (R + B:t() * P * B):solve(B:t() * P * A)
        local next = Q + A:t() * P * (A - B * K)
        if (next - P):norm() < 1e-7 * P:norm() then return K end
        P = next
    end
    error('the regulator was not found: the equation of Riccati does not converge')
end

-- Runs one step of balancing: reads gyroscope and encoders, and sets the voltage of the motors.
function sysCall_dyn(step)
    if step.afterStep then return end
    local l, r, g = tatu.read(left_encoder), tatu.read(right_encoder), tatu.read(gyro)
    if l.sequence == 0 or r.sequence == 0 or g.sequence == 0 then return end
    local dt, pitch_rate = step.dt, g.angular_velocity[2]
    -- Encoders measure the wheels relative to the body, which is pitched.
    local angle, difference = (l.position + r.position) / 2, r.position - l.position
    smooth = smooth or angle
    local before = smooth
    smooth = smooth + (1 - math.exp(-dt / SMOOTH_TIME)) * (angle - smooth)
    local wheel, wheel_rate = smooth + pitch, (smooth - before) / dt + pitch_rate
    way_angle, way_difference = wheel, difference

    speed = toward(speed, want_speed, ACCELERATION * dt)
    turn = toward(turn, want_turn, 4 * ACCELERATION * dt)
    wheel_goal, turn_goal = wheel_goal + speed * dt, turn_goal + turn * dt
    pitch = pitch + (pitch_rate + CORRECTION * (wheel - wheel_goal)) * dt

    local off = Matrix{wheel - wheel_goal, pitch, wheel_rate - speed, pitch_rate}
    local balance = -(gain * off):get(1) + forward * speed
    local steer = TURN_GAIN * (turn_goal - difference) + forward * turn / 2
    -- The target speed of a motor is its speed without load at a voltage.
    sim.setJointTargetVelocity(left, clamp(balance - steer, SUPPLY) / forward)
    sim.setJointTargetVelocity(right, clamp(balance + steer, SUPPLY) / forward)
end

-- Localization --------------------------------------------------------------------------------------------------------

local function predict()
    local way, turned = (way_angle - last_angle) * RADIUS, (way_difference - last_difference) * RADIUS / WIDTH
    last_angle, last_difference = way_angle, way_difference
    local h = x:get(3) + turned / 2
    x = x + Matrix{way * math.cos(h), way * math.sin(h), turned}
    local F = Matrix{{1, 0, -way * math.sin(h)}, {0, 1, way * math.cos(h)}, {0, 0, 1}}
    local place = (WAY_SIGMA * way) ^ 2 + WANDER_SIGMA ^ 2
    P = F * P * F:t() + Matrix.diag{place, place, (SLIP_SIGMA * turned) ^ 2 + WANDER_SIGMA ^ 2}
end

local function correct()
    local fix = tatu.read(beacon)
    if fix.sequence == last_fix or fix.valid ~= 1 then return end
    last_fix = fix.sequence
    local H, R = Matrix{{1, 0, 0}, {0, 1, 0}}, Matrix.diag{BEACON_SIGMA ^ 2, BEACON_SIGMA ^ 2}
    local K = (H * P * H:t() + R):solve(H * P):t()
    x = x + K * (Matrix{fix.position[1], fix.position[2]} - H * x)
    P = (Matrix.eye(3) - K * H) * P
end

-- Course --------------------------------------------------------------------------------------------------------------

-- A cosine that passes the poles on alternating sides, a semicircle, the mirrored cosine back, and another semicircle.
local function make_course()
    local stop = (POLES + 1) * SPACING
    local function add(px, py) course[#course + 1] = {px, py} end
    local function side(px) return -SWING * math.cos(math.pi * px / SPACING) end
    local function half_circle(cx, from)
        for i = 1, 23 do
            local angle = from + math.pi * i / 24
            add(cx + SWING * math.cos(angle), SWING * math.sin(angle))
        end
    end
    local n = 25 * (POLES + 1)
    for i = 0, n do add(stop * i / n, side(stop * i / n)) end
    half_circle(stop, -math.pi / 2)
    for i = n, 0, -1 do add(stop * i / n, -side(stop * i / n)) end
    half_circle(0, math.pi / 2)
end

local function draw_course()
    local lines = sim.addDrawingObject(sim.drawing_lines, 1, 0, -1, 1000, {0.95, 0.95, 0.98})
    for i = 1, #course, 2 do
        local a, b = course[i], course[i % #course + 1]
        sim.addDrawingObjectItem(lines, {a[1], a[2], 0.003, b[1], b[2], 0.003})
    end
end

-- Steers to the point of the course that lies ahead.
local function steer()
    local px, py, heading = x:get(1), x:get(2), x:get(3)
    local function far(i) return math.sqrt((course[i][1] - px) ^ 2 + (course[i][2] - py) ^ 2) end
    while far(at) < LOOK_AHEAD do at = at % #course + 1 end
    local off = wrapped(math.atan(course[at][2] - py, course[at][1] - px) - heading)
    want_speed = SPEED * math.max(0.2, math.cos(off)) / RADIUS
    want_turn = clamp(BEARING_GAIN * off, TURN_MOST) * WIDTH / RADIUS
end

function sysCall_init()
    left, right = sim.getObject(':/left_motor'), sim.getObject(':/right_motor')
    left_encoder = sim.getObject(':/left_motor/left_encoder')
    right_encoder = sim.getObject(':/right_motor/right_encoder')
    gyro, beacon = sim.getObject(':/gyro'), sim.getObject(':/top/beacon')
    local A, B = linear_model()
    A, B = over_step(A, B, tatu.get(0, 'scene.physics_dt'))
    gain = lqr(A, B, Matrix.diag(STATE_WEIGHT), Matrix{VOLTAGE_WEIGHT})
    forward = KB + FRICTION * OHM / KT
    x, P = Matrix{0, -SWING, 0}, Matrix.diag{0.01, 0.01, 0.01}
    make_course()
    draw_course()
    trail = sim.addDrawingObject(sim.drawing_lines + sim.drawing_cyclic, 2, 0, -1, 400, {1.0, 0.55, 0.1})
end

function sysCall_actuation()
    local before = {x:get(1), x:get(2)}
    predict()
    correct()
    if last_fix > 0 then
        steer()
        sim.addDrawingObjectItem(trail, {before[1], before[2], 0.005, x:get(1), x:get(2), 0.005})
    end
end
