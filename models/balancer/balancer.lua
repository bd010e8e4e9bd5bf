-- Balances by state feedback: each physics step reads gyroscope and encoders, and sets the voltages of the motors. The
-- target speed of a motor encodes its voltage: it is the speed without load at that voltage. Clients steer the robot by
-- setting target speeds as for any wheeled robot (tatu.drive, ROS, arrow keys): a target that the controller did not
-- set itself is a command. Until the first command, the robot drives around a square.

local RADIUS = 0.04             -- m, of the wheels
local WIDTH = 0.14              -- m, between the wheels
local TRACK = 0.1423            -- m: effective width as calibrated by turning, which includes wheel slip
local SUPPLY = 8.0              -- V, of the battery
local KT, KB, OHM, FRICTION = 0.317, 0.468, 6.69, 0.0022    -- N m/A, V s/rad, ohm, N m s/rad: of a motor

-- Volts per rad, rad, rad/s, rad/s of: angle of the wheels against the world, pitch, and their rates. From the linear
-- model by LQR, with the weights 1, 1000, 1, 1 of the states and 100 of the voltage.
local K_WHEEL, K_PITCH, K_WHEEL_RATE, K_PITCH_RATE = 0.1, 25.3, 1.068, 2.332
local K_TURN = 3.0              -- V per rad of error of the angle between right and left wheel
local FORWARD = KB + FRICTION * OHM / KT                    -- V s/rad: voltage that sustains a speed without load
-- The integrated gyroscope rate drifts because of noise. The robot then balances away from its target position, and
-- that offset slowly corrects the pitch.
local CORRECTION = 1.5e-4       -- rad/s of pitch per rad of the wheels
local SMOOTH = 0.5              -- low-pass factor of the encoder angle per 5 ms: encoders count whole degrees
local ACCELERATION = 4.0        -- rad/s^2 of the wheels: maximum rate of change of the target speeds
local FALLEN = math.rad(45)     -- rad of pitch: beyond this, the motors are switched off

local TOUR_SPEED = 0.15         -- m/s
local TOUR_SIDE = 0.8           -- m, of the square

function sysCall_init()
    left, right = sim.getObject(':/left_motor'), sim.getObject(':/right_motor')
    left_encoder = sim.getObject(':/left_motor/left_encoder')
    right_encoder = sim.getObject(':/right_motor/right_encoder')
    gyro = sim.getObject(':/gyro')
    touring = sim.readCustomStringData(sim.getObject(':/controller'), 'tour') == 'yes'
    pitch, smooth, started, fallen = 0, 0, false, false
    speed, turn = 0, 0                      -- rad/s: desired rate of the wheels, and right minus left
    wheel_goal, turn_goal = 0, 0            -- rad: their integrals
    want_speed, want_turn = 0, 0
    own_left, own_right = 0, 0              -- rad/s: the targets that this controller set last
    x, y, heading, travelled = 0, 0, 0, 0   -- m, rad: wheel odometry
    corner = 1
end

local function clamp(value, most) return math.max(-most, math.min(most, value)) end

local function toward(value, target, most) return value + clamp(target - value, most) end

-- Speeds that drive the robot to the corners of a square, by odometry.
local function tour()
    local corners = {{TOUR_SIDE, 0}, {TOUR_SIDE, TOUR_SIDE}, {0, TOUR_SIDE}, {0, 0}}
    local dx, dy = corners[corner][1] - x, corners[corner][2] - y
    if math.sqrt(dx * dx + dy * dy) < 0.1 then corner = corner % 4 + 1 end
    local off = math.atan(dy, dx) - heading
    off = math.atan(math.sin(off), math.cos(off))
    return TOUR_SPEED * math.max(0, math.cos(off)) / RADIUS, clamp(1.5 * off, 1.2) * TRACK / RADIUS
end

function sysCall_actuation()
    if touring then want_speed, want_turn = tour() end
end

-- Accepts targets that others have set since the controller last wrote the motors.
local function listen()
    local l, r = sim.getJointTargetVelocity(left), sim.getJointTargetVelocity(right)
    if l ~= own_left or r ~= own_right then
        touring = false
        want_speed, want_turn = (l + r) / 2, (r - l) * TRACK / WIDTH
    end
end

-- Updates the odometry from the wheel angles.
local function odometry(angle, difference)
    local way = (angle - travelled) * RADIUS
    travelled, heading = angle, difference * RADIUS / TRACK
    x, y = x + way * math.cos(heading), y + way * math.sin(heading)
end

function sysCall_dyn(step)
    if step.afterStep then return end
    local l, r, g = tatu.read(left_encoder), tatu.read(right_encoder), tatu.read(gyro)
    if l.sequence == 0 or r.sequence == 0 or g.sequence == 0 then return end
    local dt = step.dt
    listen()

    -- Rates and angles. Encoders measure the wheels relative to the body.
    local pitch_rate = g.angular_velocity[2]
    local angle, difference = (l.position + r.position) / 2, r.position - l.position
    if not started then smooth, started = angle, true end
    local before = smooth
    smooth = smooth + (1 - SMOOTH ^ (dt / 0.005)) * (angle - smooth)
    local wheel, wheel_rate = smooth + pitch, (smooth - before) / dt + pitch_rate
    odometry(wheel, difference)

    speed = toward(speed, want_speed, ACCELERATION * dt)
    turn = toward(turn, want_turn, 2 * ACCELERATION * dt)
    wheel_goal, turn_goal = wheel_goal + speed * dt, turn_goal + turn * dt
    pitch = pitch + (pitch_rate + CORRECTION * (wheel - wheel_goal)) * dt

    if math.abs(pitch) > FALLEN then fallen = true end
    local balance = K_WHEEL * (wheel - wheel_goal) + K_PITCH * pitch + K_WHEEL_RATE * (wheel_rate - speed)
        + K_PITCH_RATE * pitch_rate + FORWARD * speed
    local steer = K_TURN * (turn_goal - difference) + FORWARD * turn / 2
    own_left = fallen and 0 or clamp(balance - steer, SUPPLY) / FORWARD
    own_right = fallen and 0 or clamp(balance + steer, SUPPLY) / FORWARD
    sim.setJointTargetVelocity(left, own_left)
    sim.setJointTargetVelocity(right, own_right)
end
