--- sim.executeScriptString
sim.executeScriptString('counter = 41', sim.getScript(sim.handle_self))
local result, value = sim.executeScriptString('counter + 1', sim.getScript(sim.handle_self))
assert(result == 0 and value == 42)
--- sim.setScriptVariable
sim.setScriptVariable('speed', sim.getScript(sim.handle_self), 0.5)
assert(speed == 0.5)
--- sim.testCB
local calls = 0
local sum = sim.testCB(40, function(a, b)
    calls = calls + 1
    return a + b
end, 2, 9)
assert(sum == 42 and calls == 10)
--- sim.getScriptFunctions
function double(x)
    return 2 * x
end
assert(sim.getScriptFunctions(sim.getScript(sim.handle_self)):double(4) == 8)
--- sim.invertMatrix
local m = sim.buildMatrix({1, 2, 3}, {0, 0, 0})
sim.invertMatrix(m)
assert(m[4] == -1 and m[12] == -3)
--- sim.getScriptAttribute
assert(sim.getScriptAttribute(sim.handle_self, sim.scriptattribute_enabled) == true)
--- sim.setScriptAttribute
sim.setScriptAttribute(sim.handle_self, sim.scriptattribute_executionorder, 2)
assert(sim.getScriptAttribute(sim.handle_self, sim.scriptattribute_executionorder) == 2)
--- sim.removeScript
function sysCall_init()
    me = sim.getScript(sim.handle_self)
    sim.removeScript(me)
end
function sysCall_sensing()
    error('it was removed')
end
--- sim.copyTable
local a = {x = {1, 2}}
local b = sim.copyTable(a)
assert(b.x ~= a.x and b.x[2] == 2)
--- sim.getUserParameter
assert(sim.getUserParameter(sim.createDummy(0.01), 'x') == nil)
--- sim.setUserParameter
local d = sim.createDummy(0.01)
sim.setUserParameter(d, 'speed', 0.5)
assert(sim.getUserParameter(d, 'speed') == 0.5)
