--- sim.createJoint
local j = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_kinematic, 0)
assert(sim.getJointType(j) == sim.joint_prismatic_subtype and sim.getJointMode(j) == 0)
--- sim.createForceSensor
local f = sim.createForceSensor(0, {0, 1, 1, 0, 0}, {0.1, 0, 0, 0, 0})
assert(sim.getObjectType(f) == sim.object_forcesensor_type)
--- sim.breakForceSensor
local f, d = sim.createForceSensor(0, {0, 1, 1, 0, 0}, {0.1, 0, 0, 0, 0}), sim.createDummy(0.01)
sim.setObjectParent(d, f, true)
sim.breakForceSensor(f)
assert(sim.getObjectParent(d) == -1)
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
