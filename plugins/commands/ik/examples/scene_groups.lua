--- sim.handleIkGroup
local joint = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_passive, 0)
local tip, target = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(tip, joint, true)
local group = sim.createIkGroup(0)
sim.createIkElement(group, 0, {tip, -1, -1, 4})
assert(sim.handleIkGroup(group) == 1)
sim.removeIkGroup(group)
sim.removeObjects{joint, tip, target}

--- sim.setIkGroupProperties
local group = sim.createIkGroup(0)
sim.setIkGroupProperties(group, 1, 50, 0.1)
sim.removeIkGroup(group)

--- sim.setIkElementProperties
local joint = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_passive, 0)
local tip, target = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(tip, joint, true)
local group = sim.createIkGroup(0)
sim.createIkElement(group, 0, {tip, -1, -1, 4})
sim.setIkElementProperties(group, tip, 7, {0.001, 0.01}, {1, 1})
sim.removeIkGroup(group)
sim.removeObjects{joint, tip, target}

--- sim.createIkGroup
local group = sim.createIkGroup(0, {1, 50}, {0.1})
sim.removeIkGroup(group)

--- sim.createIkElement
local joint = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_passive, 0)
local tip, target = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(tip, joint, true)
local group = sim.createIkGroup(0)
sim.createIkElement(group, 0, {tip, -1, -1, 4})
sim.removeIkGroup(group)
sim.removeObjects{joint, tip, target}

--- sim.removeIkGroup
local group = sim.createIkGroup(0)
sim.removeIkGroup(group)

--- sim.checkIkGroup
local joint = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_passive, 0)
local tip, target = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(tip, joint, true)
local group = sim.createIkGroup(0)
sim.createIkElement(group, 0, {tip, -1, -1, 4})
local result, positions = sim.checkIkGroup(group, {joint})
assert(result == 1 and positions[1] == 0)
sim.removeIkGroup(group)
sim.removeObjects{joint, tip, target}

--- sim.computeJacobian
local joint = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_passive, 0)
local tip, target = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(tip, joint, true)
local group = sim.createIkGroup(0)
sim.createIkElement(group, 0, {tip, -1, -1, 4})
sim.computeJacobian(group, 0)
sim.removeIkGroup(group)
sim.removeObjects{joint, tip, target}

--- sim.getIkGroupMatrix
local joint = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_passive, 0)
local tip, target = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(tip, joint, true)
local group = sim.createIkGroup(0)
sim.createIkElement(group, 0, {tip, -1, -1, 4})
sim.computeJacobian(group, 0)
local matrix, size = sim.getIkGroupMatrix(group, 0)
assert(matrix[1] == 1)
sim.removeIkGroup(group)
sim.removeObjects{joint, tip, target}

--- sim.getConfigForTipPose
local joint = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_passive, 0)
local tip, target = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(tip, joint, true)
local group = sim.createIkGroup(0)
sim.createIkElement(group, 0, {tip, -1, -1, 4})
local found = sim.getConfigForTipPose(group, {joint}, 0.1, 10)
sim.removeIkGroup(group)
sim.removeObjects{joint, tip, target}

--- sim.generateIkPath
local joint = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_passive, 0)
local tip, target = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(tip, joint, true)
local group = sim.createIkGroup(0)
sim.createIkElement(group, 0, {tip, -1, -1, 4})
local path = sim.generateIkPath(group, {joint}, 2)
assert(#path == 2)
sim.removeIkGroup(group)
sim.removeObjects{joint, tip, target}

--- sim.getAlternateConfigs
local joint = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_passive, 0)
local tip, target = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(tip, joint, true)
local group = sim.createIkGroup(0)
sim.createIkElement(group, 0, {tip, -1, -1, 4})
assert(#sim.getAlternateConfigs({joint}, {0}) == 1)
sim.removeIkGroup(group)
sim.removeObjects{joint, tip, target}
