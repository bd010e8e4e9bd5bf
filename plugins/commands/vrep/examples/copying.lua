--- sim.copyPasteObjects
local a = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.1, 0.2, 0.3})
sim.setObjectPosition(a, {1, 2, 3})
local b = sim.copyPasteObjects({a}, 0)[1]
assert(b ~= a and sim.getObjectPosition(b)[3] == 3 and sim.getShapeBB(b)[2] == 0.2)
--- sim.copyPasteSelectedObjects
local a = sim.createDummy(0.01)
sim.setObjectSel({a})
sim.copyPasteSelectedObjects()
assert(sim.getObjectSel()[1] ~= a)
--- sim.getObjectSizeFactor
assert(sim.getObjectSizeFactor(sim.createDummy(0.01)) == 1)
--- sim.getObjectSizeValues
assert(sim.getObjectSizeValues(sim.createDummy(0.01))[1] == 1)
--- sim.setObjectSizeValues
local box = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.1, 0.2, 0.3})
sim.setObjectSizeValues(box, {2, 2, 2})
assert(math.abs(sim.getShapeBB(box)[1] - 0.2) < 1e-9)
--- sim.scaleObject
local box = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.1, 0.2, 0.3})
sim.scaleObject(box, 2, 1, 1)
assert(math.abs(sim.getShapeBB(box)[1] - 0.2) < 1e-9)
--- sim.scaleObjects
local box = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.1, 0.2, 0.3})
sim.scaleObjects({box}, 2, false)
assert(math.abs(sim.getShapeBB(box)[3] - 0.6) < 1e-9 and sim.getObjectSizeFactor(box) == 2)
--- sim.loadModel
assert(not pcall(sim.loadModel, 'missing.ttm'))
sim.saveModel(sim.createDummy(0.01), 'model.toml')
assert(sim.getObjectType(sim.loadModel('model.toml')) == sim.object_dummy_type)
--- sim.loadScene
assert(not pcall(sim.loadScene, 'missing.ttt'))
--- sim.saveModel
assert(sim.saveModel(sim.createDummy(0.01), 'saved_model.toml') == 1)
--- sim.saveScene
assert(sim.saveScene('saved_scene.toml') == 1)
