--- sim.writeCustomDataBlock
local box = sim.createDummy(0.01)
assert(sim.writeCustomDataBlock(box, 'state', 'ab\0c') == 1)
assert(sim.readCustomDataBlock(box, 'state') == 'ab\0c')
sim.writeCustomDataBlock(box, 'state', '')
assert(sim.readCustomDataBlock(box, 'state') == nil)
--- sim.writeCustomStringData
local box = sim.createDummy(0.01)
sim.writeCustomStringData(box, 'name', 'scout')
assert(sim.readCustomStringData(box, 'name') == 'scout')
--- sim.writeCustomBufferData
local box = sim.createDummy(0.01)
sim.writeCustomBufferData(box, 'raw', '\1\2')
assert(sim.readCustomBufferData(box, 'raw') == '\1\2')
--- sim.readCustomDataBlock
local box = sim.createDummy(0.01)
assert(sim.readCustomDataBlock(box, 'none') == nil)
sim.writeCustomDataBlock(box, 'some', 'x')
assert(sim.readCustomDataBlock(box, 'some') == 'x')
--- sim.readCustomStringData
local box = sim.createDummy(0.01)
assert(#sim.readCustomStringData(box, 'none') == 0)
sim.writeCustomDataBlock(box, 'some', 'x')
assert(sim.readCustomStringData(box, 'some') == 'x')
--- sim.readCustomBufferData
local box = sim.createDummy(0.01)
sim.writeCustomBufferData(box, 'raw', sim.packFloatTable({1.5}))
assert(sim.unpackFloatTable(sim.readCustomBufferData(box, 'raw'))[1] == 1.5)
--- sim.writeCustomTableData
local box = sim.createDummy(0.01)
sim.writeCustomTableData(box, 'config', {gain = 0.5, list = {1, 2}})
assert(sim.readCustomTableData(box, 'config').list[2] == 2)
--- sim.readCustomTableData
local box = sim.createDummy(0.01)
assert(next(sim.readCustomTableData(box, 'config')) == nil)
sim.writeCustomTableData(box, 'config', {gain = 0.5})
assert(sim.readCustomTableData(box, 'config').gain == 0.5)
--- sim.readCustomDataBlockTags
local box = sim.createDummy(0.01)
sim.writeCustomDataBlock(box, 'b', '1')
sim.writeCustomDataBlock(box, 'a', '2')
assert(table.concat(sim.readCustomDataBlockTags(box), ' ') == 'a b')
--- sim.readCustomDataTags
local box = sim.createDummy(0.01)
assert(#sim.readCustomDataTags(box) == 0)
sim.writeCustomDataBlock(box, 'a', '2')
assert(sim.readCustomDataTags(box)[1] == 'a')
--- sim.getObjectsWithTag
local box = sim.createDummy(0.01)
sim.writeCustomDataBlock(box, 'fruit', 'pear')
local found = sim.getObjectsWithTag('fruit')
assert(#found == 1 and found[1] == box)
--- sim.addObjectCustomData
local box = sim.createDummy(0.01)
sim.addObjectCustomData(box, 125487, 'pear')
assert(sim.getObjectCustomData(box, 125487) == 'pear')
--- sim.getObjectCustomData
local box = sim.createDummy(0.01)
assert(sim.getObjectCustomData(box, 7) == nil)
sim.addObjectCustomData(box, 7, 'x')
assert(sim.getObjectCustomData(box, 7) == 'x')
--- sim.addSceneCustomData
sim.addSceneCustomData(7, 'x')
assert(sim.getSceneCustomData(7) == 'x')
--- sim.getSceneCustomData
assert(sim.getSceneCustomData(99) == nil)
sim.addSceneCustomData(98, 'y')
assert(sim.getSceneCustomData(98) == 'y')
--- sim.persistentDataWrite
assert(sim.persistentDataWrite('best', '12') == 1)
assert(sim.persistentDataRead('best') == '12')
--- sim.persistentDataRead
assert(sim.persistentDataRead('nothing') == nil)
sim.persistentDataWrite('something', 'x')
assert(sim.persistentDataRead('something') == 'x')
