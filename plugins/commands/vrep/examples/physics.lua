--- sim.getJointPosition
local j = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_kinematic, 0)
sim.setJointPosition(j, 0.5)
assert(sim.getJointPosition(j) == 0.5)
--- sim.getJointTargetVelocity
local j = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_dynamic, 0)
sim.setJointTargetVelocity(j, 2)
assert(sim.getJointTargetVelocity(j) == 2)
--- sim.getJointTargetPosition
local j = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_dynamic, 0)
sim.setJointTargetPosition(j, 0.5)
assert(sim.getJointTargetPosition(j) == 0.5)
--- sim.getJointVelocity
assert(sim.getJointVelocity(sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_dynamic, 0)) == 0)
--- sim.getJointForce
assert(sim.getJointForce(sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_dynamic, 0)) == 0)
--- sim.getJointTargetForce
local j = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_dynamic, 0)
sim.setJointTargetForce(j, 2.5)
assert(sim.getJointTargetForce(j) == 2.5)
--- sim.setJointTargetVelocity
function sysCall_init()
    base = sim.createPureShape(0, 16, {0.2, 0.2, 0.2}, 1)
    wheel = sim.createPureShape(2, 0, {0.2, 0.2, 0.05}, 0.1)
    joint = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_dynamic, 0)
    sim.setObjectPosition(base, {70, 0, 1})
    sim.setObjectPosition(joint, {70, 0, 1.2})
    sim.setObjectPosition(wheel, {70, 0, 1.2})
    sim.setObjectParent(joint, base, true)
    sim.setObjectParent(wheel, joint, true)
    sim.setObjectInt32Param(joint, sim.jointintparam_dynctrlmode, sim.jointdynctrl_velocity)
    sim.setJointTargetForce(joint, 10)
    sim.setJointTargetVelocity(joint, 1.5)
end
function sysCall_sensing()
    if sim.getSimulationTime() > 0.3 then
        assert(math.abs(sim.getJointVelocity(joint) - 1.5) < 0.05)
    end
end
--- sim.setJointTargetPosition
local j = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_dynamic, 0)
assert(sim.setJointTargetPosition(j, 0.5) == 1 and sim.getJointTargetPosition(j) == 0.5)
--- sim.setJointForce
local j = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_dynamic, 0)
assert(sim.setJointForce(j, 5) == 1 and sim.getJointTargetForce(j) == 5)
--- sim.setJointTargetForce
local j = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_dynamic, 0)
sim.setJointTargetVelocity(j, 1)
sim.setJointTargetForce(j, -2.5)
assert(sim.getJointTargetForce(j) == 2.5 and sim.getJointTargetVelocity(j) == -1)
--- sim.setJointPosition
local j = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_kinematic, 0)
local d = sim.createDummy(0.01)
sim.setObjectPosition(d, {1, 0, 0})
sim.setObjectParent(d, j, true)
sim.setJointPosition(j, math.pi / 2)
assert(math.abs(sim.getObjectPosition(d)[2] - 1) < 1e-9)
--- sim.getJointInterval
local j = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_kinematic, 0)
local cyclic, interval = sim.getJointInterval(j)
assert(cyclic == false and interval[1] == -0.5 and interval[2] == 1)
--- sim.setJointInterval
local j = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_kinematic, 0)
sim.setJointInterval(j, false, {-1, 2})
sim.setJointPosition(j, 100)
assert(sim.getJointPosition(j) == 1)
--- sim.getJointType
for _, subtype in ipairs{sim.joint_revolute_subtype, sim.joint_prismatic_subtype, sim.joint_spherical_subtype} do
    assert(sim.getJointType(sim.createJoint(subtype, 0, 0)) == subtype)
