--- simIK.createEnvironment
local env = simIK.createEnvironment()
assert(simIK.getObjects(env, 0) == nil)
simIK.eraseEnvironment(env)

--- simIK.eraseEnvironment
local env = simIK.createEnvironment()
simIK.eraseEnvironment(env)

--- simIK.duplicateEnvironment
local env = simIK.createEnvironment()
local dummy = simIK.createDummy(env, 'frame')
local copy = simIK.duplicateEnvironment(env)
assert(simIK.doesObjectExist(copy, dummy))
simIK.eraseEnvironment(copy)
simIK.eraseEnvironment(env)

--- simIK.createDummy
local env = simIK.createEnvironment()
local tip = simIK.createDummy(env, 'tip')
assert(simIK.getObjectHandle(env, 'tip') == tip)
simIK.eraseEnvironment(env)

--- simIK.createJoint
local env = simIK.createEnvironment()
local slide = simIK.createJoint(env, simIK.jointtype_prismatic)
simIK.setJointPosition(env, slide, 0.2)
simIK.eraseEnvironment(env)

--- simIK.eraseObject
local env = simIK.createEnvironment()
local dummy = simIK.createDummy(env, 'frame')
simIK.eraseObject(env, dummy)
assert(not simIK.doesObjectExist(env, dummy))
simIK.eraseEnvironment(env)

--- simIK.setObjectParent
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
local tip = simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
simIK.eraseEnvironment(env)

--- simIK.getObjectParent
local env = simIK.createEnvironment()
local dummy = simIK.createDummy(env, 'frame')
assert(simIK.getObjectParent(env, dummy) == simIK.handle_world)
simIK.eraseEnvironment(env)

--- simIK.getObjects
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
local object, name, isJoint = simIK.getObjects(env, 0)
assert(object == joint and isJoint)
simIK.eraseEnvironment(env)

--- simIK.getObjectHandle
local env = simIK.createEnvironment()
local dummy = simIK.createDummy(env, 'frame')
assert(simIK.getObjectHandle(env, 'frame') == dummy)
simIK.eraseEnvironment(env)

--- simIK.doesObjectExist
local env = simIK.createEnvironment()
local dummy = simIK.createDummy(env, 'frame')
assert(simIK.doesObjectExist(env, dummy) and not simIK.doesObjectExist(env, 'tip'))
simIK.eraseEnvironment(env)

