-- The humanoid stands, waves, and keeps its balance when balls hit it.
--
-- The IMU is the only input: a complementary filter of gyrometer and accelerometer estimates roll and pitch. The torso
-- is shifted over the feet against the tilt and its rate, which moves the centre of pressure as people do with their
-- ankles. While the body is shaken, the robot stops waving and holds its arms ready.

local CROUCH = {x = 0.0171, z = -0.2752}   -- m, ankles in the torso's frame, as at the start
local WIDTH = 0.05                         -- m, lateral distance of the ankles from the middle of the torso
local LEG = {'HipYawPitch', 'HipRoll', 'HipPitch', 'KneePitch', 'AnklePitch', 'AnkleRoll'}

local FILTER_TIME = 0.5                    -- s: crossover time between gyrometer and accelerometer
local TILT_GAIN, RATE_GAIN = 0.10, 0.012   -- m of shift per rad of tilt, and per rad/s of its rate
local SHIFT_MOST = 0.025                   -- m
local RETURN_TIME = 0.15                   -- s: time constant with which the shift follows
local SHAKEN = 0.35                        -- rad/s: above this rate, the body counts as hit
local CALM, CALM_TIME = 0.10, 0.8          -- rad/s and s: below this rate for this time, the body counts as at rest

local imu, legs, kinematics, leg, arm
local roll, pitch, shift_x, shift_y = 0, 0, 0, 0
local shaken, calm_since = false, 0

local function clamp(value, most) return math.max(-most, math.min(most, value)) end

-- Places both feet parallel to the torso, with the torso shifted from above their middle.
local function stand()
    for name, side in pairs{L = 1, R = -1} do
        local angles = legs:jointsOf(CROUCH.x - shift_x, side * WIDTH - shift_y, CROUCH.z, 0, 0, 0, side)
        for k, angle in ipairs(angles) do sim.setJointTargetPosition(leg[name][k], angle) end
    end
end

local function estimate_tilt(dt)
    local reading = tatu.read(imu)
    if reading.sequence == 0 then return 0, 0 end
    local w, f = reading.angular_velocity, reading.acceleration
    local part = dt / (FILTER_TIME + dt)
    roll = (1 - part) * (roll + w[1] * dt) + part * math.atan(f[2], f[3])
    pitch = (1 - part) * (pitch + w[2] * dt) + part * math.atan(-f[1], f[3])
    return w[1], w[2]
end

local function watch(rate_x, rate_y)
    local now, rate = sim.getSimulationTime(), math.sqrt(rate_x ^ 2 + rate_y ^ 2)
    if rate > SHAKEN then shaken = true end
    if rate > CALM then calm_since = now end
    if now - calm_since > CALM_TIME then shaken = false end
end

local function move(joint, target)
    sim.setJointTargetPosition(arm[joint], target)
end

-- Waits until a time has passed or the body is hit; returns whether it was hit.
local function rest(seconds)
    local until_time = sim.getSimulationTime() + seconds
    while sim.getSimulationTime() < until_time and not shaken do sim.step() end
    return shaken
end

local function arms_down()
    for side, sign in pairs{L = 1, R = -1} do
        move(side .. 'ShoulderPitch', 1.4)
        move(side .. 'ShoulderRoll', sign * 0.25)
        move(side .. 'ElbowYaw', -sign * 1.2)
        move(side .. 'ElbowRoll', -sign * 0.4)
    end
    move('HeadYaw', 0)
end

local function arms_ready()
    for side, sign in pairs{L = 1, R = -1} do
        move(side .. 'ShoulderPitch', 0.9)
        move(side .. 'ShoulderRoll', sign * 0.7)
        move(side .. 'ElbowRoll', -sign * 0.9)
    end
end

local function wave(side, sign)
    move(side .. 'ShoulderPitch', -0.9)
    move(side .. 'ShoulderRoll', sign * 0.35)
    move(side .. 'ElbowYaw', -sign * 1.5)
    move('HeadYaw', sign * 0.4)
    if rest(0.8) then return end
    for _ = 1, 4 do
        move(side .. 'ElbowRoll', -sign * 1.2)
        if rest(0.35) then return end
        move(side .. 'ElbowRoll', -sign * 0.5)
        if rest(0.35) then return end
    end
end

function sysCall_init()
    imu = sim.getObject(':/imu')
    leg, arm = {}, {HeadYaw = sim.getObject(':/HeadYaw')}
    for _, side in ipairs{'L', 'R'} do
        leg[side] = {}
        for k, joint in ipairs(LEG) do leg[side][k] = sim.getObject(':/' .. side .. joint) end
        for _, joint in ipairs{'ShoulderPitch', 'ShoulderRoll', 'ElbowYaw', 'ElbowRoll'} do
            arm[side .. joint] = sim.getObject(':/' .. side .. joint)
        end
    end
    kinematics = sim.getScript(sim.scripttype_simulation, sim.getObject(':/kinematics'))
end

function sysCall_actuation()
    legs = legs or sim.getScriptFunctions(kinematics)
    local dt = sim.getSimulationTimeStep()
    local rate_x, rate_y = estimate_tilt(dt)
    watch(rate_x, rate_y)
    -- Leaning ahead is a positive pitch, leaning to the left a negative roll: the torso is shifted the opposite way.
    local part = dt / (RETURN_TIME + dt)
    shift_x = shift_x + part * (clamp(-TILT_GAIN * pitch - RATE_GAIN * rate_y, SHIFT_MOST) - shift_x)
    shift_y = shift_y + part * (clamp(TILT_GAIN * roll + RATE_GAIN * rate_x, SHIFT_MOST) - shift_y)
    stand()
end

function sysCall_thread()
    local side, sign = 'R', -1
    while true do
        wave(side, sign)
        if shaken then
            arms_ready()
            while shaken do sim.step() end
        end
        arms_down()
        rest(1.2)
        side, sign = side == 'R' and 'L' or 'R', -sign
    end
end
