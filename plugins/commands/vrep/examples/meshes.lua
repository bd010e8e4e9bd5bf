--- sim.createMeshShape
local h = sim.createMeshShape(0, 0, {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3})
assert(sim.getShapeBB(h)[1] == 1 and sim.getObjectPosition(h)[1] == 0.5)
--- sim.createShape
local h = sim.createShape(0, 0, {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3})
assert(#sim.getShapeMesh(h) == 12)
--- sim.createHeightfieldShape
local h = sim.createHeightfieldShape(0, 0, 2, 2, 1, {0, 0, 0, 0.5})
assert(math.abs(sim.getShapeBB(h)[3] - 0.5) < 1e-9)
--- sim.getShapeMesh
local box = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {2, 2, 2})
local points, places, normals = sim.getShapeMesh(box)
assert(#points == 24 and #places == 36 and #normals == 108)
for _, x in ipairs(points) do assert(math.abs(x) == 1) end
--- sim.getShapeGeomInfo
local box = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {1, 2, 3})
local result, pure, size = sim.getShapeGeomInfo(box)
assert(result == 6 and pure == sim.primitiveshape_cuboid and size[3] == 3)
--- sim.groupShapes
local a = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {1, 1, 1})
local b = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {1, 1, 1})
sim.setObjectPosition(b, {2, 0, 0})
local group = sim.groupShapes({a, b})
assert(math.abs(sim.getShapeBB(group)[1] - 3) < 1e-9 and not sim.isHandle(b))
--- sim.getShapeMassAndInertia
local box = sim.createPureShape(0, 8, {1, 1, 1}, 2)
sim.setObjectPosition(box, {0, 0, 5})
local mass, inertia, com = sim.getShapeMassAndInertia(box)
-- Inertia of a cube: m (x^2 + y^2) / 12, divided by m.
assert(mass == 2 and math.abs(inertia[1] - 1 / 6) < 1e-9 and com[3] == 5)
--- sim.setShapeMassAndInertia
local box = sim.createPureShape(0, 8, {1, 1, 1}, 2)
sim.setShapeMassAndInertia(box, 3, {0.1, 0, 0, 0, 0.2, 0, 0, 0, 0.3}, {0, 0, 0})
local mass, inertia = sim.getShapeMassAndInertia(box)
assert(mass == 3 and math.abs(inertia[9] - 0.3) < 1e-9)
--- sim.getShapeInertia
local box = sim.createPureShape(0, 8, {1, 1, 1}, 6)
local inertia = sim.getShapeInertia(box)
assert(math.abs(inertia[5] - 1) < 1e-9)
--- sim.setShapeInertia
local box = sim.createPureShape(0, 8, {1, 1, 1}, 6)
sim.setShapeInertia(box, {2, 0, 0, 0, 2, 0, 0, 0, 2}, sim.buildIdentityMatrix())
assert(math.abs(sim.getShapeInertia(box)[1] - 2) < 1e-9)
--- sim.computeMassAndInertia
local box = sim.createPureShape(0, 8, {1, 1, 1}, 6)
sim.computeMassAndInertia(box, 10)
assert(math.abs(sim.getShapeMass(box) - 10) < 1e-9)
--- sim.ungroupShape
local box = sim.createPureShape(0, 8, {1, 1, 1}, 6)
assert(sim.ungroupShape(box)[1] == box)
