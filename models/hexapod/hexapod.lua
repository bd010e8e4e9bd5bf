-- Walks in a tripod gait: three feet (front and rear of one side, middle of the other) carry while the others swing.
--
-- Inputs are the IMU's gyrometer, which is used to hold the heading, and the contact sensors, which stop a swinging
-- foot that touches the floor early. Without a command, the robot walks along a square; the custom data `command` of
-- the base, a string "forward left turn" in m/s, m/s, rad/s, overrides that:
--     sim.writeCustomStringData(sim.getObject('/phantomx'), 'command', '0 0.1 0')

local LEGS = {'lf', 'lm', 'lr', 'rf', 'rm', 'rr'}
local PHASE = {0, 0.5, 0, 0.5, 0, 0.5}
local FACING = {math.pi / 4, math.pi / 2, 3 * math.pi / 4, -math.pi / 4, -math.pi / 2, -3 * math.pi / 4}
local COXA = {{0.1248, 0.06164}, {0, 0.1034}, {-0.1248, 0.06164}, {0.1248, -0.06164}, {0, -0.1034}, {-0.1248, -0.06164}}

local REACH = 0.1096               -- m, outward distance of a neutral foot from its coxa joint
local DEPTH = -0.0953              -- m, height of a neutral foot relative to its coxa joint
local PERIOD = 0.8                 -- s, duration of a stride
local DUTY = 0.55                  -- fraction of a stride in which a foot carries
local LIFT = 0.035                 -- m, height of a swing
local ACCELERATION = {0.3, 0.3, 2.0}   -- m/s^2, m/s^2, rad/s^2
local FASTEST = {0.2, 0.15, 0.8}   -- m/s, m/s, rad/s
local SETTLE = 0.5                 -- s, standing time before the first stride
local STRIDE = 1.04                -- calibrated: with 1, a walk at 0.12 m/s is 4 % slow
local LEAD = 0.010                 -- s, lag of the joints
local HEADING_GAIN = 1.5           -- 1/s, turning per rad of heading error
local EARLY = 0.7                  -- fraction of a swing after which contact ends it
local SIDE_TIME, CORNER_TIME = 8.0, 4.0    -- s, along a side of the square and for a quarter turn

local function clamp(x, least, greatest)
    return math.max(least, math.min(greatest, x))
end

function sysCall_init()
    robot = sim.getObject(':')
    imu = sim.getObject(':/imu', {noError = true})
    kinematics = sim.getObject(':/kinematics')
    joint, contact, neutral, foot, lifted, landed = {}, {}, {}, {}, {}, {}
    for i, leg in ipairs(LEGS) do
        joint[i] = {}
        for k, part in ipairs{'j_c1_', 'j_thigh_', 'j_tibia_'} do joint[i][k] = sim.getObject(':/' .. part .. leg) end
        contact[i] = sim.getObject(':/foot_contact_' .. leg, {noError = true})
        local x, y = COXA[i][1] + REACH * math.cos(FACING[i]), COXA[i][2] + REACH * math.sin(FACING[i])
        neutral[i], foot[i] = {x, y}, {x, y, DEPTH}
    end
    side_speed = tonumber(sim.readCustomStringData(robot, 'speed'))
    time, phase, heading, walking = 0, 0, 0, false
    command, before = {0, 0, 0}, {}
end

