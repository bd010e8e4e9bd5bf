-- Measurements of `card.toml`. Positions are those of the platform in the frame of the base, m.

local HOME = math.rad(5.328)
local PLACES = {
    {0.249, 0.255, -1.011}, {0.58, -0.03, -0.90}, {-0.30, 0.30, -1.10}, {-0.40, -0.20, -0.95}, {0.10, -0.35, -1.15},
}

local function motor(i)
    return sim.getObject('/delta/motor_' .. i)
end

local function platform()
    return sim.getObject('/platform')
end

local function place()
    return sim.getObjectPosition(platform(), sim.getObject('/delta'))
end

local function kinematics()
    return sim.getScriptFunctions(sim.getScript(sim.scripttype_simulation, sim.getObject('/delta/kinematics')))
end

local function turn(angles)
    for i = 1, 3 do sim.setJointTargetPosition(motor(i), angles[i]) end
end

local function go(position, seconds)
    local angles, why = kinematics():inverse(position)
    if not angles then error(why) end
    turn(angles)
    sim.wait(seconds)
end

function mass()
    return measure.mass(measure.model())
end

function rest_drift()
    return measure.drift(platform(), 60)
end

local function height(degrees)
    local q = math.rad(degrees)
    turn{q, q, q}
    sim.wait(3)
    return place()[3]
end

function height_up_30() return height(-30) end
function height_0() return height(0) end
function height_30() return height(30) end
function height_45() return height(45) end
function height_60() return height(60) end

function inverse_error()
    local k, worst = kinematics(), 0
    for _ = 1, 200 do
        local q = {}
        for i = 1, 3 do q[i] = math.rad(-20 + 80 * math.random()) end
        local position = k:forward(q)
        local angles = position and k:inverse(position)
        if not angles then error(string.format('no solution at %.3f %.3f %.3f rad', q[1], q[2], q[3])) end
        for i = 1, 3 do worst = math.max(worst, math.abs(angles[i] - q[i])) end
    end
    return worst
end

local function worst_of_places(value)
    local worst = 0
    for _, position in ipairs(PLACES) do
        go(position, 3)
        worst = math.max(worst, value(position))
    end
    return worst
end

function place_error()
    return worst_of_places(function(position) return measure.distance(place(), position) end)
end

function tilt()
    return worst_of_places(function() return measure.tilt(platform()) end)
end

local function worst_of_steps(seconds, value)
    local worst, stop = 0, sim.getSimulationTime() + seconds
    while sim.getSimulationTime() < stop do
        sim.step()
        worst = math.max(worst, value())
    end
    return worst
end

function tilt_moving()
    return worst_of_steps(20, function() return measure.tilt(platform()) end)
end

function loop_gap()
    return worst_of_steps(20, function()
        local worst = 0
        for i = 2, 3 do
            local a, b = sim.getObject('/side_' .. i), sim.getObject('/loop_' .. i)
            worst = math.max(worst, measure.distance(sim.getObjectPosition(a), sim.getObjectPosition(b)))
        end
        return worst
    end)
end

-- Attaches a weight below the platform, with its centre of mass on the robot's axis.
local function load(mass)
    local slot = sim.getObject('/tool')
    local weight = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.08, 0.08, 0.08})
    sim.setShapeMass(weight, mass)
    sim.setObjectParent(weight, slot, false)
    sim.setObjectPosition(weight, {0, 0, 0.05}, slot)
    sim.setBoolProperty(weight, 'shape.dynamic', true)
end

local function mean_torque()
    local sum = 0
    for i = 1, 3 do sum = sum + math.abs(sim.getJointForce(motor(i))) end
    return sum / 3
end

function gravity_torque()
    turn{0, 0, 0}
    sim.wait(4)
    return mean_torque()
end

function payload_torque()
    load(6)
    turn{0, 0, 0}
    sim.wait(4)
    return mean_torque()
end

function payload_sag()
    go({0.20, 0.22, -1.05}, 4)
    local before = place()
    load(6)
    sim.wait(10)
    return measure.distance(before, place())
end

function repeatability()
    local home, most = {HOME, HOME, HOME}, 0
    turn(home)
    sim.wait(2)
    local first = place()
    for k = 1, 10 do
        turn{0.3 + 0.3 * math.sin(k), 0.3 + 0.3 * math.sin(k + 2), 0.3 + 0.3 * math.sin(k + 4)}
        sim.wait(1.5)
        turn(home)
        sim.wait(1.5)
        most = math.max(most, measure.distance(first, place()))
    end
    return most
end

function suction_slip()
    local tip = sim.getObject('/suction_tip')
    local piece = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.06, 0.06, 0.04})
    sim.setShapeMass(piece, 1)
    sim.setObjectPosition(piece, {0, 0, -0.02}, tip)
    local tie = sim.createDummy(0.01)
    sim.setObjectPose(tie, sim.getObjectPose(tip))
    sim.setObjectParent(tie, piece, true)
    tatu.set(tie, 'dummy.link', sim.getObjectAlias(tip, 2))
    sim.setBoolProperty(piece, 'shape.dynamic', true)
    go({0, 0, -1}, 2)
    local k, start = kinematics(), sim.getSimulationTime()
    return worst_of_steps(20, function()
        local t = sim.getSimulationTime() - start
        turn(k:inverse{0.2 * math.sin(math.pi * t), 0, -1})
        return measure.distance(sim.getObjectPosition(tie), sim.getObjectPosition(tip))
    end)
end
