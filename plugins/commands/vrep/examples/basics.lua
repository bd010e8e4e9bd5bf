--- sim.getObjectAssociatedWithScript
local me = sim.getObjectAssociatedWithScript(sim.handle_self)
assert(me == sim.getObject('..'))
--- sim.getScriptAssociatedWithObject
local me = sim.getObjectAssociatedWithScript(sim.handle_self)
assert(sim.getScriptAssociatedWithObject(me) == sim.getScript(sim.handle_self))
--- sim.getCustomizationScriptAssociatedWithObject
assert(sim.getCustomizationScriptAssociatedWithObject(sim.createDummy(0.01)) == -1)
--- sim.getScript
local me = sim.getObjectAssociatedWithScript(sim.handle_self)
assert(sim.getScript(sim.scripttype_childscript, me) == sim.getScript(sim.handle_self))
assert(sim.getScript(sim.scripttype_childscript, sim.createDummy(0.01)) == -1)
--- sim.getScriptHandle
local me = sim.getObjectAssociatedWithScript(sim.handle_self)
assert(sim.getScriptHandle(sim.getObjectName(me)) == sim.getScript(sim.handle_self))
--- sim.getScriptName
local me = sim.getObjectAssociatedWithScript(sim.handle_self)
assert(sim.getScriptName(sim.handle_self) == sim.getObjectName(me))
--- sim.callScriptFunction
function sum(a, b)
    return a + b
end
assert(sim.callScriptFunction('sum', sim.getScript(sim.handle_self), 1, 2) == 3)
--- sim.getScriptExecutionCount
function sysCall_init()
    before = sim.getScriptExecutionCount()
end
function sysCall_sensing()
    assert(sim.getScriptExecutionCount() > before)
end
--- sim.isScriptExecutionThreaded
function sysCall_init()
    assert(sim.isScriptExecutionThreaded() == 0)
end
function sysCall_thread()
    assert(sim.isScriptExecutionThreaded() == 1)
end
--- sim.getScriptSimulationParameter
sim.setScriptSimulationParameter(sim.handle_self, 'speed', '0.5')
assert(sim.getScriptSimulationParameter(sim.handle_self, 'speed') == 0.5)
--- sim.setScriptSimulationParameter
sim.setScriptSimulationParameter(sim.handle_self, 'speed', '0.5')
assert(sim.getScriptSimulationParameter(sim.handle_self, 'speed', true) == '0.5')
--- sim.handleChildScripts
-- Only a main script can call the callbacks of other scripts.
assert(sim.handleChildScripts(sim.syscb_actuation) == 0)
--- sim.handleDynamics
-- Only a main script can advance physics.
assert(not pcall(sim.handleDynamics, sim.getSimulationTimeStep()))
--- sim.wait
function sysCall_thread()
    local t = sim.getSimulationTime()
    sim.wait(0.1)
    assert(sim.getSimulationTime() - t > 0.099)
end
--- sim.switchThread
function sysCall_thread()
    local t = sim.getSimulationTime()
    sim.switchThread()
    assert(sim.getSimulationTime() > t)
end
--- sim.step
function sysCall_thread()
    local t = sim.getSimulationTime()
    sim.step()
    assert(sim.getSimulationTime() > t)
end
