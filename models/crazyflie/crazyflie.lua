-- Flight controller: flies to the object `target`, and follows its heading.
--
-- Estimator: gyroscope and accelerometer are integrated in every physics step; each fix of the motion capture corrects
-- position, velocity, attitude and the biases (a Luenberger observer with fixed gains).
-- Controller, in every physics step: position -> velocity -> acceleration -> attitude -> rate -> rotor speeds.
--
-- Mass, rotors and their constants are read from the model, as firmware has them in its parameters. The true pose is
-- never read. Vectors are {x, y, z}, quaternions {x, y, z, w}; the world's z is up, the body's x ahead and y left.

local ROTORS = {'m1', 'm2', 'm3', 'm4'}
local INERTIA = {19.9e-6, 20.0e-6, 35.9e-6}   -- kg m^2, about the body's axes
local GRAVITY = 9.81                          -- m/s^2

-- Gains: position 1/s; velocity 1/s, and 1/s^2 for the integral of the velocity error, which compensates for unmodelled
-- effects: a payload, a bias of the accelerometer.
local POSITION_GAIN = {1.6, 1.6, 2.5}
local VELOCITY_GAIN = {3.2, 3.2, 5.0}
local INTEGRAL_GAIN = {0.8, 0.8, 2.5}
local INTEGRAL_MOST = {1.5, 1.5, 7}           -- m/s^2
local SPEED_MOST = {1.5, 1.0}                 -- m/s, horizontal and vertical
local TILT_MOST = math.rad(30)
local CLIMB_MOST = 4                          -- m/s^2, commanded vertical acceleration

-- Gains: attitude 1/s; rates 1/s; damping is a fraction of the angular acceleration, which compensates for motor lag.
local ATTITUDE_GAIN = {7, 7, 3}
local RATE_MOST = {6, 6, 2.5}                 -- rad/s
local RATE_GAIN = {60, 60, 6}
local RATE_DAMPING = {2, 2, 0}
local DAMPING_FILTER = 0.008                  -- s, filter time constant of the angular acceleration

-- Observer: its poles, 1/s.
local LEVEL_POLE = 3
local HEIGHT_POLE = 3
local YAW_POLE = 1.5

local ALIGN_TIME = 0.3                        -- s at rest in which biases and attitude are estimated
local LOST_FIX = 0.5                          -- s without a fix until the rotors stop
local JUMP = 0.5                              -- m; a fix that deviates by more than this resets the observer

local cos, sin, sqrt, abs, max, min = math.cos, math.sin, math.sqrt, math.abs, math.max, math.min

local function clamp(x, least, most) return max(least, min(most, x)) end

local function wrapped(angle) return (angle + math.pi) % (2 * math.pi) - math.pi end

-- The product of two quaternions.
local function product(a, b)
    return {
        a[4] * b[1] + a[1] * b[4] + a[2] * b[3] - a[3] * b[2],
        a[4] * b[2] - a[1] * b[3] + a[2] * b[4] + a[3] * b[1],
        a[4] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[4],
        a[4] * b[4] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
    }
end

-- The quaternion of a rotation vector, rad.
local function turn(x, y, z)
    local angle = sqrt(x * x + y * y + z * z)
    local k = angle < 1e-9 and 0.5 or sin(angle / 2) / angle
    return {k * x, k * y, k * z, cos(angle / 2)}
end

local function unit(q)
    local n = sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3] + q[4] * q[4])
    return {q[1] / n, q[2] / n, q[3] / n, q[4] / n}
end

-- The rotation matrix of a quaternion, by rows: its columns are the body's axes in the world.
local function matrix(q)
    local x, y, z, w = q[1], q[2], q[3], q[4]
    return {
        1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
        2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
        2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y),
    }
end

local function rotated(m, v)
    return {
        m[1] * v[1] + m[2] * v[2] + m[3] * v[3],
        m[4] * v[1] + m[5] * v[2] + m[6] * v[3],
        m[7] * v[1] + m[8] * v[2] + m[9] * v[3],
    }
end

local function rotatedBack(m, v)
    return {
        m[1] * v[1] + m[4] * v[2] + m[7] * v[3],
        m[2] * v[1] + m[5] * v[2] + m[8] * v[3],
        m[3] * v[1] + m[6] * v[2] + m[9] * v[3],
    }
end

-- The attitude whose z axis is along `up`, reached from the level one with the heading `yaw` by the shortest rotation.
local function attitudeAlong(up, yaw)
    local c, s = cos(yaw), sin(yaw)
    local x, y = c * up[1] + s * up[2], -s * up[1] + c * up[2]
    local tilt = unit({-y, x, 0, 1 + up[3]})
    return product({0, 0, sin(yaw / 2), cos(yaw / 2)}, tilt)
