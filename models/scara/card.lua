-- Measurements of the SCARA. Without its controller, the joints hold their targets.

local NAMES = {'base_arm_motor', 'arm_motor', 'shaft_rotation_motor', 'shaft_linear_motor'}

local function at(name)
    return sim.getObject('/ScaraT6/' .. name)
end

local function kinematics(name, ...)
    return sim.callScriptFunction(name, sim.getScript(sim.scripttype_childscript, at('kinematics')), ...)
end

-- Moves the joints to positions, rad and m, and waits until they arrive.
local function pose(positions, seconds)
    for i, name in ipairs(NAMES) do sim.setJointTargetPosition(at(name), positions[i]) end
    sim.wait(seconds or 3)
end

function mass()
    -- The base is fixed to the world, but its mass is included. The gripper is excluded, because it is not Epson's.
    return measure.mass(measure.model()) + sim.getShapeMass(measure.model())
end

function rest_drift()
    pose({0.5, 0.8, 0, -0.05})
    return measure.drift(at('tip'), 60)
end

function stretched_reach()
    pose({0, 0, 0, 0})
    return sim.getObjectPosition(at('tool'))[1]
end

function bent_side()
    pose({0, math.pi / 2, 0, 0})
    return sim.getObjectPosition(at('tool'))[2]
end

-- Maximum speed of an arm's joint during a long move.
local function top_speed(name, goal)
    local joint, greatest = at(name), 0
    sim.setJointTargetPosition(joint, -goal)
    sim.wait(2)
    sim.setJointTargetPosition(joint, goal)
    for _ = 1, 20 do
        sim.step()
        greatest = math.max(greatest, sim.getJointVelocity(joint))
    end
    return greatest
end

function speed_1()
    return top_speed('base_arm_motor', 2)
end

function speed_2()
    return top_speed('arm_motor', 2)
end

function shaft_speed()
    return top_speed('shaft_rotation_motor', 3)
end

function stroke()
    -- The shaft's end would reach the floor.
    for _, shape in ipairs(sim.getObjectsInTree(measure.model(), sim.object_shape_type)) do
        sim.setObjectInt32Param(shape, sim.shapeintparam_respondable, 0)
    end
    pose({0, 0, 0, 0})
    local top = sim.getObjectPosition(at('tool'))[3]
    pose({0, 0, 0, -0.3})
    return top - sim.getObjectPosition(at('tool'))[3]
end

-- Maximum distance between the shaft's end and the target of the closed-form solution, at 12 positions.
function position_error()
    local worst = 0
    for k = 0, 11 do
        local a, r = math.rad(-80 + 160 * k / 11), 0.35 + 0.04 * (k % 5)
        local goal = {0.06 + r * math.cos(a), r * math.sin(a), 0.1 + 0.01 * (k % 6)}
        local joints = kinematics('inverse', goal, 0, k % 2 * 2 - 1)
        if not joints then return 1 end
        pose(joints, 4)
        worst = math.max(worst, measure.distance(goal, sim.getObjectPosition(at('tool'))))
    end
    return worst
end

-- Sag of the shaft under 6 kg.
function payload_sag()
    pose({0, 0, 0, -0.1})
    local before = sim.getObjectPosition(at('tool'))[3]
    local shaft = at('shaft_solid')
    local start = sim.getSimulationTime()
    while sim.getSimulationTime() < start + 5 do
        sim.addForceAndTorque(shaft, {0, 0, -6 * 9.81}, {0, 0, 0})
        sim.step()
    end
    return before - sim.getObjectPosition(at('tool'))[3]
end

-- Position error of a piece of 30 g that the controller has moved to the other tray.
function placed_error()
    for _, y in ipairs{0.24, -0.24} do
        local tray = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.14, 0.2, 0.03})
        sim.setObjectPosition(tray, {0.36, y, 0.015})
        sim.setObjectInt32Param(tray, sim.shapeintparam_respondable, 1)
    end
    local piece = sim.createPrimitiveShape(sim.primitiveshape_cylinder, {0.025, 0.025, 0.025})
    sim.setShapeMass(piece, 0.03)
    sim.setObjectInt32Param(piece, sim.shapeintparam_static, 0)
    sim.setObjectInt32Param(piece, sim.shapeintparam_respondable, 1)
    sim.setObjectPosition(piece, {0.33, 0.18, 0.0425})
    sim.wait(12)
    return measure.distance(sim.getObjectPosition(piece), {0.33, -0.3, 0.0425})
end
