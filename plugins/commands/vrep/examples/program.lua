--- sim.getSimulationTime
assert(sim.getSimulationTime() == 0)
--- sim.getSimulationTimeStep
assert(sim.getSimulationTimeStep() > 0)
--- sim.getSimulationState
function sysCall_actuation()
    assert(sim.getSimulationState() & sim.simulation_advancing ~= 0)
end
--- sim.getSimulationStopping
function sysCall_actuation()
    assert(type(sim.getSimulationStopping()) == 'boolean')
end
--- sim.getRealTimeSimulation
assert(sim.getRealTimeSimulation() == 0)
--- sim.startSimulation
sim.startSimulation()
--- sim.pauseSimulation
assert(type(sim.pauseSimulation) == 'function')
--- sim.stopSimulation
function sysCall_sensing()
    sim.stopSimulation()
    asked = true
end
function sysCall_cleanup()
    assert(asked)
end
--- sim.quitSimulator
function sysCall_sensing()
    sim.quitSimulator()
    asked = true
end
function sysCall_cleanup()
    assert(asked)
end
--- sim.getSystemTime
assert(sim.getSystemTime() >= 0)
--- sim.getSystemTimeInMs
assert(sim.getSystemTimeInMs(sim.getSystemTimeInMs(-1)) >= 0)
--- sim.getBoolParam
assert(type(sim.getBoolParam(sim.boolparam_headless)) == 'boolean')
--- sim.setBoolParam
sim.setBoolParam(sim.boolparam_console_visible, true)
assert(sim.getBoolParam(sim.boolparam_console_visible) == true)
--- sim.getInt32Param
assert(sim.getInt32Param(sim.intparam_program_version) >= 30000)
--- sim.setInt32Param
sim.setInt32Param(sim.intparam_current_page, 3)
assert(sim.getInt32Param(sim.intparam_current_page) == 3)
--- sim.getFloatParam
assert(sim.getFloatParam(sim.floatparam_simulation_time_step) == sim.getSimulationTimeStep())
--- sim.setFloatParam
sim.setFloatParam(sim.floatparam_stereo_distance, 0.5)
assert(sim.getFloatParam(sim.floatparam_stereo_distance) == 0.5)
--- sim.getStringParam
assert(type(sim.getStringParam(sim.stringparam_scene_path)) == 'string')
--- sim.setStringParam
sim.setStringParam(sim.stringparam_app_arg1, 'x')
assert(sim.getStringParam(sim.stringparam_app_arg1) == 'x')
--- sim.getArrayParam
assert(#sim.getArrayParam(sim.arrayparam_gravity) == 3)
--- sim.setArrayParam
local g = sim.getArrayParam(sim.arrayparam_gravity)
sim.setArrayParam(sim.arrayparam_gravity, {0, 0, -1.62})
assert(sim.getArrayParam(sim.arrayparam_gravity)[3] == -1.62)
sim.setArrayParam(sim.arrayparam_gravity, g)
--- sim.getRandom
local a, b = sim.getRandom(), sim.getRandom()
assert(a >= 0 and a < 1 and a ~= b)
--- sim.setInt32Signal
assert(sim.setInt32Signal('exampleA', 3.7) == 1 and sim.getInt32Signal('exampleA') == 3)
--- sim.getInt32Signal
assert(sim.getInt32Signal('nothing') == nil)
sim.setInt32Signal('exampleB', 4)
assert(sim.getInt32Signal('exampleB') == 4)
--- sim.clearInt32Signal
sim.setInt32Signal('exampleC', 4)
assert(sim.clearInt32Signal('exampleC') == 1 and sim.getInt32Signal('exampleC') == nil)
--- sim.setFloatSignal
sim.setFloatSignal('exampleD', 0.5)
assert(sim.getFloatSignal('exampleD') == 0.5)
--- sim.getFloatSignal
assert(sim.getFloatSignal('nothing') == nil)
sim.setFloatSignal('exampleE', 1.25)
assert(sim.getFloatSignal('exampleE') == 1.25)
--- sim.clearFloatSignal
sim.setFloatSignal('exampleF', 4)
assert(sim.clearFloatSignal('exampleF') == 1 and sim.getFloatSignal('exampleF') == nil)
--- sim.setStringSignal
sim.setStringSignal('exampleG', 'a\0b')
assert(sim.getStringSignal('exampleG') == 'a\0b')
--- sim.getStringSignal
assert(sim.getStringSignal('nothing') == nil)
sim.setStringSignal('exampleH', 'x')
assert(sim.getStringSignal('exampleH') == 'x')
--- sim.clearStringSignal
sim.setStringSignal('exampleI', 'x')
assert(sim.clearStringSignal('exampleI') == 1 and sim.getStringSignal('exampleI') == nil)
--- sim.getSignalName
sim.setInt32Signal('exampleJ', 1)
local i, found = 0, false
while sim.getSignalName(i, 0) do
    found, i = found or sim.getSignalName(i, 0) == 'exampleJ', i + 1
end
assert(found)
--- sim.waitForSignal
function sysCall_init()
    sim.setStringSignal('exampleK', 'go')
end
function sysCall_thread()
    assert(sim.waitForSignal('exampleK') == 'go')
end
--- sim.tubeOpen
local a, b = sim.tubeOpen(0, 'tubeA', 1), sim.tubeOpen(0, 'tubeA', 1)
assert(a ~= b and sim.tubeOpen(0, 'tubeA', 1) == -1)
--- sim.tubeWrite
local a, b = sim.tubeOpen(0, 'tubeB', 1), sim.tubeOpen(0, 'tubeB', 1)
assert(sim.tubeWrite(a, 'x') == 1 and sim.tubeRead(b) == 'x')
--- sim.tubeRead
local a, b = sim.tubeOpen(0, 'tubeC', 2), sim.tubeOpen(0, 'tubeC', 2)
assert(sim.tubeRead(b) == nil)
sim.tubeWrite(a, '1')
sim.tubeWrite(a, '2')
assert(sim.tubeRead(b) == '1' and sim.tubeRead(b) == '2' and sim.tubeRead(b) == nil)
--- sim.tubeStatus
local a = sim.tubeOpen(0, 'tubeD', 1)
assert(sim.tubeStatus(a) == 0)
local b = sim.tubeOpen(0, 'tubeD', 1)
assert(sim.tubeStatus(a) == 1)
--- sim.tubeClose
local a, b = sim.tubeOpen(0, 'tubeE', 1), sim.tubeOpen(0, 'tubeE', 1)
assert(sim.tubeClose(a) == 1 and sim.tubeStatus(b) == 0)
--- sim.addStatusbarMessage
assert(sim.addStatusbarMessage('ready') == 1)
--- sim.addLog
sim.addLog(sim.verbosity_scriptinfos, 'ready')
assert(not pcall(sim.addLog, sim.verbosity_scripterrors, 'this one raises'))
--- sim.auxiliaryConsoleOpen
assert(sim.auxiliaryConsoleOpen('Sensors', 1000, 0) > 0)
--- sim.auxiliaryConsolePrint
local console = sim.auxiliaryConsoleOpen('Print', 1000, 0)
assert(sim.auxiliaryConsolePrint(console, 'distance 1\n') == 1)
--- sim.auxiliaryConsoleShow
local console = sim.auxiliaryConsoleOpen('Show', 1000, 0)
assert(sim.auxiliaryConsoleShow(console, true) == 1)
--- sim.auxiliaryConsoleClose
local console = sim.auxiliaryConsoleOpen('Close', 1000, 0)
assert(sim.auxiliaryConsoleClose(console) == 1 and sim.auxiliaryConsolePrint(console, 'x') == 0)
--- sim.getSimulatorMessage
function sysCall_actuation()
    repeat
        local message = sim.getSimulatorMessage()
    until message == -1
    assert(sim.getSimulatorMessage() == -1)
end
--- vrep.sendMessage
function sysCall_actuation()
    vrep.sendMessage(sim.message_keypress, {2007})
    local message, aux = sim.getSimulatorMessage()
    if message ~= -1 then
        assert(message == sim.message_keypress and aux[1] == 2007)
    end
end
--- sim.getModuleName
assert(sim.getModuleName(0) == nil)
--- sim.handleSimulationStart
assert(sim.handleSimulationStart() == 0)
--- sim.handleSensingStart
assert(sim.handleSensingStart() == 0)
--- sim.openModule
assert(sim.openModule(sim.handle_all) == 0)
--- sim.handleModule
assert(sim.handleModule(sim.handle_all, false) == 0)
--- sim.closeModule
assert(sim.closeModule(sim.handle_all) == 0)
--- sim.resumeThreads
assert(sim.resumeThreads(0) == 0)
--- sim.launchThreadedChildScripts
assert(sim.launchThreadedChildScripts() == 0)
--- sim.handleCustomizationScripts
assert(sim.handleCustomizationScripts(sim.syscb_actuation) == 0)
--- sim.handleAddOnScripts
assert(sim.handleAddOnScripts(sim.syscb_actuation) == 0)
--- sim.handleVarious
assert(sim.handleVarious() == 0)
