-- Waves, shifts its weight and stands on one leg, in a loop.
--
-- Inputs are the IMU and the contact sensors of the feet. Weight is shifted until the foot sensors report that the
-- other foot is unloaded; after a push, the robot waits on both feet until the gyrometer is calm.

local CROUCH = {x = 0.0171, z = -0.2752}   -- m, ankles in the torso's frame, as at the start
local WIDTH = 0.05                         -- m, lateral distance of the ankles from the middle of the torso
local LOWER = 0.012                        -- m, by which the torso sinks during a shift, so that the far leg reaches
local SHIFT_SPEED = 0.03                   -- m/s
local SHIFT_MOST = 0.085                   -- m
local FREE = 2.0                           -- N, a foot with less load counts as unloaded
local LEAST = 0.05                         -- m, minimum shift of the torso
local STEPS_FREE = 3                       -- consecutive readings that must report an unloaded foot
local LIFT = 0.03                          -- m
local HOLD = 2.0                           -- s, on one leg
local CALM = 0.08                          -- rad/s, limit of the gyrometer reading
local CALM_TIME = 0.4                      -- s
local LEG = {'HipYawPitch', 'HipRoll', 'HipPitch', 'KneePitch', 'AnklePitch', 'AnkleRoll'}

-- Position of the torso relative to the middle of the feet, and lift of each foot, m.
local pose = {y = 0, z = 0, L = 0, R = 0}

function sysCall_init()
    imu = sim.getObject(':/imu')
    contact, leg = {}, {}
    for _, name in ipairs{'L', 'R'} do
        contact[name] = sim.getObject(':/' .. name .. 'Foot_contact')
        leg[name] = {}
        for k, joint in ipairs(LEG) do leg[name][k] = sim.getObject(':/' .. name .. joint) end
    end
    kinematics = sim.getObject(':/kinematics')
end

local function move(joint, target)
    sim.setJointTargetPosition(sim.getObject(':/' .. joint), target)
end

-- Sets the targets of both legs.
local function stand()
    legs = legs or sim.getScriptFunctions(sim.getScript(sim.scripttype_simulation, kinematics))
    for name, side in pairs{L = 1, R = -1} do
        local angles = legs:jointsOf(CROUCH.x, side * WIDTH - pose.y, CROUCH.z - pose.z + pose[name], 0, 0, 0, side)
        for k, angle in ipairs(angles) do sim.setJointTargetPosition(leg[name][k], angle) end
    end
end

-- Moves some entries of the pose to new values, with a smooth start and end.
local function glide(seconds, goal)
    local from, start = {}, sim.getSimulationTime()
    for key in pairs(goal) do from[key] = pose[key] end
    repeat
        local s = math.min(1, (sim.getSimulationTime() - start) / seconds)
        for key, value in pairs(goal) do
            pose[key] = from[key] + (value - from[key]) * (1 - math.cos(math.pi * s)) / 2
        end
        stand()
        sim.step()
    until s >= 1
end

-- Waits until the body has been at rest for CALM_TIME.
local function settle()
    local since = sim.getSimulationTime()
    while sim.getSimulationTime() - since < CALM_TIME do
        local rate = tatu.read(imu).angular_velocity
        if rate[1] ^ 2 + rate[2] ^ 2 + rate[3] ^ 2 > CALM ^ 2 then since = sim.getSimulationTime() end
        sim.step()
    end
end

local function wave(name, times)
    local side = name == 'L' and 1 or -1
    move(name .. 'ShoulderPitch', -0.9)
    move(name .. 'ShoulderRoll', side * 0.35)
    move(name .. 'ElbowYaw', -side * 1.5)
    move('HeadYaw', side * 0.4)
    sim.wait(1.0)
    for _ = 1, times do
        move(name .. 'ElbowRoll', -side * 1.2)
        sim.wait(0.4)
        move(name .. 'ElbowRoll', -side * 0.5)
        sim.wait(0.4)
    end
    move('HeadYaw', 0)
    move(name .. 'ShoulderPitch', 1.4)
    move(name .. 'ShoulderRoll', side * 0.3)
    move(name .. 'ElbowYaw', -side * 1.2)
    move(name .. 'ElbowRoll', -side * 0.4)
    sim.wait(1.0)
end

-- Shifts the weight to the foot `name` until the other one is unloaded, and lifts that one for HOLD.
local function standOn(name, other, side)
    glide(1.0, {z = -LOWER})
    local free = 0
    while free < STEPS_FREE and math.abs(pose.y) < SHIFT_MOST do
        local light = tatu.read(contact[other]).normal_force < FREE and math.abs(pose.y) >= LEAST
        free = light and free + 1 or 0
        pose.y = pose.y + side * SHIFT_SPEED * sim.getSimulationTimeStep()
        stand()
        sim.step()
    end
    if free >= STEPS_FREE then
        glide(1.0, {[other] = LIFT})
        sim.wait(HOLD)
        glide(1.0, {[other] = 0})
    end
    glide(1.5, {y = 0})
    glide(1.0, {z = 0})
end

function sysCall_thread()
    while true do
        settle()
        wave('R', 3)
        settle()
        standOn('L', 'R', 1)
        settle()
        wave('L', 3)
        settle()
        standOn('R', 'L', -1)
    end
end
