-- Trots: diagonal legs swing together, the others carry the trunk. Runs at the rate of physics steps (200 Hz by
-- default).
--
-- Inputs are the IMU, the contact sensors of the feet and the joints. Footholds depend on the trunk's velocity, which
-- is estimated from the standing feet: this keeps the robot upright after a push. Without a command, the robot trots
-- along a square; the custom data `command` of the base, a string "forward left turn" in m/s, m/s, rad/s, overrides
-- that:
--     sim.writeCustomStringData(sim.getObject('/go1'), 'command', '0.2 0 0.3')

local LEGS = {'FR', 'FL', 'RR', 'RL'}
local SIDE = {-1, 1, -1, 1}
local END = {1, 1, -1, -1}
local PHASE = {0, 0.5, 0.5, 0}     -- FR with RL, FL with RR

local HIP_X, HIP_Y = 0.1881, 0.04675   -- m, hip joints in the trunk's frame
local HALF_WIDTH = 0.12675             -- m, lateral distance of the feet from the middle of the trunk
local BALL = 0.02                      -- m, radius of a foot
local HEIGHT = 0.2648                  -- m, height of the trunk above the centres of the feet

local PERIOD = 0.30                -- s, duration of a stride
local DUTY = 0.55                  -- fraction of a stride in which a foot carries
local LIFT = 0.055                 -- m, height of a swing
local ACCELERATION = 0.6           -- m/s^2, limit for the commanded velocity
local TURN_ACCELERATION = 2.0      -- rad/s^2
local FASTEST = {0.4, 0.2, 0.8}    -- m/s, m/s, rad/s, limits of commands
local SETTLE = 0.5                 -- s, standing time before the first stride

local STEP_GAIN = 0.14             -- s, shift of a foothold per m/s of velocity error, near sqrt(height / g) = 0.17 s
local STEP_LIMIT = 0.10            -- m, maximum shift of a foothold
local FILTER = 0.03                -- s, time constant of the velocity estimate
local HEADING_GAIN = 1.5           -- 1/s, turning per rad of heading error on straight sides
local TRIM_GAIN = 1.0              -- 1/s, integral gain that drives the estimated velocity to the command
local TRIM_LIMIT = 0.15            -- m/s and rad/s
local RELAX = 0.15                 -- s, time constant with which a standing foot returns to its nominal height

local LEAD = 0.010                 -- s, lag of the joints

local SIDE_TIME = 6.0              -- s, along a side of the square
local CORNER_TIME = 3.0            -- s, for a quarter turn

local function clamp(x, least, greatest)
    return math.max(least, math.min(greatest, x))
end

local function toward(x, goal, most)
    return x + clamp(goal - x, -most, most)
end

function sysCall_init()
    robot = sim.getObject(':')
    imu = sim.getObject(':/imu')
    kinematics = sim.getObject(':/kinematics')
    joint, contact, foot, lifted, stands = {}, {}, {}, {}, {}
    for i, leg in ipairs(LEGS) do
        joint[i] = {}
        for k, part in ipairs{'hip', 'thigh', 'calf'} do
            joint[i][k] = sim.getObject(':/' .. leg .. '_' .. part .. '_joint')
        end
        contact[i] = sim.getObject(':/' .. leg .. '_foot_contact')
        foot[i] = {END[i] * HIP_X, SIDE[i] * HALF_WIDTH, -HEIGHT}
        stands[i] = true
    end
    side_speed = tonumber(sim.readCustomStringData(robot, 'speed'))
    time, phase, heading, goal_heading = 0, 0, 0, 0
    velocity = {0, 0}              -- estimate, m/s, in the trunk's frame
    command = {0, 0, 0}            -- forward, left, turn, after acceleration limits
    trim = {0, 0, 0}               -- m/s, m/s, rad/s, added to the command of the feet
    before = nil
    goals = {}
end

