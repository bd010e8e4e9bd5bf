-- Measurements of the arm. Without its controller, the joints hold their targets.

local function at(name)
    return sim.getObject('/arm_link_0/' .. name)
end

local function joint(i)
    return at('arm_joint_' .. i)
end

local function kinematics(name, ...)
    return sim.callScriptFunction(name, sim.getScript(sim.scripttype_childscript, at('kinematics')), ...)
end

-- Moves the joints to angles, rad, and waits until they arrive.
local function pose(angles, seconds)
    for i = 1, 5 do sim.setJointTargetPosition(joint(i), angles[i]) end
    sim.wait(seconds or 6)
end

-- Moves the joints to angles at constant speeds within some seconds.
local function glide(angles, seconds)
    local from, start = {}, sim.getSimulationTime()
    for i = 1, 5 do from[i] = sim.getJointTargetPosition(joint(i)) end
    repeat
        local part = math.min(1, (sim.getSimulationTime() - start) / seconds)
        for i = 1, 5 do sim.setJointTargetPosition(joint(i), from[i] + part * (angles[i] - from[i])) end
        sim.step()
    until part == 1
end

local UPRIGHT = {2.9496, 1.1345, -2.5482, 1.7890, 2.9234}
local LEVEL = {2.9496, 1.1345 + math.pi / 2, -2.5482, 1.7890, 2.9234}

function mass()
    -- The foot is fixed to the world, but its mass is included.
    return measure.mass(measure.model()) + sim.getShapeMass(measure.model())
end

function rest_drift()
    pose({2.9, 1.6, -1.8, 2.5, 2.9})
    return measure.drift(at('gripper_tip'), 60)
end

function upright_height()
    pose(UPRIGHT)
    return sim.getObjectPosition(at('arm_link_5'))[3]
end

function level_reach()
    pose(LEVEL)
    return sim.getObjectPosition(at('arm_link_5'))[1]
end

-- Maximum speed of joint 1 during half a turn.
function joint_speed()
    sim.setJointTargetPosition(joint(1), 3.2)
    local greatest = 0
    for _ = 1, 60 do
        sim.step()
        greatest = math.max(greatest, sim.getJointVelocity(joint(1)))
    end
    return greatest
end

-- Maximum distance between the fingers' middle and the target of the closed-form solution, at 12 positions.
function position_error()
    local worst = 0
    for k = 0, 11 do
        local a, r, z = math.rad(-150 + 300 * k / 11), 0.15 + 0.01 * (k % 5), 0.02 + 0.01 * (k % 4)
        local goal = {0.024 + r * math.cos(a), r * math.sin(a), z}
        local angles = kinematics('inverse', goal, math.pi, 0)
        if not angles then return 1 end
        pose(angles, 4)
        worst = math.max(worst, measure.distance(goal, sim.getObjectPosition(at('gripper_tip'))))
    end
    return worst
end

-- Lifts 0.5 kg by 60 mm, holds it for 10 s, and returns the distance of joint 2 from its target.
function payload_sag()
    local weight = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.03, 0.03, 0.03})
    sim.setShapeMass(weight, 0.5)
    sim.setObjectInt32Param(weight, sim.shapeintparam_static, 0)
    sim.setObjectInt32Param(weight, sim.shapeintparam_respondable, 1)
    local goal = {0.2, 0, 0.015}
    sim.setObjectPosition(weight, goal)
    pose(kinematics('inverse', {0.2, 0, 0.075}, math.pi, 0), 5)
    pose(kinematics('inverse', goal, math.pi, 0), 3)
    sim.setJointTargetPosition(at('gripper_finger_joint_l'), 0)
    sim.wait(1)
    local held = kinematics('inverse', {0.2, 0, 0.075}, math.pi, 0)
    glide(held, 2)
    sim.wait(10)
    if measure.distance(sim.getObjectPosition(weight), sim.getObjectPosition(at('gripper_tip'))) > 0.01 then
        error('payload_sag: the weight has slipped out of the gripper')
    end
    return math.abs(sim.getJointPosition(joint(2)) - held[2])
end

-- Position error of a cube of 50 g that the controller has carried, after one cycle of its demonstration.
function carried_error()
    local cube = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.03, 0.03, 0.03})
    sim.setShapeMass(cube, 0.05)
    sim.setObjectInt32Param(cube, sim.shapeintparam_static, 0)
    sim.setObjectInt32Param(cube, sim.shapeintparam_respondable, 1)
    sim.setObjectPosition(cube, {0.2, 0.1, 0.015})
    for _ = 1, 1000 do
        sim.step()
        if sim.readCustomStringData(measure.model(), 'part') == 'place' then break end
    end
    return measure.distance(sim.getObjectPosition(cube), {0.2, -0.1, 0.015})
end

function gripper_opening()
    sim.wait(1)
    local l, r = sim.getObjectPosition(at('gripper_finger_link_l')), sim.getObjectPosition(at('gripper_finger_link_r'))
    -- The fingers are 9 mm thick.
    return measure.distance(l, r) - 0.009
end