end

local function headingOf(m) return math.atan(m[4], m[1]) end

-- Parts and constants -------------------------------------------------------------------------------------------------

local function findRotors()
    rotors = {}
    local xx, yy = 0, 0
    for i, name in ipairs(ROTORS) do
        local handle = sim.getObject(':/' .. name)
        local at = sim.getObjectPosition(handle, body)
        local speed, thrust = tatu.get(handle, 'propeller.max_speed'), tatu.get(handle, 'propeller.max_thrust')
        rotors[i] = {
            handle = handle, x = at[1], y = at[2], most = thrust, factor = speed / sqrt(thrust),
            -- The reaction torque of the air turns the body against the rotor.
            yaw = (tatu.get(handle, 'propeller.turns') == 'clockwise' and 1 or -1)
                * tatu.get(handle, 'propeller.torque_per_thrust'),
        }
        xx, yy = xx + at[1] ^ 2, yy + at[2] ^ 2
    end
    for _, r in ipairs(rotors) do r.roll, r.pitch, r.turn = r.y / yy, -r.x / xx, 1 / (4 * r.yaw) end
end

function sysCall_init()
    body = sim.getObject(':')
    imu, front, back = sim.getObject(':/imu'), sim.getObject(':/marker_front'), sim.getObject(':/marker_back')
    findRotors()
    mass = tatu.get(body, 'shape.mass')
    imuAt = sim.getObjectPosition(imu, body)
    local f, b = sim.getObjectPosition(front, body), sim.getObjectPosition(back, body)
    markersAt = {(f[1] + b[1]) / 2 - imuAt[1], (f[2] + b[2]) / 2 - imuAt[2], (f[3] + b[3]) / 2 - imuAt[3]}
    -- Detaching the target keeps it in place when the robot moves; a stop attaches it again.
    target = sim.getObject(':/target')
    sim.setObjectParent(target, -1, true)
    mode = {kind = 'target'}
    startAligning()
end

-- Estimator -----------------------------------------------------------------------------------------------------------

function startAligning()
    aligning = {time = 0, n = 0, gyro = {0, 0, 0}, force = {0, 0, 0}}
    state = nil
    integral, lastRate, angularAcceleration = {0, 0, 0}, {0, 0, 0}, {0, 0, 0}
end

-- The middle of the two markers and the heading from one to the other, or nil if there is no new fix.
local function newFix()
    local f, b = tatu.read(front), tatu.read(back)
    if f.sequence == lastFix or f.valid ~= 1 or b.valid ~= 1 then return nil end
    lastFix = f.sequence
    local p, q = f.position, b.position
    return {
        at = {(p[1] + q[1]) / 2, (p[2] + q[2]) / 2, (p[3] + q[3]) / 2},
        heading = math.atan(p[2] - q[2], p[1] - q[1]),
    }
end

-- Averages the sensors on the ground. If the robot is not at rest, as when it starts in the air, it is assumed level.
local function align(dt, reading)
    local a, fix = aligning, newFix()
    if fix then a.fix = fix end
    if reading.sequence == 0 then return end
    a.time, a.n = a.time + dt, a.n + 1
    for k = 1, 3 do
        a.gyro[k] = a.gyro[k] + reading.angular_velocity[k]
        a.force[k] = a.force[k] + reading.acceleration[k]
    end
    local fx, fy, fz = a.force[1] / a.n, a.force[2] / a.n, a.force[3] / a.n
    local size = sqrt(fx * fx + fy * fy + fz * fz)
    local resting = abs(size - GRAVITY) < 1
    if not a.fix or resting and a.time < ALIGN_TIME then return end
    -- The measured specific force points up. Rotations that change only the heading preserve it.
    local q = {0, 0, 0, 1}
    if resting then q = unit({fy, -fx, 0, size + fz}) end
    q = unit(product({0, 0, sin(a.fix.heading / 2), cos(a.fix.heading / 2)}, q))
    local offset = rotated(matrix(q), markersAt)
    state = {
        q = q, v = {0, 0, 0}, force = 0, sinceFix = 0,
        p = {a.fix.at[1] - offset[1], a.fix.at[2] - offset[2], a.fix.at[3] - offset[3]},
        bias = resting and {a.gyro[1] / a.n, a.gyro[2] / a.n, a.gyro[3] / a.n} or {0, 0, 0},
        lift = resting and GRAVITY - size or 0,    -- m/s^2, to be added to the vertical acceleration
    }
end

