--- sim.createJoint
local j = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_kinematic, 0)
assert(sim.getJointType(j) == sim.joint_prismatic_subtype and sim.getJointMode(j) == 0)
--- sim.createForceSensor
local f = sim.createForceSensor(0, {0, 1, 1, 0, 0}, {0.1, 0, 0, 0, 0})
assert(sim.getObjectType(f) == sim.object_forcesensor_type)
--- sim.breakForceSensor
function sysCall_init()
    base = sim.createPureShape(0, 16, {0.1, 0.1, 0.1}, 1)
    tool = sim.createPureShape(0, 0, {0.1, 0.1, 0.1}, 2)
    sensor = sim.createForceSensor(0, {0, 1, 1, 0, 0}, {0.1, 0, 0, 0, 0})
    sim.setObjectPosition(base, {80, 0, 2})
    sim.setObjectPosition(sensor, {80, 0, 2.1})
    sim.setObjectPosition(tool, {80, 0, 2.1})
    sim.setObjectParent(sensor, base, true)
    sim.setObjectParent(tool, sensor, true)
    sim.breakForceSensor(sensor)
end
function sysCall_sensing()
    if sim.getSimulationTime() > 0.3 then
        assert(sim.getObjectPosition(tool)[3] < 2)
    end
end
--- sim.readForceSensor
function sysCall_init()
    base = sim.createPureShape(0, 16, {0.1, 0.1, 0.1}, 1)
    tool = sim.createPureShape(0, 0, {0.1, 0.1, 0.1}, 2)
    sensor = sim.createForceSensor(0, {0, 1, 1, 0, 0}, {0.1, 0, 0, 0, 0})
    sim.setObjectPosition(base, {82, 0, 2})
    sim.setObjectPosition(sensor, {82, 0, 2.1})
    sim.setObjectPosition(tool, {82, 0, 2.1})
    sim.setObjectParent(sensor, base, true)
    sim.setObjectParent(tool, sensor, true)
end
function sysCall_sensing()
    local result, force, torque = sim.readForceSensor(sensor)
    if sim.getSimulationTime() > 0.3 then
        assert(result == 1 and math.abs(force[3] + 2 * 9.81) < 0.01 and #torque == 3)
    end
end
--- sim.setSphericalJointMatrix
local j = sim.createJoint(sim.joint_spherical_subtype, sim.jointmode_kinematic, 0)
sim.setSphericalJointMatrix(j, {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0})
assert(math.abs(sim.getJointMatrix(j)[7] + 1) < 1e-9)
--- sim.getJointDependency
local j = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_kinematic, 0)
assert(sim.getJointDependency(j) == -1)
--- sim.setJointDependency
local a = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_kinematic, 0)
local b = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_kinematic, 0)
sim.setJointDependency(b, a, 0.1, 2)
local master, offset, factor = sim.getJointDependency(b)
assert(master == a and offset == 0.1 and factor == 2)
--- sim.getObjectChildPose
local j = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_kinematic, 0)
sim.setJointPosition(j, 0.25)
assert(sim.getObjectChildPose(j)[3] == 0.25)
--- sim.setObjectChildPose
local j = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_kinematic, 0)
sim.setObjectChildPose(j, {0, 0, 0.25, 0, 0, 0, 1})
assert(sim.getJointPosition(j) == 0.25)
--- sim.generateTextShape
local text = sim.generateTextShape('Tatu', {1, 0, 0}, 0.7, true)
assert(sim.getObjectType(text) == sim.object_shape_type)
local low, high = sim.getObjectFloatParam(text, 16), sim.getObjectFloatParam(text, 19)
assert(math.abs(high - low - 0.7) < 1e-9 and sim.getObjectPosition(text)[1] == 0)
