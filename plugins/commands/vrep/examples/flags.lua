--- sim.getObjectProperty
local d = sim.createDummy(0.01)
assert(sim.getObjectProperty(d) & sim.objectproperty_selectable ~= 0)
--- sim.setObjectProperty
local d = sim.createDummy(0.01)
sim.setObjectProperty(d, sim.objectproperty_collapsed)
assert(sim.getObjectProperty(d) == sim.objectproperty_collapsed)
--- sim.getModelProperty
assert(sim.getModelProperty(sim.createDummy(0.01)) == sim.modelproperty_not_model)
--- sim.setModelProperty
local d = sim.createDummy(0.01)
sim.setModelProperty(d, 0)
assert(sim.getModelProperty(d) == 0)
sim.setModelProperty(d, sim.modelproperty_not_model)
assert(sim.getModelProperty(d) == sim.modelproperty_not_model)
--- sim.getObjectSpecialProperty
local box = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.1, 0.1, 0.1})
assert(sim.getObjectSpecialProperty(box) & sim.objectspecialproperty_detectable ~= 0)
--- sim.setObjectSpecialProperty
local box = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.1, 0.1, 0.1})
sim.setObjectSpecialProperty(box, sim.objectspecialproperty_collidable)
assert(sim.getObjectSpecialProperty(box) == sim.objectspecialproperty_collidable)
--- sim.getExplicitHandling
local sonar = sim.getObject('/sonar')
sim.setExplicitHandling(sonar, 0)
sim.readProximitySensor(sonar)
assert(sim.getExplicitHandling(sonar) == 0)
--- sim.setExplicitHandling
local sonar = sim.getObject('/sonar')
sim.readProximitySensor(sonar)
sim.setExplicitHandling(sonar, 1)
assert(sim.getExplicitHandling(sonar) == 1)
sim.setExplicitHandling(sonar, 0)
--- sim.setReferencedHandles
local a, b = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setReferencedHandles(a, {b}, 'friend')
assert(sim.getReferencedHandles(a, 'friend')[1] == b)
--- sim.getReferencedHandles
local a, b = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setReferencedHandles(a, {b})
sim.removeObjects({b})
assert(sim.getReferencedHandles(a)[1] == -1)
--- sim.getReferencedHandle
local a, b = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setReferencedHandles(a, {b}, 'friend')
assert(sim.getReferencedHandle(a, 'friend') == b)
--- sim.getReferencedHandlesTags
local a, b = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setReferencedHandles(a, {b}, 'friend')
assert(sim.getReferencedHandlesTags(a)[1] == 'friend')
--- sim.getLinkDummy
assert(sim.getLinkDummy(sim.createDummy(0.01)) == -1)
--- sim.setLinkDummy
local a, b = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setLinkDummy(a, b)
assert(sim.getLinkDummy(b) == a)
sim.setLinkDummy(a, -1)
assert(sim.getLinkDummy(b) == -1)
--- sim.getObjectHierarchyOrder
local a, b, c = sim.createDummy(0.01), sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(b, a, true)
sim.setObjectParent(c, a, true)
local order, count = sim.getObjectHierarchyOrder(c)
assert(order == 1 and count == 2)