-- Returns the current command. On straight sides of the square, the heading is held, so that the square does not drift.
local function wanted()
    local text = sim.readCustomStringData(robot, 'command')
    if text and text ~= '' then
        local given = {}
        for number in text:gmatch('%S+') do
            given[#given + 1] = tonumber(number)
        end
        if #given ~= 3 then
            error('custom data `command` of the base is "' .. text .. '"; expected three numbers: forward left turn')
        end
        for k = 1, 3 do given[k] = clamp(given[k], -FASTEST[k], FASTEST[k]) end
        -- A command without turning holds the heading.
        if given[3] == 0 and (given[1] ~= 0 or given[2] ~= 0) then
            held = held or heading
            given[3] = HEADING_GAIN * (held - heading)
        else
            held = nil
        end
        return given
    end
    local now = (time - SETTLE) % (SIDE_TIME + CORNER_TIME)
    local corners = math.floor((time - SETTLE) / (SIDE_TIME + CORNER_TIME))
    local turned = clamp((now - SIDE_TIME) / CORNER_TIME, 0, 1)
    goal_heading = (corners + turned) * math.pi / 2
    local turning = now > SIDE_TIME
    local turn = HEADING_GAIN * (goal_heading - heading) + (turning and math.pi / 2 / CORNER_TIME or 0)
    return {turning and 0 or side_speed, 0, clamp(turn, -FASTEST[3], FASTEST[3])}
end

-- Positions of the feet in the trunk's frame, from the joint angles, and the angles of hip and calf relative to the
-- trunk.
local function measuredFeet()
    local feet = {}
    for i = 1, 4 do
        local hip, thigh, calf = sim.getJointPosition(joint[i][1]), sim.getJointPosition(joint[i][2]),
            sim.getJointPosition(joint[i][3])
        local x, y, z = legs:footOf(hip, thigh, calf, SIDE[i])
        feet[i] = {x + END[i] * HIP_X, y + SIDE[i] * HIP_Y, z, hip, thigh + calf}
    end
    return feet
end

-- The trunk moves by the backward motion of the standing feet in its frame, plus the rolling of the spherical feet.
local function estimateVelocity(feet, rate, dt)
    local sum, count = {0, 0}, 0
    for i = 1, 4 do
        if stands[i] and before and tatu.read(contact[i]).touching == 1 then
            local p, old = feet[i], before[i]
            local roll, pitch = rate[1] + (p[4] - old[4]) / dt, rate[2] + (p[5] - old[5]) / dt
            sum[1] = sum[1] - (p[1] - old[1]) / dt - (rate[2] * p[3] - rate[3] * p[2]) + BALL * pitch
            sum[2] = sum[2] - (p[2] - old[2]) / dt - (rate[3] * p[1] - rate[1] * p[3]) - BALL * roll
            count = count + 1
        end
    end
    before = feet
    if count == 0 then return end
    local part = dt / (FILTER + dt)
    for k = 1, 2 do velocity[k] = velocity[k] + part * (sum[k] / count - velocity[k]) end
end

-- Roll and pitch from the attitude that the IMU reports.
local function tilt(q)
    local x, y, z, w = q[1], q[2], q[3], q[4]
    return math.atan(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), math.asin(clamp(2 * (w * y - z * x), -1, 1))
end

-- Velocity of the trunk above a foot at p, relative to the floor.
local function footSpeed(p)
    local turn = command[3] + trim[3]
    return command[1] + trim[1] - turn * p[2], command[2] + trim[2] + turn * p[1]
end

-- The foothold of a swinging foot: half a stance ahead of its neutral position, shifted to counter the velocity error.
local function landing(i)
    local x, y = END[i] * HIP_X, SIDE[i] * HALF_WIDTH
    local half = DUTY * PERIOD / 2
    local vx, vy = footSpeed({x, y})
    local ahead = clamp(STEP_GAIN * (velocity[1] - command[1]), -STEP_LIMIT, STEP_LIMIT)
    local aside = clamp(STEP_GAIN * (velocity[2] - command[2]), -STEP_LIMIT, STEP_LIMIT)
    return x + half * vx + ahead, y + half * vy + aside
end

local function moveFoot(i, roll, pitch, dt)
    local p = foot[i]
    local part = (phase + PHASE[i]) % 1
    if not walking or part < DUTY then
        -- Stance: the foot moves back under the trunk as fast as the trunk moves ahead.
        stands[i] = true
        local vx, vy = footSpeed(p)
        p[1], p[2] = p[1] - dt * vx, p[2] - dt * vy
        p[3] = p[3] + (-HEIGHT - p[3]) * dt / RELAX
        return
    end
    if stands[i] then
        stands[i], lifted[i] = false, {p[1], p[2], p[3]}
    end
    local s = (part - DUTY) / (1 - DUTY)
    -- A cubic whose speed at lift-off and touchdown is that of the floor, so that a foot that lands early does not
    -- brake.
    local start, goal, slope = 1 + s * s * (2 * s - 3), s * s * (3 - 2 * s), s * (s - 1) * (2 * s - 1)
    local swing = (1 - DUTY) * PERIOD
    local x, y = landing(i)
    -- The height is measured along gravity, so that both feet land at the same time if the trunk is tilted.
    local floor = -HEIGHT - x * math.sin(-pitch) - y * math.sin(roll)
    local vx, vy = footSpeed({x, y})
    p[1] = start * lifted[i][1] + goal * x - slope * swing * vx
    p[2] = start * lifted[i][2] + goal * y - slope * swing * vy
    p[3] = start * lifted[i][3] + goal * floor + LIFT * math.sin(math.pi * s) ^ 2
end

-- Targets include the speed: without it, the joints would lag and the strides would become shorter.
local function drive(i, target, dt)
    for k = 1, 3 do
        local speed = goals[i] and (target[k] - goals[i][k]) / dt or 0
        sim.setJointTargetPosition(joint[i][k], target[k] + LEAD * speed)
    end
    goals[i] = target
end

function sysCall_dyn(data)
    if data.afterStep then return end
    -- The kinematics script may start after this one, but it has started by the first physics step.
    legs = legs or sim.getScriptFunctions(sim.getScript(sim.scripttype_simulation, kinematics))
    local dt = data.dt
    local reading = tatu.read(imu)
    if reading.sequence == 0 then return end
    local rate = reading.angular_velocity
    local roll, pitch = tilt(reading.orientation)
    heading = heading + rate[3] * dt
    estimateVelocity(measuredFeet(), rate, dt)

    time = time + dt
    local want = time > SETTLE and wanted() or {0, 0, 0}
    for k = 1, 3 do
        command[k] = toward(command[k], want[k], (k == 3 and TURN_ACCELERATION or ACCELERATION) * dt)
    end
    local speeds = {velocity[1], velocity[2], rate[3]}
    for k = 1, 3 do
        local sum = trim[k] + TRIM_GAIN * dt * (command[k] - speeds[k])
        trim[k] = walking and clamp(sum, -TRIM_LIMIT, TRIM_LIMIT) or 0
    end
    -- The robot stops walking only between strides.
    local idle = want[1] == 0 and want[2] == 0 and want[3] == 0 and command[1] == 0 and command[2] == 0
    if time > SETTLE and not idle then walking = true end
    if walking then
        local next = phase + dt / PERIOD
        if idle and next >= 1 then walking = false end
        phase = next % 1
    end
    for i = 1, 4 do
        moveFoot(i, roll, pitch, dt)
        local p = foot[i]
        drive(i, {legs:jointsOf(p[1] - END[i] * HIP_X, p[2] - SIDE[i] * HIP_Y, p[3], SIDE[i])}, dt)
    end
end