local function predict(dt, reading)
    local s, w, f = state, reading.angular_velocity, reading.acceleration
    s.rate = {w[1] - s.bias[1], w[2] - s.bias[2], w[3] - s.bias[3]}
    -- The specific force is the mean over the step, so it is rotated by the attitude at the middle of the step.
    local half = turn(s.rate[1] * dt / 2, s.rate[2] * dt / 2, s.rate[3] * dt / 2)
    local middle = product(s.q, half)
    local a = rotated(matrix(middle), f)
    a[3] = a[3] - GRAVITY + s.lift
    for k = 1, 3 do
        s.p[k] = s.p[k] + s.v[k] * dt + a[k] * dt * dt / 2
        s.v[k] = s.v[k] + a[k] * dt
    end
    s.q = unit(product(middle, half))
    s.sinceFix = s.sinceFix + dt
end

-- Corrects the state by a fix. A tilt error causes an acceleration error of g times the angle, so horizontal errors
-- also correct the attitude, and through it the biases of the gyroscope.
local function correct(fix)
    local s, m = state, matrix(state.q)
    local t = min(s.sinceFix, 0.06)
    s.sinceFix = 0
    local offset = rotated(m, markersAt)
    local e = {}
    for k = 1, 3 do e[k] = fix.at[k] - s.p[k] - offset[k] end
    if sqrt(e[1] ^ 2 + e[2] ^ 2 + e[3] ^ 2) > JUMP then return startAligning() end
    local l, h = LEVEL_POLE, HEIGHT_POLE
    for k = 1, 2 do
        s.p[k] = s.p[k] + t * 4 * l * e[k]
        s.v[k] = s.v[k] + t * 6 * l ^ 2 * e[k]
    end
    s.p[3] = s.p[3] + t * 3 * h * e[3]
    s.v[3] = s.v[3] + t * 3 * h ^ 2 * e[3]
    s.lift = s.lift + t * h ^ 3 * e[3]
    local yaw = wrapped(fix.heading - headingOf(m))
    local tilt, drift = t * 4 * l ^ 3 / GRAVITY, t * l ^ 4 / GRAVITY
    s.q = unit(product(turn(-tilt * e[2], tilt * e[1], t * 2 * YAW_POLE * yaw), s.q))
    local b = rotatedBack(m, {-drift * e[2], drift * e[1], t * YAW_POLE ^ 2 * yaw})
    for k = 1, 3 do s.bias[k] = s.bias[k] - b[k] end
end

-- Controller ----------------------------------------------------------------------------------------------------------

-- Returns the goal position, m, and heading, rad.
local function setpoint()
    if mode.kind == 'position' then return mode.position, mode.yaw end
    local m = sim.getObjectMatrix(target)
    return {m[4], m[8], m[12]}, math.atan(m[5], m[1])
end

-- Scales the first two components so that their length is at most `most`.
local function limited(v, most)
    local n = sqrt(v[1] ^ 2 + v[2] ^ 2)
    if n > most then v[1], v[2] = v[1] * most / n, v[2] * most / n end
end

-- Returns the acceleration that moves the body's origin to `goal`, m/s^2.
local function accelerationTo(goal, dt)
    local s = state
    local e = {goal[1] - s.p[1], goal[2] - s.p[2], goal[3] + imuAt[3] - s.p[3]}
    local v, a = {}, {}
    for k = 1, 3 do v[k] = POSITION_GAIN[k] * e[k] end
    limited(v, SPEED_MOST[1])
    v[3] = clamp(v[3], -SPEED_MOST[2], SPEED_MOST[2])
    for k = 1, 3 do a[k] = VELOCITY_GAIN[k] * (v[k] - s.v[k]) end
    -- The horizontal integral is frozen while the robot accelerates or brakes, so that it does not overshoot.
    local steady = sqrt(a[1] ^ 2 + a[2] ^ 2) < 0.6
    for k = 1, 3 do
        if steady or k == 3 then
            local sum = integral[k] + INTEGRAL_GAIN[k] * (v[k] - s.v[k]) * dt
            integral[k] = clamp(sum, -INTEGRAL_MOST[k], INTEGRAL_MOST[k])
        end
    end
    a[3] = clamp(a[3], -CLIMB_MOST, CLIMB_MOST)
    for k = 1, 3 do a[k] = a[k] + integral[k] end
    limited(a, GRAVITY * math.tan(TILT_MOST))
    return a
end

-- Returns the rates that turn the body to the attitude `q`, rad/s.
local function ratesTo(q)
    local s = state.q
    local e = product({-s[1], -s[2], -s[3], s[4]}, q)
    local sign = e[4] < 0 and -2 or 2
    local rates = {}
    for k = 1, 3 do rates[k] = clamp(ATTITUDE_GAIN[k] * sign * e[k], -RATE_MOST[k], RATE_MOST[k]) end
    return rates
