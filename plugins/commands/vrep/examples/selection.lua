--- sim.getObjectSelection
sim.setObjectSel({})
assert(sim.getObjectSelection() == nil)
--- sim.getObjectSel
sim.setObjectSel({})
assert(#sim.getObjectSel() == 0)
--- sim.setObjectSel
local a, b = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectSel({a, b})
assert(sim.getObjectSel()[2] == b)
--- sim.addObjectToSelection
local a = sim.createDummy(0.01)
sim.addObjectToSelection(sim.handle_single, a)
assert(sim.isObjectInSelection(a) == 1)
--- sim.removeObjectFromSelection
local a = sim.createDummy(0.01)
sim.addObjectToSelection({a})
sim.removeObjectFromSelection({a})
assert(sim.isObjectInSelection(a) == 0)
--- sim.isObjectInSelection
local a = sim.createDummy(0.01)
assert(sim.isObjectInSelection(a) == 0)
sim.addObjectToSelection({a})
assert(sim.isObjectInSelection(a) == 1)
--- sim.packTable
local data = sim.packTable({a = 1, b = {true, 'x'}})
local back = sim.unpackTable(data)
assert(back.a == 1 and back.b[1] == true and back.b[2] == 'x')
--- sim.unpackTable
assert(sim.unpackTable(sim.packTable({3, 4}))[2] == 4)
assert(not pcall(sim.unpackTable, 'garbage'))
--- sim.createCollection
local c = sim.createCollection(0)
assert(c > 0 and #sim.getCollectionObjects(c) == 0)
--- sim.addItemToCollection
local a, b = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(b, a, true)
local c = sim.createCollection(0)
sim.addItemToCollection(c, sim.handle_tree, a, 0)
assert(#sim.getCollectionObjects(c) == 2)
sim.addItemToCollection(c, sim.handle_single, a, 1)
assert(sim.getCollectionObjects(c)[1] == b)
--- sim.addObjectToCollection
local a = sim.createDummy(0.01)
local c = sim.createCollection('parts', 0)
sim.addObjectToCollection(c, a, sim.handle_single, 0)
assert(sim.getCollectionObjects(c)[1] == a)
--- sim.removeCollection
local c = sim.createCollection('gone', 0)
sim.removeCollection(c)
assert(not pcall(sim.getCollectionObjects, c))
--- sim.destroyCollection
local c = sim.createCollection(0)
sim.destroyCollection(c)
assert(not pcall(sim.getCollectionObjects, c))
--- sim.emptyCollection
local c = sim.createCollection(0)
sim.addItemToCollection(c, sim.handle_single, sim.createDummy(0.01), 0)
sim.emptyCollection(c)
assert(#sim.getCollectionObjects(c) == 0)
--- sim.getCollectionObjects
local a = sim.createDummy(0.01)
local c = sim.createCollection(0)
sim.addItemToCollection(c, sim.handle_single, a, 0)
assert(sim.getCollectionObjects(c)[1] == a)
--- sim.getCollectionHandle
local c = sim.createCollection('found', 0)
assert(sim.getCollectionHandle('found') == c)
--- sim.getCollectionName
local c = sim.createCollection('named', 0)
assert(sim.getCollectionName(c) == 'named')
--- sim.setCollectionName
local c = sim.createCollection('before', 0)
sim.setCollectionName(c, 'after')
assert(sim.getCollectionName(c) == 'after')
