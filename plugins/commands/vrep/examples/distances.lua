--- sim.checkCollision
local a = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.2, 0.2, 0.2})
local b = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.2, 0.2, 0.2})
sim.setObjectPosition(a, {50, 0, 0})
sim.setObjectPosition(b, {50.1, 0, 0})
local r, pair = sim.checkCollision(a, b)
assert(r == 1 and pair[2] == b)
sim.setObjectPosition(b, {51, 0, 0})
assert(sim.checkCollision(a, b) == 0)
--- sim.checkDistance
local a = sim.createPrimitiveShape(sim.primitiveshape_spheroid, {0.2, 0.2, 0.2})
local b = sim.createPrimitiveShape(sim.primitiveshape_spheroid, {0.2, 0.2, 0.2})
sim.setObjectPosition(b, {1, 0, 0})
local r, data = sim.checkDistance(a, b, 0)
assert(r == 1 and math.abs(data[7] - 0.8) < 1e-6)
assert(sim.checkDistance(a, b, 0.5) == 0)
-- A chain: a joint holds b on a, and another c on b. Among each other only a and c count.
local c = sim.createPrimitiveShape(sim.primitiveshape_spheroid, {0.2, 0.2, 0.2})
sim.setObjectPosition(c, {1, 2, 0})
for _, link in ipairs({{a, b}, {b, c}}) do
    local joint = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_kinematic, 0)
    sim.setObjectParent(joint, link[1], true)
    sim.setObjectParent(link[2], joint, true)
end
local chain = sim.createCollection(0)
sim.addItemToCollection(chain, sim.handle_tree, a, 0)
local r, data, pair = sim.checkDistance(chain, chain, 0)
assert(r == 1 and math.abs(data[7] - (math.sqrt(5) - 0.2)) < 1e-6)
assert(pair[1] == a and pair[2] == c)
--- sim.getCollisionHandle
assert(not pcall(sim.getCollisionHandle, 'nothing'))
--- sim.getDistanceHandle
assert(not pcall(sim.getDistanceHandle, 'nothing'))
--- sim.getIkGroupHandle
assert(not pcall(sim.getIkGroupHandle, 'nothing'))
--- sim.getMechanismHandle
assert(not pcall(sim.getMechanismHandle, 'nothing'))
--- sim.readCollision
assert(not pcall(sim.readCollision, 5))
--- sim.readDistance
assert(not pcall(sim.readDistance, 5))
--- sim.handleCollision
assert(sim.handleCollision(sim.handle_all) == 0)
--- sim.handleDistance
assert(sim.handleDistance(sim.handle_all) == 0)
--- sim.resetCollision
sim.resetCollision(sim.handle_all)
--- sim.resetDistance
sim.resetDistance(sim.handle_all)
