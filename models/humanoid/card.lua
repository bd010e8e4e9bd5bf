-- Measurements of the humanoid; see card.toml.

-- Pushes the torso with a force in the world frame for 0.1 s.
local function shove(fx, fy)
    local torso = measure.model()
    local stop = sim.getSimulationTime() + 0.0999
    while sim.getSimulationTime() < stop do
        sim.addForceAndTorque(torso, {fx, fy, 0}, {0, 0, 0})
        sim.step()
    end
end

local function set(joints)
    for name, target in pairs(joints) do
        sim.setJointTargetPosition(sim.getObject('/nao/' .. name), target)
    end
end

-- Centre of mass of all dynamic shapes, in the world.
local function massCentre()
    local sum, total = {0, 0, 0}, 0
    for _, shape in ipairs(sim.getObjectsInTree(measure.model(), sim.object_shape_type)) do
        if tatu.get(shape, 'shape.dynamic') then
            local mass, matrix = tatu.get(shape, 'shape.mass'), sim.getObjectMatrix(shape)
            local point = sim.multiplyVector(matrix, tatu.get(shape, 'shape.com'))
            for k = 1, 3 do sum[k] = sum[k] + mass * point[k] end
            total = total + mass
        end
    end
    return {sum[1] / total, sum[2] / total, sum[3] / total}
end

-- Legs straight, arms down and straight.
local function straighten()
    for _, side in ipairs{'L', 'R'} do
        set{[side .. 'HipPitch'] = 0, [side .. 'KneePitch'] = 0, [side .. 'AnklePitch'] = 0,
            [side .. 'ShoulderPitch'] = 1.57, [side .. 'ShoulderRoll'] = 0, [side .. 'ElbowYaw'] = 0}
    end
    set{LElbowRoll = -0.0349, RElbowRoll = 0.0349}
    sim.wait(3)
end

function mass()
    return measure.mass(measure.model())
end

function rest_drift()
    sim.wait(1)
    return measure.drift(measure.model(), 60)
end

function torso_height()
    sim.wait(2)
    return sim.getObjectPosition(measure.model())[3]
end

function straight_height()
    straighten()
    return sim.getObjectPosition(measure.model())[3]
end

function mass_centre_height()
    straighten()
    return massCentre()[3]
end

function mass_centre_ahead()
    straighten()
    return massCentre()[1] - sim.getObjectPosition(sim.getObject('/nao/LSole'))[1]
end

function head_speed()
    set{HeadYaw = -2}
    sim.wait(2)
    set{HeadYaw = 2}
    local fastest = 0
    for _ = 1, 20 do
        sim.step()
        fastest = math.max(fastest, sim.getJointVelocity(sim.getObject('/nao/HeadYaw')))
    end
    return fastest
end

function push()
    sim.wait(1)
    local worst = 0
    for _, force in ipairs{{10, 0}, {0, 10}, {-10, 0}, {0, -10}} do
        shove(force[1], force[2])
        sim.wait(3)
        worst = math.max(worst, measure.tilt(measure.model()))
    end
    return worst
end

function push_waving()
    sim.wait(1.5)
    shove(-10, 0)
    sim.wait(1.5)
    return measure.tilt(measure.model())
end

function one_leg()
    local sole = sim.getObject('/nao/RSole')
    local longest, since = 0, nil
    while sim.getSimulationTime() < 14.5 do
        if sim.getObjectPosition(sole)[3] > 0.0015 then
            since = since or sim.getSimulationTime()
            longest = math.max(longest, sim.getSimulationTime() - since)
        else
            since = nil
        end
        sim.step()
    end
    return longest
end

function upright()
    local worst = 0
    while sim.getSimulationTime() < 60 do
        worst = math.max(worst, measure.tilt(measure.model()))
        sim.step()
    end
    return worst
end

function sonar()
    local sensor = sim.getObject('/nao/LSonar')
    local at = sim.getObjectPosition(sensor)
    local wall = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.1, 2, 0.3})
    sim.setObjectPosition(wall, {at[1] + 1.05, at[2], at[3]})
    sim.wait(0.5)
    return tatu.read(sensor).distance
end

function inverse_kinematics()
    local legs = sim.getScriptFunctions(sim.getScript(sim.scripttype_simulation, sim.getObject('/nao/kinematics')))
    local worst = 0
    for k = 1, 200 do
        local side = k % 2 == 0 and 1 or -1
        local joints = {(math.random() - 0.5) * 1.2, (math.random() - 0.5) * 0.7, -math.random(),
            0.1 + math.random() * 1.5, -math.random(), (math.random() - 0.5) * 0.7}
        local x, y, z, m = legs:footOf(joints, side)
        local yaw, pitch, roll = math.atan(m[2][1], m[1][1]), -math.asin(m[3][1]), math.atan(m[3][2], m[3][3])
        local again = legs:jointsOf(x, y, z, roll, pitch, yaw, side)
        for i = 1, 6 do worst = math.max(worst, math.abs(again[i] - joints[i])) end
    end
    return worst
end
