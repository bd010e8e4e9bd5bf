-- Measurements of the UR5 and UR5e. Each function runs in a separate world that contains a floor and the arm.

local JOINTS = {'shoulder_pan', 'shoulder_lift', 'elbow', 'wrist_1', 'wrist_2', 'wrist_3'}
local DOWN = -math.pi / 2
local STRETCHED = {0, 0, 0, 0, 0, 0}
local SETTLE = 4    -- s

local function part(alias)
    for _, object in ipairs(sim.getObjectsInTree(measure.model())) do
        if sim.getObjectAlias(object) == alias then return object end
    end
    error('no part ' .. alias)
end

local function joint(name)
    return part(name .. '_joint')
end

local function go(angles)
    for i, name in ipairs(JOINTS) do sim.setJointTargetPosition(joint(name), angles[i]) end
    sim.wait(SETTLE)
end

-- Disables collisions, because some poses of the tables pass through the arm itself and the floor.
local function free_of_contacts()
    for _, shape in ipairs(sim.getObjectsInTree(measure.model(), sim.object_shape_type)) do
        sim.setObjectInt32Param(shape, sim.shapeintparam_respondable, 0)
    end
end

-- Attaches a small body of 5 kg below the flange.
local function load_flange()
    local flange = part('flange')
    local body = sim.createPrimitiveShape(sim.primitiveshape_spheroid, {0.05, 0.05, 0.05})
    sim.setObjectInt32Param(body, sim.shapeintparam_respondable, 0)
    sim.setObjectInt32Param(body, sim.shapeintparam_static, 0)
    sim.setObjectPosition(body, sim.getObjectPosition(flange))
    sim.setObjectParent(body, flange, true)
    sim.setShapeMass(body, 5)
end

local function worst_position(poses)
    free_of_contacts()
    local worst = 0
    for _, pose in ipairs(poses) do
        go(pose)
        worst = math.max(worst, measure.distance(sim.getObjectPosition(part('tool0')), pose.at))
    end
    return worst
end

local function torque(name, angles, loaded)
    free_of_contacts()
    if loaded then load_flange() end
    go(angles)
    return math.abs(sim.getJointForce(joint(name)))
end

local function call(name, ...)
    return sim.callScriptFunction(name, sim.getScript(sim.scripttype_simulation, part('kinematics')), ...)
end

function mass()
    return measure.mass(measure.model())
end

mass_ur5e = mass

function rest_drift()
    return measure.drift(part('tool0'), 60)
end

-- The maker's tables refer to a frame that is rotated by half a turn about z: x and y change their signs here.
function forward_kinematics()
    return worst_position{
        {0, 0, 0, 0, 0, 0, at = {0.81725, 0.19145, -0.00549}},
        {1.658062789, 5.235987756, 2.844886681, 4.01425728, 2.00712864, 0.523598776, at = {-0.09445, 0.22632, 0.02455}},
        {0, 1.623156204, 2.862339973, 5.585053606, 4.36332313, 2.862339973, at = {0.00825, 0.08100, 0.07599}},
        {0, DOWN, 0, DOWN, 0, 0, at = {0, 0.19145, 1.00106}},
        {0, DOWN, -DOWN, DOWN, DOWN, 0, at = {0.4869, 0.10915, 0.43186}},
        {-DOWN, DOWN, -DOWN, DOWN, DOWN, 0, at = {-0.10915, 0.4869, 0.43186}},
    }
end

function forward_kinematics_ur5e()
    return worst_position{
        {0, 0, 0, 0, 0, 0, at = {0.8172, 0.2329, 0.0628}},
        {0, DOWN, 0, DOWN, 0, 0, at = {0, 0.2329, 1.0794}},
        {0, DOWN, -DOWN, DOWN, DOWN, 0, at = {0.4919, 0.1333, 0.4879}},
    }
end

function inverse_solutions()
    return #call('inverse', call('forward', {0.3, -1.2, 1.4, -1.0, -1.3, 0.5}))
end

function inverse_error()
    local worst = 0
    for _ = 1, 200 do
        local q = {}
        for i = 1, 6 do q[i] = (2 * math.random() - 1) * math.pi end
        local pose = call('forward', q)
        local solutions = call('inverse', pose)
        if #solutions == 0 then error('no solution for a pose of the workspace') end
        for _, solution in ipairs(solutions) do
            local again = call('forward', solution)
            for i = 1, 12 do worst = math.max(worst, math.abs(again[i] - pose[i])) end
        end
    end
    return worst
end

function shoulder_torque() return torque('shoulder_lift', STRETCHED) end

shoulder_torque_ur5e = shoulder_torque

function elbow_torque() return torque('elbow', STRETCHED) end

function shoulder_torque_loaded() return torque('shoulder_lift', STRETCHED, true) end

function elbow_torque_loaded() return torque('elbow', STRETCHED, true) end

function shoulder_torque_home() return torque('shoulder_lift', {0, DOWN, -DOWN, DOWN, DOWN, 0}) end

function joint_speed()
    free_of_contacts()
    go{0, DOWN, 0, DOWN, 0, 0}
    local slowest = math.huge
    for _, name in ipairs(JOINTS) do
        local handle = joint(name)
        local start, top = sim.getJointPosition(handle), 0
        sim.setJointTargetPosition(handle, start + 2.5)
        for _ = 1, 40 do
            sim.wait(0.05)
            top = math.max(top, sim.getJointVelocity(handle))
        end
        sim.setJointTargetPosition(handle, start)
        sim.wait(2)
        slowest = math.min(slowest, top)
    end
    return slowest
end

function payload_sag()
    free_of_contacts()
    load_flange()
    go(STRETCHED)
    return measure.drift(part('tool0'), 10)
end

function reach()
    free_of_contacts()
    go(STRETCHED)
    local shoulder, wrist = sim.getObjectPosition(joint('shoulder_lift')), sim.getObjectPosition(joint('wrist_1'))
    return math.sqrt((wrist[1] - shoulder[1]) ^ 2 + (wrist[3] - shoulder[3]) ^ 2)
end

-- Radii of the flange about the middle of the circle during a turn.
local function radii()
    sim.wait(12)
    local list, tool = {}, part('tool0')
    for i = 1, 120 do
        local p = sim.getObjectPosition(tool)
        list[i] = math.sqrt((p[1] - 0.45) ^ 2 + (p[2] - 0.11) ^ 2)
        sim.wait(0.05)
    end
    return list
end

function circle_radius()
    local list, sum = radii(), 0
    for _, radius in ipairs(list) do sum = sum + radius end
    return sum / #list
end

function circle_error()
    local worst = 0
    for _, radius in ipairs(radii()) do worst = math.max(worst, math.abs(radius - 0.12)) end
    return worst
end

function wrench()
    load_flange()
    sim.wait(1)
    local sensor, sum = part('tcp_fts_sensor'), 0
    for _ = 1, 40 do
        sim.wait(0.05)
        local force = tatu.read(sensor).force
        sum = sum + force[3] / 40
    end
    return sum
end
