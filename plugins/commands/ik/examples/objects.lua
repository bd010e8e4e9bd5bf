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
