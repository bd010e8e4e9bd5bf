--- sim.getObjectHandle
local d = sim.createDummy(0.01)
sim.setObjectName(d, 'scoutA')
assert(sim.getObjectHandle('scoutA') == d)
assert(sim.getObjectHandle('nobody@silentError') == -1)
--- sim.getObject
local d = sim.createDummy(0.01)
sim.setObjectAlias(d, 'scoutB')
assert(sim.getObject('/scoutB') == d)
assert(sim.getObject('/nobody', {noError = true}) == -1)
--- sim.getObjectHandle_noErrorNoSuffixAdjustment
assert(sim.getObjectHandle_noErrorNoSuffixAdjustment('nobody') == -1)
--- sim.getObjectType
assert(sim.getObjectType(sim.createDummy(0.01)) == sim.object_dummy_type)
--- sim.isHandle
local d = sim.createDummy(0.01)
assert(sim.isHandle(d) == true)
sim.removeObjects({d})
assert(sim.isHandle(d) == false)
--- sim.isHandleValid
local d = sim.createDummy(0.01)
assert(sim.isHandleValid(d) == 1)
sim.removeObjects({d})
assert(sim.isHandleValid(d) == 0)
--- sim.getObjectUid
local a, b = sim.createDummy(0.01), sim.createDummy(0.01)
assert(sim.getObjectUid(a) ~= sim.getObjectUid(b))
--- sim.getObjectName
local d = sim.createDummy(0.01)
sim.setObjectName(d, 'scoutC#3')
assert(sim.getObjectName(d) == 'scoutC#3')
--- sim.setObjectName
local d = sim.createDummy(0.01)
sim.setObjectName(d, 'scoutD')
assert(sim.getObjectHandle('scoutD') == d)
assert(not pcall(sim.setObjectName, d, 'no name!'))
--- sim.getObjectAlias
local d = sim.createDummy(0.01)
sim.setObjectAlias(d, 'scoutE')
assert(sim.getObjectAlias(d) == 'scoutE' and sim.getObjectAlias(d, 1) == '/scoutE')
--- sim.setObjectAlias
local d = sim.createDummy(0.01)
sim.setObjectAlias(d, 'a b!')
assert(sim.getObjectAlias(d) == 'a_b_')
--- sim.getNameSuffix
local n, name = sim.getNameSuffix('motor#2')
assert(n == 2 and name == 'motor')
--- sim.setNameSuffix
local d = sim.createDummy(0.01)
sim.setObjectName(d, 'scoutF#5')
sim.setNameSuffix(5)
assert(sim.getObjectHandle('scoutF') == d)
sim.setNameSuffix(-1)
--- sim.getObjectParent
local a, b = sim.createDummy(0.01), sim.createDummy(0.01)
assert(sim.getObjectParent(b) == -1)
sim.setObjectParent(b, a, true)
assert(sim.getObjectParent(b) == a)
--- sim.setObjectParent
local a, b = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectPosition(a, {1, 0, 0})
sim.setObjectParent(b, a, true)
assert(sim.getObjectPosition(b)[1] == 0)
sim.setObjectParent(b, -1, true)
sim.setObjectParent(b, a, false)
assert(sim.getObjectPosition(b)[1] == 1)
--- sim.getObjectChild
local a, b = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(b, a, true)
assert(sim.getObjectChild(a, 0) == b and sim.getObjectChild(a, 1) == -1)
--- sim.getObjectsInTree
local a, b = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(b, a, true)
local tree = sim.getObjectsInTree(a)
assert(#tree == 2 and tree[1] == a)
assert(sim.getObjectsInTree(a, sim.handle_all, 1)[1] == b)
--- sim.getObjects
local d, i, found = sim.createDummy(0.01), 0, false
while true do
    local h = sim.getObjects(i, sim.object_dummy_type)
    if h == -1 then break end
    found, i = found or h == d, i + 1
end
assert(found)
--- sim.removeObject
local d = sim.createDummy(0.01)
sim.removeObject(d)
assert(not sim.isHandle(d))
--- sim.removeObjects
local a, b = sim.createDummy(0.01), sim.createDummy(0.01)
sim.removeObjects({a, b})
assert(not sim.isHandle(a) and not sim.isHandle(b))
--- sim.removeModel
local a, b = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(b, a, true)
sim.setModelProperty(a, 0)
assert(sim.removeModel(a) == 2 and not sim.isHandle(b))
--- sim.getObjectPosition
local a, b = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectPosition(a, {1, 2, 3})
assert(sim.getObjectPosition(b, a)[3] == -3 and sim.getObjectPosition(a, -1)[1] == 1)
--- sim.getObjectOrientation
local d = sim.createDummy(0.01)
sim.setObjectOrientation(d, {0, 0, 1})
assert(math.abs(sim.getObjectOrientation(d, -1)[3] - 1) < 1e-9)
--- sim.getObjectQuaternion
assert(sim.getObjectQuaternion(sim.createDummy(0.01), -1)[4] == 1)
--- sim.getObjectMatrix
local d = sim.createDummy(0.01)
sim.setObjectPosition(d, {1, 2, 3})
local m = sim.getObjectMatrix(d, -1)
assert(m[1] == 1 and m[4] == 1 and m[12] == 3)
--- sim.getObjectPose
local d = sim.createDummy(0.01)
sim.setObjectPosition(d, {1, 2, 3})
local pose = sim.getObjectPose(d)
assert(pose[2] == 2 and pose[7] == 1)
--- sim.setObjectPosition
local d = sim.createDummy(0.01)
sim.setObjectPosition(d, {0, 0, 0.5}, -1)
sim.setObjectPosition(d, -1, {0, 0, 0.25})
assert(sim.getObjectPosition(d)[3] == 0.25)
--- sim.setObjectOrientation
local d = sim.createDummy(0.01)
sim.setObjectOrientation(d, {0, 0, math.pi / 2}, -1)
assert(math.abs(sim.getObjectMatrix(d)[5] - 1) < 1e-9)
--- sim.setObjectQuaternion
local d = sim.createDummy(0.01)
sim.setObjectQuaternion(d, {0, 0, 1, 0}, -1)
assert(math.abs(sim.getObjectMatrix(d)[1] + 1) < 1e-9)
--- sim.setObjectMatrix
local a, b = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectPosition(a, {1, 2, 3})
sim.setObjectMatrix(b, sim.getObjectMatrix(a, -1), -1)
assert(sim.getObjectPosition(b)[3] == 3)
--- sim.setObjectPose
local d = sim.createDummy(0.01)
sim.setObjectPose(d, {0, 0, 1, 0, 0, 0, 1})
assert(sim.getObjectPosition(d)[3] == 1)
--- sim.getObjectVelocity
function sysCall_init()
    d = sim.createDummy(0.01)
end
function sysCall_actuation()
    sim.setObjectPosition(d, {sim.getSimulationTime(), 0, 0})
end
function sysCall_sensing()
    if sim.getSimulationTime() > 0.11 then
        assert(math.abs(sim.getObjectVelocity(d)[1] - 1) < 1e-6)
    end
end
--- sim.getObjectFromUid
local d = sim.createDummy(0.01)
assert(sim.getObjectFromUid(sim.getObjectUid(d)) == d)
assert(sim.getObjectFromUid(987654321, {noError = true}) == -1)