--- simIK.getObjectPose
local env = simIK.createEnvironment()
local dummy = simIK.createDummy(env, 'frame')
local pose = simIK.getObjectPose(env, dummy)
assert(#pose == 7 and pose[7] == 1)
simIK.eraseEnvironment(env)

--- simIK.getObjectMatrix
local env = simIK.createEnvironment()
local dummy = simIK.createDummy(env, 'frame')
local m = simIK.getObjectMatrix(env, dummy)
assert(#m == 12 and m[1] == 1)
simIK.eraseEnvironment(env)

--- simIK.getObjectTransformation
local env = simIK.createEnvironment()
local dummy = simIK.createDummy(env, 'frame')
local position, quaternion, angles = simIK.getObjectTransformation(env, dummy)
assert(#position == 3 and #quaternion == 4 and #angles == 3)
simIK.eraseEnvironment(env)

--- simIK.setObjectPose
local env = simIK.createEnvironment()
local dummy = simIK.createDummy(env, 'frame')
simIK.setObjectPose(env, dummy, {0.1, 0, 0.3, 0, 0, 0, 1})
simIK.eraseEnvironment(env)

--- simIK.setObjectMatrix
local env = simIK.createEnvironment()
local dummy = simIK.createDummy(env, 'frame')
simIK.setObjectMatrix(env, dummy, {1, 0, 0, 0.1,  0, 1, 0, 0,  0, 0, 1, 0.3})
simIK.eraseEnvironment(env)

--- simIK.setObjectTransformation
local env = simIK.createEnvironment()
local dummy = simIK.createDummy(env, 'frame')
simIK.setObjectTransformation(env, dummy, {0.1, 0, 0.3}, {0, 0, math.pi / 2})
simIK.eraseEnvironment(env)

--- simIK.getJointMatrix
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
assert(#simIK.getJointMatrix(env, joint) == 12)
simIK.eraseEnvironment(env)

--- simIK.getJointTransformation
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
local position, quaternion, angles = simIK.getJointTransformation(env, joint)
assert(angles[3] == 0)
simIK.eraseEnvironment(env)

--- simIK.getJointPosition
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
assert(simIK.getJointPosition(env, joint) == 0)
simIK.eraseEnvironment(env)

--- simIK.setJointPosition
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
simIK.setJointPosition(env, joint, math.pi / 2)
simIK.eraseEnvironment(env)

--- simIK.setJointMode
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
simIK.setJointMode(env, joint, simIK.jointmode_passive)
simIK.eraseEnvironment(env)

--- simIK.getJointMode
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
assert(simIK.getJointMode(env, joint) == simIK.jointmode_ik)
simIK.eraseEnvironment(env)

--- simIK.getJointType
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
assert(simIK.getJointType(env, joint) == simIK.jointtype_revolute)
simIK.eraseEnvironment(env)

--- simIK.setSphericalJointMatrix
local env = simIK.createEnvironment()
local ball = simIK.createJoint(env, simIK.jointtype_spherical)
simIK.setSphericalJointMatrix(env, ball, {1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0})
simIK.eraseEnvironment(env)

--- simIK.setSphericalJointRotation
local env = simIK.createEnvironment()
local ball = simIK.createJoint(env, simIK.jointtype_spherical)
simIK.setSphericalJointRotation(env, ball, {0, 0, 0.5})
simIK.eraseEnvironment(env)

--- simIK.getJointWeight
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
assert(simIK.getJointWeight(env, joint) == 1)
simIK.eraseEnvironment(env)

--- simIK.setJointWeight
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
simIK.setJointWeight(env, joint, 0.1)
simIK.eraseEnvironment(env)

--- simIK.getJointMaxStepSize
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
assert(simIK.getJointMaxStepSize(env, joint) == 0)
simIK.eraseEnvironment(env)

--- simIK.setJointMaxStepSize
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
simIK.setJointMaxStepSize(env, joint, 0.1)
simIK.eraseEnvironment(env)

--- simIK.getJointScrewLead
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
assert(simIK.getJointScrewLead(env, joint) == 0)
simIK.eraseEnvironment(env)

--- simIK.setJointScrewLead
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
simIK.setJointScrewLead(env, joint, 0.001)
simIK.eraseEnvironment(env)

--- simIK.getJointLimitMargin
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
assert(simIK.getJointLimitMargin(env, joint) == 0)
simIK.eraseEnvironment(env)

--- simIK.setJointLimitMargin
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
simIK.setJointLimitMargin(env, joint, 0.1)
simIK.eraseEnvironment(env)

--- simIK.getJointInterval
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
local cyclic, interval = simIK.getJointInterval(env, joint)
assert(cyclic)
simIK.eraseEnvironment(env)

--- simIK.setJointInterval
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
simIK.setJointInterval(env, joint, false, {-math.pi, 2 * math.pi})
simIK.eraseEnvironment(env)

--- simIK.setJointDependency
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
local finger = simIK.createJoint(env, simIK.jointtype_revolute)
simIK.setJointDependency(env, finger, joint, 0, -1)
simIK.eraseEnvironment(env)

--- simIK.getJointDependency
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
local master, offset, factor = simIK.getJointDependency(env, joint)
assert(master == -1)
simIK.eraseEnvironment(env)

--- simIK.createGroup
local env = simIK.createEnvironment()
local group = simIK.createGroup(env, 'arm')
simIK.eraseEnvironment(env)

--- simIK.getGroupHandle
local env = simIK.createEnvironment()
local group = simIK.createGroup(env, 'arm')
assert(simIK.getGroupHandle(env, 'arm') == group)
simIK.eraseEnvironment(env)

--- simIK.doesGroupExist
local env = simIK.createEnvironment()
local group = simIK.createGroup(env, 'arm')
assert(simIK.doesGroupExist(env, group))
simIK.eraseEnvironment(env)

--- simIK.setGroupCalculation
local env = simIK.createEnvironment()
local group = simIK.createGroup(env, 'arm')
simIK.setGroupCalculation(env, group, simIK.method_damped_least_squares, 0.1, 50)
simIK.eraseEnvironment(env)

--- simIK.getGroupCalculation
local env = simIK.createEnvironment()
local group = simIK.createGroup(env, 'arm')
local method, damping, iterations = simIK.getGroupCalculation(env, group)
assert(method == simIK.method_pseudo_inverse and iterations == 3)
simIK.eraseEnvironment(env)

--- simIK.setGroupFlags
local env = simIK.createEnvironment()
local group = simIK.createGroup(env, 'arm')
simIK.setGroupFlags(env, group, simIK.group_enabled | simIK.group_avoidlimits)
simIK.eraseEnvironment(env)

--- simIK.getGroupFlags
local env = simIK.createEnvironment()
local group = simIK.createGroup(env, 'arm')
assert(simIK.getGroupFlags(env, group) & simIK.group_enabled ~= 0)
simIK.eraseEnvironment(env)

--- simIK.getGroupJoints
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
assert(simIK.getGroupJoints(env, group)[1] == joint)
simIK.eraseEnvironment(env)

--- simIK.getGroupJointLimitHits
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
simIK.setJointInterval(env, joint, false, {0, 0.3})
simIK.handleGroup(env, group)
local joints, by = simIK.getGroupJointLimitHits(env, group)
assert(joints[1] == joint and by[1] > 0)
simIK.eraseEnvironment(env)

--- simIK.addElement
local env = simIK.createEnvironment()
local group = simIK.createGroup(env, 'arm')
local tip = simIK.createDummy(env)
local element = simIK.addElement(env, group, tip)
simIK.eraseEnvironment(env)

--- simIK.addElementFromScene
local joint = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_passive, 0)
local tip, target = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(tip, joint, true)
local env = simIK.createEnvironment()
local group = simIK.createGroup(env)
local element, copies = simIK.addElementFromScene(env, group, -1, tip, target, simIK.constraint_z)
assert(simIK.getJointPosition(env, copies[joint]) == 0)
simIK.eraseEnvironment(env)
sim.removeObjects{joint, tip, target}

--- simIK.setTargetDummy
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
simIK.setTargetDummy(env, tip, target)
simIK.eraseEnvironment(env)

--- simIK.getTargetDummy
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
assert(simIK.getTargetDummy(env, tip) == target)
simIK.eraseEnvironment(env)

--- simIK.setElementBase
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
simIK.setElementBase(env, group, element, joint)
assert(#simIK.getGroupJoints(env, group) == 0)
simIK.eraseEnvironment(env)

--- simIK.getElementBase
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
assert(simIK.getElementBase(env, group, element) == simIK.handle_world)
simIK.eraseEnvironment(env)

--- simIK.setElementPrecision
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
simIK.setElementPrecision(env, group, element, {1e-6, 1e-4})
simIK.eraseEnvironment(env)

--- simIK.getElementPrecision
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
assert(simIK.getElementPrecision(env, group, element)[1] == 0.0005)
simIK.eraseEnvironment(env)

--- simIK.setElementWeights
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
simIK.setElementWeights(env, group, element, {1, 0.1})
simIK.eraseEnvironment(env)

--- simIK.getElementWeights
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
assert(simIK.getElementWeights(env, group, element)[2] == 1)
simIK.eraseEnvironment(env)

--- simIK.setElementConstraints
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
simIK.setElementConstraints(env, group, element, simIK.constraint_position)
simIK.eraseEnvironment(env)

--- simIK.getElementConstraints
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
assert(simIK.getElementConstraints(env, group, element) == simIK.constraint_z)
simIK.eraseEnvironment(env)

--- simIK.setElementFlags
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
simIK.setElementFlags(env, group, element, 0)
assert(simIK.handleGroup(env, group) == simIK.result_not_performed)
simIK.eraseEnvironment(env)

--- simIK.getElementFlags
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
assert(simIK.getElementFlags(env, group, element) == 1)
simIK.eraseEnvironment(env)

--- simIK.handleGroup
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
assert(simIK.handleGroup(env, group) == simIK.result_success)
assert(math.abs(simIK.getJointPosition(env, joint) - 0.4) < 1e-3)
simIK.eraseEnvironment(env)

--- simIK.handleGroups
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
local result, flags, precision = simIK.handleGroups(env, {group})
assert(precision[1] < 1e-3)
simIK.eraseEnvironment(env)

--- simIK.syncFromSim
local joint = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_passive, 0)
local tip, target = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(tip, joint, true)
local env = simIK.createEnvironment()
local group = simIK.createGroup(env)
local element, copies = simIK.addElementFromScene(env, group, -1, tip, target, simIK.constraint_z)
sim.setJointPosition(joint, 0.1)
simIK.syncFromSim(env, {group})
assert(simIK.getJointPosition(env, copies[joint]) == 0.1)
simIK.eraseEnvironment(env)
sim.removeObjects{joint, tip, target}

--- simIK.syncToSim
local joint = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_passive, 0)
local tip, target = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(tip, joint, true)
local env = simIK.createEnvironment()
local group = simIK.createGroup(env)
local element, copies = simIK.addElementFromScene(env, group, -1, tip, target, simIK.constraint_z)
simIK.setJointPosition(env, copies[joint], 0.1)
simIK.syncToSim(env, {group})
assert(sim.getJointPosition(joint) == 0.1)
simIK.eraseEnvironment(env)
sim.removeObjects{joint, tip, target}

--- simIK.applyIkEnvironmentToScene
local joint = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_passive, 0)
local tip, target = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(tip, joint, true)
local env = simIK.createEnvironment()
local group = simIK.createGroup(env)
simIK.addElementFromScene(env, group, -1, tip, target, simIK.constraint_z)
sim.setObjectPosition(target, {0, 0, 0.2})
assert(simIK.applyIkEnvironmentToScene(env, group) == simIK.result_success)
simIK.eraseEnvironment(env)
sim.removeObjects{joint, tip, target}

--- simIK.findConfigs
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
local found = simIK.findConfigs(env, group, {joint}, {maxTime = 0.1})
assert(math.abs(found[1][1] - 0.4) < 1e-3)
simIK.eraseEnvironment(env)

--- simIK.findConfig
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
local found = simIK.findConfig(env, group, {joint})
assert(math.abs(found[1] - 0.4) < 1e-3)
simIK.eraseEnvironment(env)

--- simIK.getConfigForTipPose
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
local found = simIK.getConfigForTipPose(env, group, {joint}, 0.1, 0.1)
assert(math.abs(found[1] - 0.4) < 1e-3)
simIK.eraseEnvironment(env)

--- simIK.generatePath
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
local path = simIK.generatePath(env, group, {joint}, tip, 5)
assert(#path == 5 and math.abs(path[3] - 0.2) < 1e-3)
simIK.eraseEnvironment(env)

--- simIK.getAlternateConfigs
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_revolute)
simIK.setJointInterval(env, joint, false, {-2 * math.pi, 4 * math.pi})
simIK.setJointPosition(env, joint, 1)
assert(#simIK.getAlternateConfigs(env, {joint}) == 2)
simIK.eraseEnvironment(env)

--- simIK.computeGroupJacobian
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
local jacobian, errors = simIK.computeGroupJacobian(env, group)
assert(jacobian[1] == 1 and errors[1] == 0.4)
simIK.eraseEnvironment(env)

--- simIK.computeJacobian
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
local jacobian = simIK.computeJacobian(env, -1, joint, simIK.constraint_z, simIK.getObjectPose(env, tip))
assert(jacobian[1] == 1)
simIK.eraseEnvironment(env)

--- simIK.getJacobian
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
simIK.computeJacobian(env, group, 0)
local jacobian, size = simIK.getJacobian(env, group)
assert(size[1] == 1 and size[2] == 1)
simIK.eraseEnvironment(env)

--- simIK.getManipulability
local env = simIK.createEnvironment()
local joint = simIK.createJoint(env, simIK.jointtype_prismatic)
local tip, target = simIK.createDummy(env), simIK.createDummy(env)
simIK.setObjectParent(env, tip, joint)
local group = simIK.createGroup(env)
local element = simIK.addElement(env, group, tip)
simIK.setElementConstraints(env, group, element, simIK.constraint_z)
simIK.setTargetDummy(env, tip, target)
simIK.setObjectPose(env, target, {0, 0, 0.4, 0, 0, 0, 1})
simIK.computeJacobian(env, group, 0)
assert(simIK.getManipulability(env, group) == 1)
simIK.eraseEnvironment(env)

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
