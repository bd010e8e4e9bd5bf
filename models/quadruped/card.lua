-- Measurements of the quadruped; see card.toml.

local LEGS = {'FR', 'FL', 'RR', 'RL'}

-- Pushes the trunk with a force in the world frame for 0.1 s.
local function push(fx, fy)
    local trunk = measure.model()
    local stop = sim.getSimulationTime() + 0.0999
    while sim.getSimulationTime() < stop do
        sim.addForceAndTorque(trunk, {fx, fy, 0}, {0, 0, 0})
        sim.step()
    end
end

function mass()
    return measure.mass(measure.model())
end

function rest_drift()
    sim.wait(1)
    return measure.drift(measure.model(), 60)
end

function stand_height()
    sim.wait(2)
    return sim.getObjectPosition(measure.model())[3]
end

function calf_torque()
    sim.wait(2)
    local sum = 0
    for _, leg in ipairs(LEGS) do
        sum = sum + math.abs(sim.getJointForce(sim.getObject('/go1/' .. leg .. '_calf_joint')))
    end
    return sum / #LEGS
end

-- The trunk is not supported: it starts far above the floor and falls while the leg swings.
function hip_speed()
    local trunk = measure.model()
    local position = sim.getObjectPosition(trunk)
    sim.setObjectPosition(trunk, {position[1], position[2], 20})
    local thigh = sim.getObject('/go1/FR_thigh_joint')
    sim.setJointTargetPosition(thigh, 4.4)
    local fastest = 0
    for _ = 1, 20 do
        sim.step()
        fastest = math.max(fastest, math.abs(sim.getJointVelocity(thigh)))
    end
    return fastest
end

function trot_speed()
    sim.wait(4)
    local from = sim.getObjectPosition(measure.model())
    sim.wait(9)
    return measure.distance(from, sim.getObjectPosition(measure.model())) / 9
end

function trot_aside()
    return trot_speed()
end

function turn_rate()
    sim.wait(3)
    local from = measure.angle(measure.model())
    for _ = 1, 12 do
        sim.wait(0.5)
        measure.angle(measure.model())
    end
    return (measure.angle(measure.model()) - from) / 6
end

function push_standing()
    sim.wait(2)
    push(0, 30)
    sim.wait(3)
    return measure.tilt(measure.model())
end

function push_trotting()
    sim.wait(3)
    push(0, 30)
    sim.wait(3)
    local first = measure.tilt(measure.model())
    push(-30, 0)
    sim.wait(3)
    return math.max(first, measure.tilt(measure.model()))
end

function inverse_kinematics()
    local legs = sim.getScriptFunctions(sim.getScript(sim.scripttype_simulation, sim.getObject('/go1/kinematics')))
    local worst = 0
    for k = 1, 200 do
        local side = k % 2 == 0 and 1 or -1
        local hip = (math.random() * 2 - 1) * 0.8
        local thigh = 0.2 + math.random() * 1.2
        local calf = -0.95 - math.random() * 1.7
        local x, y, z = legs:footOf(hip, thigh, calf, side)
        local a, b, c = legs:jointsOf(x, y, z, side)
        local u, v, w = legs:footOf(a, b, c, side)
        worst = math.max(worst, math.sqrt((x - u) ^ 2 + (y - v) ^ 2 + (z - w) ^ 2))
    end
    return worst
end
