-- Measurements of `card.toml`. All motor torques are read at rest, without dry friction, which would carry part of the
-- load.

local READY = {0, -math.pi / 4, 0, -3 * math.pi / 4, 0, math.pi / 2, math.pi / 4}      -- rad
local HELD = {0, 1.1, 0, -0.6, 0, 1.7, math.pi / 4}      -- rad: the flange 0.80 m ahead, pointing down
local SHOULDER = {0, 0, 0.333}                           -- m, in the frame of the base

local function joint(i)
    return sim.getObject('/panda/panda_joint' .. i)
end

local function flange()
    return sim.getObject('/panda/panda_link8')
end

local function kinematics()
    return sim.getScriptFunctions(sim.getScript(sim.scripttype_simulation, sim.getObject('/panda/kinematics')))
end

-- Returns the position of the flange according to the kinematics script, m.
local function computed(q)
    local pose = kinematics():forward(q)
    return {pose[1], pose[2], pose[3]}
end

local function go(q, seconds)
    for i = 1, 7 do sim.setJointTargetPosition(joint(i), q[i]) end
    sim.wait(seconds)
end

local function without_friction()
    for i = 1, 7 do sim.setFloatProperty(joint(i), 'joint.dry_friction', 0) end
end

local function error_at(q, expected)
    go(q, 4)
    return measure.distance(sim.getObjectPosition(flange(), sim.getObject('/panda')), expected)
end

function mass()
    return measure.mass(measure.model())
end

mass_identified = mass

function rest_drift()
    return measure.drift(flange(), 60)
end

-- Joint 4 cannot reach 0, so this checks the computation of the kinematics, not the simulated arm.
function flange_zero()
    return measure.distance(computed({0, 0, 0, 0, 0, 0, 0}), {0.088, 0, 0.926})
end

function flange_ready()
    return error_at(READY, {0.30689, 0, 0.59028})
end

function flange_bent()
    return error_at({0, 0, 0, -1.5708, 0, 1.5708, -0.7853}, {0.5545, 0, 0.6245})
end

function flange_direction()
    sim.wait(1)
    return math.pi - measure.tilt(flange())
end

function inverse_error()
    local k, worst = kinematics(), 0
    for _ = 1, 100 do
        local q = {}
        for i = 1, 7 do
            local _, interval = sim.getJointInterval(joint(i))
            q[i] = interval[1] + interval[2] * math.random()
        end
        local solution = k:inverse(k:forward(q), q[7], q)[1]
        if not solution then return math.huge end
        for i = 1, 7 do worst = math.max(worst, math.abs(solution[i] - q[i])) end
    end
    return worst
end

local function gravity_torque(i)
    without_friction()
    sim.wait(2)
    return math.abs(sim.getJointForce(joint(i)))
end

function gravity_torque_2() return gravity_torque(2) end
function gravity_torque_3() return gravity_torque(3) end
function gravity_torque_4() return gravity_torque(4) end
function gravity_torque_5() return gravity_torque(5) end
function gravity_torque_6() return gravity_torque(6) end
gravity_torque_2_identified = gravity_torque_2
gravity_torque_4_identified = gravity_torque_4

-- The speed of a joint in the middle half of its travel from `low` to `high`, rad.
local function top_speed(i, low, high)
    sim.setJointTargetPosition(joint(i), low)
    sim.wait(3)
    sim.setJointTargetPosition(joint(i), high)
    local first, last
    for _ = 1, 60 do
        sim.step()
        local position, time = sim.getJointPosition(joint(i)), sim.getSimulationTime()
        local part = (position - low) / (high - low)
        if part > 0.25 and not first then first = {position, time} end
        if part < 0.75 then last = {position, time} end
    end
    if math.abs(sim.getJointPosition(joint(i)) - high) > 1e-3 then error('joint ' .. i .. ' has not arrived') end
    return (last[1] - first[1]) / (last[2] - first[2])
end

function top_speed_1() return top_speed(1, -2.8, 2.8) end
function top_speed_2() return top_speed(2, -1.7, 0.3) end
function top_speed_3() return top_speed(3, -2.8, 2.8) end
function top_speed_4() return top_speed(4, -3.0, -0.1) end
function top_speed_5() return top_speed(5, -2.8, 2.8) end
function top_speed_6() return top_speed(6, 0.0, 3.7) end
function top_speed_7() return top_speed(7, -2.8, 2.8) end

-- The arm is straightest where the offsets of the elbow are collinear, not at the limit of joint 4.
function reach()
    local most, best = 0, nil
    for q4 = -1, -0.07, 0.01 do
        for q6 = 0, 3.7, 0.02 do
            local q = {0, 0, 0, q4, 0, q6, 0}
            local r = measure.distance(computed(q), SHOULDER)
            if r > most then most, best = r, q end
        end
    end
    go(best, 4)
    return measure.distance(sim.getObjectPosition(flange(), sim.getObject('/panda')), SHOULDER)
end

-- Attaches 3 kg to the flange, with the centre of mass 5 cm in front of its face.
local function load_flange()
    local slot = sim.getObject('/panda/flange')
    local weight = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.08, 0.08, 0.08})
    sim.setShapeMass(weight, 3)
    sim.setObjectParent(weight, slot, false)
    sim.setObjectPosition(weight, {0, 0, 0.05}, slot)
    sim.setBoolProperty(weight, 'shape.dynamic', true)
end

function payload_sag()
    go(HELD, 4)
    local before = sim.getObjectPosition(flange())
    load_flange()
    sim.wait(10)
    return measure.distance(before, sim.getObjectPosition(flange()))
end

local function payload_torque(i)
    without_friction()
    go(HELD, 4)
    load_flange()
    sim.wait(4)
    return math.abs(sim.getJointForce(joint(i)))
end

function payload_torque_2() return payload_torque(2) end
function payload_torque_6() return payload_torque(6) end

function repeatability()
    go(READY, 2)
    local first, most = sim.getObjectPosition(flange()), 0
    for turn = 1, 10 do
        local away = {}
        for i = 1, 7 do away[i] = READY[i] + 0.5 * math.sin(turn + i) end
        go(away, 2)
        go(READY, 2)
        most = math.max(most, measure.distance(first, sim.getObjectPosition(flange())))
    end
    return most
end

-- With the timing of panda.lua: the swing runs from 6.5 s to 12.5 s.
function elbow_swing()
    while sim.getSimulationTime() < 6.8 do sim.step() end
    return measure.drift(flange(), 5)
end