-- Returns the current command. Without a commanded turn, the heading is held.
local function wanted()
    local text = sim.readCustomStringData(robot, 'command')
    local want, goal
    if text and text ~= '' then
        want = {}
        for number in text:gmatch('%S+') do want[#want + 1] = tonumber(number) end
        if #want ~= 3 then
            error('custom data `command` of the base is "' .. text .. '"; expected three numbers: forward left turn')
        end
        held = want[3] == 0 and (want[1] ~= 0 or want[2] ~= 0) and (held or heading) or nil
        goal = held
    else
        local now = (time - SETTLE) % (SIDE_TIME + CORNER_TIME)
        local corners = math.floor((time - SETTLE) / (SIDE_TIME + CORNER_TIME))
        local turned = clamp((now - SIDE_TIME) / CORNER_TIME, 0, 1)
        local turning = now > SIDE_TIME
        goal = (corners + turned) * math.pi / 2
        want = {turning and 0 or side_speed, 0, turning and math.pi / 2 / CORNER_TIME or 0}
    end
    if goal then want[3] = want[3] + HEADING_GAIN * (goal - heading) end
    for k = 1, 3 do want[k] = clamp(want[k], -FASTEST[k], FASTEST[k]) end
    return want
end

-- Velocity of the body above a foot at p, relative to the floor.
local function footSpeed(p)
    return STRIDE * (command[1] - command[3] * p[2]), STRIDE * (command[2] + command[3] * p[1])
end

local function moveFoot(i, dt)
    local p = foot[i]
    local part = (phase + PHASE[i]) % 1
    if not walking or part < DUTY then
        local vx, vy = footSpeed(p)
        p[1], p[2], p[3] = p[1] - dt * vx, p[2] - dt * vy, p[3] + (DEPTH - p[3]) * math.min(1, 10 * dt)
        lifted[i], landed[i] = nil, nil
        return
    end
    lifted[i] = lifted[i] or {p[1], p[2], p[3]}
    local s = (part - DUTY) / (1 - DUTY)
    landed[i] = landed[i] or s > EARLY and contact[i] ~= -1 and tatu.read(contact[i]).touching == 1
    if landed[i] then return end
    -- A cubic whose speed at lift-off and touchdown is that of the floor.
    local start, goal, slope = 1 + s * s * (2 * s - 3), s * s * (3 - 2 * s), s * (s - 1) * (2 * s - 1)
    local vx, vy = footSpeed({neutral[i][1], neutral[i][2]})
    local half, swing = DUTY * PERIOD / 2, (1 - DUTY) * PERIOD
    p[1] = start * lifted[i][1] + goal * (neutral[i][1] + half * vx) - slope * swing * vx
    p[2] = start * lifted[i][2] + goal * (neutral[i][2] + half * vy) - slope * swing * vy
    p[3] = start * lifted[i][3] + goal * DEPTH + LIFT * math.sin(math.pi * s) ^ 2
end

-- Runs in each physics step, so that the feet follow smooth paths instead of polylines with one point per scene step.
function sysCall_dyn(data)
    if data.afterStep then return end
    -- The kinematics script may start after this one, but it has started by the first physics step.
    legs = legs or sim.getScriptFunctions(sim.getScript(sim.scripttype_simulation, kinematics))
    local dt = data.dt
    time = time + dt
    if imu ~= -1 then
        local reading = tatu.read(imu)
        heading = heading + (reading.sequence > 0 and reading.angular_velocity[3] or 0) * dt
    end
    local want = time > SETTLE and wanted() or {0, 0, 0}
    for k = 1, 3 do
        command[k] = command[k] + clamp(want[k] - command[k], -ACCELERATION[k] * dt, ACCELERATION[k] * dt)
    end
    local idle = want[1] == 0 and want[2] == 0 and want[3] == 0 and command[1] == 0 and command[2] == 0
    if time > SETTLE and not idle then walking = true end
    if walking then
        local next = phase + dt / PERIOD
        if idle and next >= 1 then walking = false end
        phase = next % 1
    end
    for i = 1, 6 do
        moveFoot(i, dt)
        local dx, dy = foot[i][1] - COXA[i][1], foot[i][2] - COXA[i][2]
        local s, c = math.sin(FACING[i]), math.cos(FACING[i])
        local target = {legs:jointsOf(c * dx + s * dy, c * dy - s * dx, foot[i][3])}
        for k = 1, 3 do
            local speed = before[i] and (target[k] - before[i][k]) / dt or 0
            sim.setJointTargetPosition(joint[i][k], target[k] + LEAD * speed)
        end
        before[i] = target
    end
end