end
--- sim.getJointMode
local mode, options = sim.getJointMode(sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_dynamic, 0))
assert(mode == sim.jointmode_dynamic and options == 0)
--- sim.setJointMode
local j = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_dynamic, 0)
sim.setJointMode(j, sim.jointmode_kinematic, 0)
assert(sim.getJointMode(j) == sim.jointmode_kinematic)
--- sim.getJointMatrix
local j = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_kinematic, 0)
sim.setJointPosition(j, 0.25)
assert(sim.getJointMatrix(j)[12] == 0.25)
--- sim.createPureShape
local box = sim.createPureShape(0, 8, {0.1, 0.2, 0.3}, 0.5)
assert(sim.getShapeMass(box) == 0.5 and sim.getShapeBB(box)[3] == 0.3)
--- sim.createPrimitiveShape
local ball = sim.createPrimitiveShape(sim.primitiveshape_spheroid, {0.2, 0.2, 0.2})
assert(sim.getObjectType(ball) == sim.object_shape_type and sim.getObjectInt32Param(ball, sim.shapeintparam_static) == 1)
--- sim.createDummy
assert(sim.isHandle(sim.createDummy(0.01)))
--- sim.getShapeMass
assert(sim.getShapeMass(sim.createPureShape(0, 8, {1, 1, 1}, 2)) == 2)
--- sim.setShapeMass
local box = sim.createPureShape(0, 8, {1, 1, 1}, 2)
sim.setShapeMass(box, 0.25)
assert(sim.getShapeMass(box) == 0.25)
--- sim.getShapeBB
local size, pose = sim.getShapeBB(sim.createPureShape(0, 8, {1, 2, 3}, 2))
assert(size[2] == 2 and pose[7] == 1)
--- sim.setShapeBB
local box = sim.createPureShape(0, 8, {1, 2, 3}, 2)
sim.setShapeBB(box, {2, 2, 2})
assert(sim.getShapeBB(box)[1] == 2)
--- sim.getShapeColor
local result, rgb = sim.getShapeColor(sim.createPureShape(0, 8, {1, 1, 1}, 2), nil, sim.colorcomponent_ambient_diffuse)
assert(result == 1 and #rgb == 3)
--- sim.setShapeColor
local box = sim.createPureShape(0, 8, {1, 1, 1}, 2)
sim.setShapeColor(box, nil, sim.colorcomponent_ambient_diffuse, {1, 0, 0})
local _, rgb = sim.getShapeColor(box, nil, sim.colorcomponent_ambient_diffuse)
assert(rgb[1] == 1 and rgb[2] == 0)
sim.setShapeColor(box, nil, sim.colorcomponent_transparency, {0.25})
assert(select(2, sim.getShapeColor(box, nil, sim.colorcomponent_transparency))[1] == 0.25)
--- sim.getObjectColor
local box = sim.createPureShape(0, 8, {1, 1, 1}, 2)
sim.setObjectColor(box, 0, sim.colorcomponent_ambient_diffuse, {0, 1, 0})
assert(sim.getObjectColor(box, 0, sim.colorcomponent_ambient_diffuse)[2] == 1)
--- sim.setObjectColor
local box = sim.createPureShape(0, 8, {1, 1, 1}, 2)
assert(sim.setObjectColor(box, 0, sim.colorcomponent_ambient_diffuse, {0, 1, 0}) == true)
--- sim.changeEntityColor
local box = sim.createPureShape(0, 8, {1, 1, 1}, 2)
local before = sim.changeEntityColor(box, {0, 0, 1})
assert(sim.getObjectColor(box, 0, 0)[3] == 1)
sim.restoreEntityColor(before)
--- sim.restoreEntityColor
local box = sim.createPureShape(0, 8, {1, 1, 1}, 2)
sim.setObjectColor(box, 0, 0, {1, 0, 0})
local before = sim.changeEntityColor(box, {0, 0, 1})
sim.restoreEntityColor(before)
assert(sim.getObjectColor(box, 0, 0)[1] == 1)
--- sim.addForceAndTorque
function sysCall_init()
    box = sim.createPureShape(0, 0, {0.1, 0.1, 0.1}, 1)
    sim.setObjectPosition(box, {80, 0, 50})
end
function sysCall_actuation()
    sim.addForceAndTorque(box, {20, 0, 0}, {0, 0, 0})
end
function sysCall_sensing()
    if sim.getSimulationTime() > 0.09 then
        assert(sim.getVelocity(box)[1] > 0.1)
    end
end
--- sim.addForce
function sysCall_init()
    box = sim.createPureShape(0, 0, {0.1, 0.1, 0.1}, 1)
    sim.setObjectPosition(box, {81, 0, 50})
end
function sysCall_actuation()
    sim.addForce(box, {0, 0, 0}, {20, 0, 0})
end
function sysCall_sensing()
    if sim.getSimulationTime() > 0.09 then
        assert(sim.getVelocity(box)[1] > 0.1)
    end
end
--- sim.getVelocity
function sysCall_init()
    box = sim.createPureShape(0, 0, {0.1, 0.1, 0.1}, 1)
    sim.setObjectPosition(box, {82, 0, 50})
end
function sysCall_sensing()
    if sim.getSimulationTime() > 0.09 then
        assert(sim.getVelocity(box)[3] < -0.5)
    end
end
--- sim.resetDynamicObject
function sysCall_init()
    box = sim.createPureShape(0, 16, {0.1, 0.1, 0.1}, 1)
    sim.setObjectPosition(box, {83, 0, 50})
    sim.setObjectInt32Param(box, sim.shapeintparam_static, 0)
    sim.resetDynamicObject(box)
end
function sysCall_sensing()
    if sim.getSimulationTime() > 0.09 then
        assert(sim.getObjectPosition(box)[3] < 50)
    end
end
--- sim.isDynamicallyEnabled
function sysCall_init()
    box = sim.createPureShape(0, 0, {0.1, 0.1, 0.1}, 1)
    rock = sim.createPureShape(0, 16, {0.1, 0.1, 0.1}, 1)
    sim.setObjectPosition(box, {84, 0, 50})
    sim.setObjectPosition(rock, {85, 0, 50})
end
function sysCall_sensing()
    assert(sim.isDynamicallyEnabled(box) == true and sim.isDynamicallyEnabled(rock) == false)
end
--- sim.getContactInfo
function sysCall_init()
    floor = sim.createPureShape(0, 8 + 16, {1, 1, 0.2}, 1)
    box = sim.createPureShape(0, 8, {0.1, 0.1, 0.1}, 1)
    sim.setObjectPosition(floor, {90, 0, 20})
    sim.setObjectPosition(box, {90, 0, 20.15})
end
function sysCall_sensing()
    if sim.getSimulationTime() > 0.2 then
        local pair, point, force, normal = sim.getContactInfo(sim.handle_all, box, 0)
        assert(#pair == 2 and math.abs(point[3] - 20.1) < 0.01)
    end
end
--- sim.getObjectInt32Param
local box = sim.createPureShape(0, 16, {1, 1, 1}, 2)
assert(sim.getObjectInt32Param(box, sim.shapeintparam_static) == 1)
assert(sim.getObjectInt32Param(box, 99999) == nil)
local script = sim.getScript(sim.handle_self)
assert(sim.getObjectType(script) == sim.sceneobject_script)
assert(sim.getObjectInt32Param(script, sim.scriptintparam_handle) == script)
--- sim.setObjectInt32Param
local box = sim.createPureShape(0, 16, {1, 1, 1}, 2)
sim.setObjectInt32Param(box, sim.shapeintparam_respondable, 1)
assert(sim.getObjectInt32Param(box, sim.shapeintparam_respondable) == 1)
sim.setObjectInt32Param(box, sim.shapeintparam_sleepmodestart, 1)
assert(sim.getObjectInt32Param(box, sim.shapeintparam_sleepmodestart) == 1)
assert(not pcall(sim.setObjectInt32Param, sim.getScript(sim.handle_self), sim.scriptintparam_enabled, 0))
--- sim.getObjectInt32Parameter
local result, v = sim.getObjectInt32Parameter(sim.createPureShape(0, 16, {1, 1, 1}, 2), sim.shapeintparam_static)
assert(result == 1 and v == 1)
--- sim.setObjectInt32Parameter
local box = sim.createPureShape(0, 16, {1, 1, 1}, 2)
assert(sim.setObjectInt32Parameter(box, sim.shapeintparam_respondable, 1) == 1)
assert(sim.getObjectInt32Param(box, sim.shapeintparam_respondable) == 1)
--- sim.getObjectFloatParam
assert(sim.getObjectFloatParam(sim.createPureShape(0, 16, {1, 1, 1}, 2), sim.shapefloatparam_mass) == 2)
--- sim.setObjectFloatParam
local box = sim.createPureShape(0, 16, {1, 1, 1}, 2)
sim.setObjectFloatParam(box, sim.shapefloatparam_mass, 3)
assert(sim.getShapeMass(box) == 3)
--- sim.getObjectFloatParameter
local result, v = sim.getObjectFloatParameter(sim.createPureShape(0, 16, {1, 1, 1}, 2), sim.shapefloatparam_mass)
assert(result == 1 and v == 2)
--- sim.setObjectFloatParameter
local box = sim.createPureShape(0, 16, {1, 1, 1}, 2)
assert(sim.setObjectFloatParameter(box, sim.shapefloatparam_mass, 3) == 1 and sim.getShapeMass(box) == 3)
--- sim.getObjectStringParam
local box = sim.createPureShape(0, 16, {1, 1, 1}, 2)
sim.setObjectStringParam(box, 99, 'x')
assert(sim.getObjectStringParam(box, 99) == 'x')
--- sim.setObjectStringParam
local box = sim.createPureShape(0, 16, {1, 1, 1}, 2)
sim.setObjectStringParam(box, 99, 'y')
assert(sim.getObjectStringParam(box, 99) == 'y')
--- sim.getFloatProperty
assert(sim.getFloatProperty(sim.createPureShape(0, 16, {1, 1, 1}, 2), 'shape.mass') == 2)
--- sim.setFloatProperty
local box = sim.createPureShape(0, 16, {1, 1, 1}, 2)
sim.setFloatProperty(box, 'shape.friction', 0.25)
assert(sim.getFloatProperty(box, 'shape.friction') == 0.25)
--- sim.getProperty
local box = sim.createPureShape(0, 16, {1, 1, 1}, 2)
assert(sim.getProperty(box, 'mass') == 2 and sim.getProperty(box, 'dynamic') == false)
assert(sim.getProperty(box, 'customData.colour', {noError = true}) == nil)
--- sim.setProperty
local box = sim.createPureShape(0, 16, {1, 1, 1}, 2)
sim.setProperty(box, 'customData.colour', 'red')
sim.setProperty(box, 'friction', 0.25)
assert(sim.getProperty(box, 'customData.colour') == 'red' and sim.getProperty(box, 'friction') == 0.25)
--- sim.getIntProperty
assert(sim.getIntProperty(sim.createDummy(0.01), 'object.layer') == 1)
--- sim.setIntProperty
local d = sim.createDummy(0.01)
sim.setIntProperty(d, 'object.layer', 4)
assert(sim.getIntProperty(d, 'object.layer') == 4)
--- sim.getBoolProperty
assert(sim.getBoolProperty(sim.createDummy(0.01), 'object.model_base') == false)
--- sim.setBoolProperty
local d = sim.createDummy(0.01)
sim.setBoolProperty(d, 'object.visible', false)
assert(sim.getBoolProperty(d, 'object.visible') == false)
--- sim.getStringProperty
assert(sim.getStringProperty(sim.createDummy(0.01), 'object.kind') == 'dummy')
--- sim.setStringProperty
local d = sim.createDummy(0.01)
sim.setStringProperty(d, 'object.alias', 'pear')
assert(sim.getObjectAlias(d) == 'pear')
--- sim.getBufferProperty
sim.writeCustomDataBlock(sim.createDummy(0.01), 'a', 'bytes')
assert(sim.getBufferProperty(sim.handle_scene, 'customData.nowhere', {noError = true}) == nil)
--- sim.setBufferProperty
local d = sim.createDummy(0.01)
sim.setBufferProperty(d, 'customData.speed', sim.packTable({vel = 0.1}))
assert(sim.unpackTable(sim.readCustomDataBlock(d, 'speed')).vel == 0.1)
sim.setIntProperty(sim.handle_scene, 'signal.state', 3)
assert(sim.getInt32Signal('state') == 3 and sim.getIntProperty(sim.handle_scene, 'signal.state') == 3)
assert(sim.getFloatProperty(sim.handle_scene, 'timeStep') == sim.getSimulationTimeStep())
--- sim.getLongProperty
assert(sim.getLongProperty(sim.createDummy(0.01), 'object.layer') == 1)
--- sim.setLongProperty
local d = sim.createDummy(0.01)
sim.setLongProperty(d, 'customData.n', 1 << 40)
assert(sim.getLongProperty(d, 'customData.n') == 1 << 40)
--- sim.getIntArrayProperty
assert(#sim.getIntArrayProperty(sim.createDummy(0.01), 'object.pose') == 7)
--- sim.setIntArrayProperty
local d = sim.createDummy(0.01)
sim.setIntArrayProperty(d, 'customData.list', {1, 2, 3})
assert(sim.getIntArrayProperty(d, 'customData.list')[3] == 3)
--- sim.getVector2Property
local d = sim.createDummy(0.01)
sim.setVector2Property(d, 'customData.point', {1, 2})
assert(sim.getVector2Property(d, 'customData.point')[2] == 2)
--- sim.setVector2Property
local d = sim.createDummy(0.01)
sim.setVector2Property(d, 'customData.point', {0.5, -1})
assert(sim.getFloatArrayProperty(d, 'customData.point')[1] == 0.5)
--- sim.getVector3Property
local d = sim.createDummy(0.01)
sim.setObjectPosition(d, {1, 2, 3})
assert(sim.getVector3Property(d, 'object.position')[3] == 3)
--- sim.setVector3Property
local d = sim.createDummy(0.01)
sim.setVector3Property(d, 'object.position', {1, 2, 3})
assert(sim.getObjectPosition(d)[2] == 2)
--- sim.getColorProperty
assert(#sim.getColorProperty(sim.createPureShape(0, 16, {1, 1, 1}, 2), 'shape.color') == 3)
--- sim.setColorProperty
local box = sim.createPureShape(0, 16, {1, 1, 1}, 2)
sim.setColorProperty(box, 'shape.color', {1, 0, 0.5})
assert(sim.getColorProperty(box, 'shape.color')[3] == 0.5)
--- sim.getQuaternionProperty
assert(sim.getQuaternionProperty(sim.createDummy(0.01), 'object.quaternion')[4] == 1)
--- sim.setQuaternionProperty
local d = sim.createDummy(0.01)
sim.setQuaternionProperty(d, 'object.quaternion', {1, 0, 0, 0})
assert(sim.getObjectQuaternion(d)[1] == 1)
--- sim.getPoseProperty
assert(sim.getPoseProperty(sim.createDummy(0.01), 'object.pose')[7] == 1)
--- sim.setPoseProperty
local d = sim.createDummy(0.01)
sim.setPoseProperty(d, 'object.pose', {1, 2, 3, 0, 0, 0, 1})
assert(sim.getObjectPosition(d)[3] == 3)
--- sim.getFloatArrayProperty
assert(#sim.getFloatArrayProperty(sim.createDummy(0.01), 'object.pose') == 7)
--- sim.setFloatArrayProperty
local d = sim.createDummy(0.01)
sim.setFloatArrayProperty(d, 'object.position', {1, 2, 3})
assert(sim.getObjectPosition(d)[3] == 3)
--- sim.readProximitySensor
local result, distance, point, object, normal = sim.readProximitySensor(sim.getObject('/sonar'))
assert(result == 0 and distance == 0 and #point == 3 and object == -1)
--- sim.handleProximitySensor
local result = sim.handleProximitySensor(sim.getObject('/sonar'))
assert(result == 0)
--- sim.checkProximitySensor
local sonar = sim.getObject('/sonar')
sim.readProximitySensor(sonar)
local at = sim.getObjectMatrix(sonar, -1)
local box = sim.createPureShape(0, 16, {0.1, 0.1, 0.1}, 1)
sim.setObjectPosition(box, sim.multiplyVector(at, {0, 0, 0.3}))
local result, distance = sim.checkProximitySensor(sonar, box)
sim.removeObjects({box})
assert(result == 1 and distance > 0.1 and distance < 0.4)
--- sim.checkProximitySensorEx
local sonar = sim.getObject('/sonar')
sim.readProximitySensor(sonar)
local box = sim.createPureShape(0, 16, {0.1, 0.1, 0.1}, 1)
sim.setObjectPosition(box, sim.multiplyVector(sim.getObjectMatrix(sonar, -1), {0, 0, 0.3}))
local near = sim.checkProximitySensorEx(sonar, box, 3, 0.1, 0)
local far = sim.checkProximitySensorEx(sonar, box, 3, 0.5, 0)
sim.removeObjects({box})
assert(near == 0 and far == 1)
--- sim.resetProximitySensor
assert(sim.resetProximitySensor(sim.getObject('/sonar')) == 1)
--- sim.setShapeMaterial
local box = sim.createPureShape(0, 0, {0.1, 0.1, 0.1}, 1)
sim.setShapeMaterial(box, sim.dynmat_nofriction)
assert(sim.getEngineFloatParam(sim.bullet_body_friction, box) == 0)
--- sim.setEngineBoolParam
sim.setEngineBoolParam(2, -1, true)
--- sim.getEngineBoolParam
assert(sim.getEngineBoolParam(2, -1) == false)
--- sim.setEngineInt32Param
sim.setEngineInt32Param(2, -1, 1)
--- sim.getEngineInt32Param
assert(sim.getEngineInt32Param(2, -1) == 0)
--- sim.setEngineFloatParam
local box = sim.createPureShape(0, 0, {0.1, 0.1, 0.1}, 1)
sim.setEngineFloatParam(sim.bullet_body_friction, box, 0.5)
assert(sim.getEngineFloatParam(sim.bullet_body_friction, box) == 0.5)
--- sim.getEngineFloatParam
assert(sim.getEngineFloatParam(sim.bullet_global_stepsize, -1) > 0)
