--- tatu.kin.joints
local arm = tatu.addModel('ur5')
local joints = tatu.kin.joints(arm)
assert(#joints == 6)
tatu.remove(sim.getObjectsInTree(arm))

--- tatu.kin.jacobian
local arm = tatu.addModel('ur5')
local tip = sim.getObject('/tool0')
local J = tatu.kin.jacobian(arm, tip)
assert(#J == 6 and #J[1] == 6)
tatu.remove(sim.getObjectsInTree(arm))

--- tatu.kin.massMatrix
local arm = tatu.addModel('ur5')
local M = tatu.kin.massMatrix(arm)
assert(M[1][1] > 0 and math.abs(M[1][2] - M[2][1]) < 1e-9)
tatu.remove(sim.getObjectsInTree(arm))

--- tatu.kin.gravityTorques
local arm = tatu.addModel('ur5')
local forces = tatu.kin.gravityTorques(arm)
assert(math.abs(forces[1]) < 1e-9 and math.abs(forces[2]) > 10)
tatu.remove(sim.getObjectsInTree(arm))

--- tatu.kin.inverseDynamics
local arm = tatu.addModel('ur5')
local q, qd = tatu.getState(arm)
local forces = tatu.kin.inverseDynamics(arm, q, qd, {1, 0, 0, 0, 0, 0})
assert(forces[1] > 0)
tatu.remove(sim.getObjectsInTree(arm))

--- tatu.kin.forwardDynamics
local arm = tatu.addModel('ur5')
local qdd = tatu.kin.forwardDynamics(arm, tatu.kin.gravityTorques(arm))
for i = 1, 6 do assert(math.abs(qdd[i]) < 1e-6) end
tatu.remove(sim.getObjectsInTree(arm))

--- tatu.kin.energy
local arm = tatu.addModel('ur5')
local kinetic, potential = tatu.kin.energy(arm)
assert(kinetic == 0 and potential > 0)
tatu.remove(sim.getObjectsInTree(arm))

--- tatu.kin.ik
local arm = tatu.addModel('ur5')
local tip = sim.getObject('/tool0')
local q, joints, why = tatu.kin.ik(tip, {0.4, 0.2, 0.4, 1, 0, 0, 0})
for i, joint in ipairs(joints) do sim.setJointPosition(joint, q[i]) end
q, joints, why = tatu.kin.ik(tip, {2, 0, 0.4})
assert(q == nil and why.kind == 'out of reach')
print(why.text)
tatu.remove(sim.getObjectsInTree(arm))

--- tatu.kin.reach
local arm = tatu.addModel('ur5')
local reachable, text = tatu.kin.reach(sim.getObject('/tool0'), {0.4, 0.2, 0.4})
assert(reachable)
tatu.remove(sim.getObjectsInTree(arm))

--- tatu.getState
local arm = tatu.addModel('ur5')
local q, qd = tatu.getState(arm)
assert(#q == 6 and qd[1] == 0)
tatu.remove(sim.getObjectsInTree(arm))

--- tatu.setState
local arm = tatu.addModel('ur5')
tatu.setState(arm, {0.3, -1.2, 1.5, -0.8, 0.9, -0.4})
assert(math.abs(tatu.getState(arm)[3] - 1.5) < 1e-9)
tatu.remove(sim.getObjectsInTree(arm))

--- tatu.linearize
local arm = tatu.addModel('ur5')
local joints = tatu.kin.joints(arm)
local A, B, C, D = tatu.linearize(arm, joints, {sim.getObject('/tool0')}, {forces = tatu.kin.gravityTorques(arm)})
assert(#A == 12 and #B[1] == 6 and #C == 3)
tatu.remove(sim.getObjectsInTree(arm))