end

-- Returns the torque that controls the body to these rates, N m.
local function torqueTo(rates, dt)
    local w, torque = state.rate, {}
    local share = dt / (DAMPING_FILTER + dt)
    for k = 1, 3 do
        local change = (w[k] - lastRate[k]) / dt
        angularAcceleration[k] = angularAcceleration[k] + share * (change - angularAcceleration[k])
        torque[k] = INERTIA[k] * (RATE_GAIN[k] * (rates[k] - w[k]) - RATE_DAMPING[k] * angularAcceleration[k])
    end
    lastRate = w
    return torque
end

-- Distributes thrust (N) and torque over the rotors. If they saturate, roll and pitch have priority, then thrust, then
-- yaw.
local function mix(thrust, torque)
    local most, forces = rotors[1].most, {}
    local low, high = 0, 0
    for i, r in ipairs(rotors) do
        forces[i] = r.roll * torque[1] + r.pitch * torque[2]
        low, high = min(low, forces[i]), max(high, forces[i])
    end
    local scale = min(1, most / max(high - low, 1e-9))
    local each = clamp(thrust / 4, -scale * low, most - scale * high)
    local room = 1
    for i, r in ipairs(rotors) do
        forces[i] = scale * forces[i] + each
        local yaw = r.turn * torque[3]
        if yaw > 0 then room = min(room, (most - forces[i]) / yaw) end
        if yaw < 0 then room = min(room, forces[i] / -yaw) end
    end
    for i, r in ipairs(rotors) do
        local force = forces[i] + room * r.turn * torque[3]
        tatu.set(r.handle, 'propeller.speed', r.factor * sqrt(max(force, 0)))
    end
end

local function stopRotors()
    for _, r in ipairs(rotors) do tatu.set(r.handle, 'propeller.speed', 0) end
end

local function fly(dt)
    local s = state
    local m = matrix(s.q)
    local thrust, rates
    if mode.kind == 'rates' then
        thrust, rates = mode.thrust, mode.rates
    elseif mode.kind == 'attitude' then
        thrust, rates = mode.thrust, ratesTo(mode.attitude)
    else
        local goal, yaw = setpoint()
        local a = accelerationTo(goal, dt)
        local up = {a[1], a[2], a[3] + GRAVITY}
        local size = sqrt(up[1] ^ 2 + up[2] ^ 2 + up[3] ^ 2)
        for k = 1, 3 do up[k] = up[k] / size end
        -- The heading is approached along with the body, so that a wide turn does not tilt it.
        local now = headingOf(m)
        local attitude = attitudeAlong(up, now + clamp(wrapped(yaw - now), -0.8, 0.8))
        -- The component of the desired force along the rotor axes.
        thrust = mass * size * max(0, m[3] * up[1] + m[6] * up[2] + m[9] * up[3])
        rates = ratesTo(attitude)
    end
    mix(thrust, torqueTo(rates, dt))
end

function sysCall_dyn(d)
    if d.afterStep then return end
    local reading = tatu.read(imu)
    if not state then
        stopRotors()
        return align(d.dt, reading)
    end
    predict(d.dt, reading)
    local fix = newFix()
    if fix then correct(fix) end
    if not state then return end
    -- Upside down, or without fixes: rotors off, until the robot is on its feet again.
    if matrix(state.q)[9] < -0.2 or state.sinceFix > LOST_FIX then return startAligning() end
    fly(d.dt)
end

-- For other scripts, through sim.callScriptFunction -------------------------------------------------------------------

-- Flies to a position, m, with a heading, rad, instead of to the target.
function setPosition(x, y, z, yaw) mode = {kind = 'position', position = {x, y, z}, yaw = yaw or 0} end

-- Holds roll, pitch and heading, rad, at a thrust, N. Positive pitch is nose down, positive roll right side down.
function setAttitude(roll, pitch, yaw, thrust)
    local q = product(product(turn(0, 0, yaw), turn(0, pitch, 0)), turn(roll, 0, 0))
    mode = {kind = 'attitude', attitude = q, thrust = thrust}
end

-- Holds rates about the body's axes, rad/s, at a thrust, N.
function setRates(x, y, z, thrust) mode = {kind = 'rates', rates = {x, y, z}, thrust = thrust} end

-- Flies to the target again.
function followTarget()
    mode, integral = {kind = 'target'}, {0, 0, 0}
end

-- The estimated position of the body's origin, m, its velocity, m/s, and the attitude; nil before it is known.
function getEstimate()
    if not state then return nil end
    local offset = rotated(matrix(state.q), imuAt)
    local p = {}
    for k = 1, 3 do p[k] = state.p[k] - offset[k] end
    return p, state.v, state.q
end
