-- Runs once in every new script state. Returns a table that describes how the language must call scripts of this API.
local script = ...
local has = script.has
-- Local copies, because scripts can redefine these globals.
local type, tonumber, math = type, tonumber, math

-- Infers the version for which a script was written from the names it uses. docs/guide/scripts.md lists the same rules.
local function dialect()
    local namespace = script.between("sim.", "sim/") or script.between("sysCall_", "sysCall`")
    -- Modules, and names introduced in 4.2 or later.
    if script.between("require sim", "require sin")
        or has("sysCall_thread", "sysCall_joint", "sysCall_contact", "sysCall_dyn", "sysCall_msg", "sysCall_selChange",
            "sysCall_data", "sysCall_event", "sysCall_ext", "sysCall_afterLoad", "sysCall_realTimeIdle")
        or has("sim.getObject", "sim.setStepping", "sim.step", "sim.yield", "sim.setAutoYieldDelay", "sim.moveToConfig",
            "sim.moveToPose", "sim.getObjectAlias", "sim.setObjectAlias", "sim.getObjectPose", "sim.setObjectPose",
            "sim.handleSimulationScripts", "sim.broadcastMsg", "sim.getVisionSensorImg", "sim.getInt32Signal",
            "sim.setInt32Signal", "sim.getObjectSel", "sim.scripttype_simulation", "sim.getScript",
            "sim.getInt32Param", "sim.getFloatParam", "sim.getBoolParam", "sim.getStringParam", "sim.setBoolParam",
            "sim.setInt32Param", "sim.getObjectInt32Param", "sim.getObjectFloatParam", "sim.setObjectInt32Param",
            "sim.setObjectFloatParam", "sim.getIntProperty", "sim.getFloatProperty", "sim.getStringProperty",
            "sim.setIntProperty", "sim.setFloatProperty", "sim.setStringProperty")
        or has("//", "<<", ">>", "&", "|", "::")
    then
        return "4.9"
    end
    -- Names that 4.2 removed, and flat names in a script that also uses the namespace `sim`.
    if namespace and (has("sim_call_type", "sysCall_threadmain", "sysCall_jointCallback", "sysCall_contactCallback",
            "sysCall_dynCallback", "sysCall_addOnScriptRun", "sysCall_addOnScriptSuspend", "sysCall_addOnScriptResume")
        or has("sim.getObjectHandle", "sim.getObjectAssociatedWithScript", "sim.getScriptAssociatedWithObject",
            "sim.getIntegerSignal", "sim.setIntegerSignal", "sim.switchThread", "sim.setThreadSwitchTiming",
            "sim.setThreadAutomaticSwitch", "sim.getBoolParameter", "sim.setBoolParameter", "sim.getInt32Parameter",
            "sim.setInt32Parameter", "sim.getFloatParameter", "sim.setFloatParameter", "sim.getStringParameter",
            "sim.getObjectFloatParameter", "sim.setObjectFloatParameter", "sim.getObjectInt32Parameter",
            "sim.setObjectInt32Parameter", "sim.getObjectIntParameter", "sim.setObjectIntParameter",
            "sim.setThreadIsFree", "sim.rmlMoveToPosition", "sim.rmlMoveToJointPositions", "sim.rmlPos", "sim.rmlVel")
        or script.between("sim.syscb_", "sim.syscb`") or script.between("simA", "simI")
        or script.between("simJ", "simR") or script.between("simS", "sim["))
    then
        return "4.1"
    end
    -- Only flat names: simGetObjectHandle, sim_handle_self.
    if not namespace and (script.between("simA", "sim[") or script.between("sim_", "sim`")) then
        return "3.2"
    end
    return "4.9"
end

local version = script.dialect or dialect()
local major, minor, patch = version:match("^(%d+)%.?(%d*)%.?(%d*)")
major, minor, patch = tonumber(major) or 4, tonumber(minor) or 0, tonumber(patch) or 0
-- The version as a single number, for comparisons: 3.1.3 is 30103.
local number = major * 10000 + minor * 100 + patch
local era = number < 30500 and "A" or number < 40200 and "B" or "C"

-- Returns how the script is run if its words determine this: 'step', once per step (before 3.1.3), or 'thread', once
-- and as a thread. Otherwise returns nil; the language then runs the whole script for each callback unless the script
-- defines callbacks.
local function style()
    if script.between("sysCall_", "sysCall`") then
        return nil
    end
    local typed = script.between("sim_childscriptcall_", "sim_childscriptcall`") or has("sim_call_type")
    if script.kind ~= "main" and script.kind ~= "customization" then
        local actuates = has("sim_childscriptcall_actuation", "sim_childscriptcall_sensing", "sim.syscb_actuation",
            "sim.syscb_sensing")
        if not actuates and (script.kind == "threaded"
            or has("sim_childscriptcall_threaded", "simSetThreadSwitchTiming", "simSwitchThread",
                "simSetThreadAutomaticSwitch", "simDelegateChildScriptExecution", "simSetThreadIsFree",
                "sim_simulation_advancing_abouttostop", "simWait", "simSetThreadResumeLocation")
            or has("sim.setThreadSwitchTiming", "sim.switchThread", "sim.setThreadAutomaticSwitch",
                "sim.simulation_advancing_abouttostop") and era == "B")
        then
            return "thread"
        end
    end
    if not typed and era == "A" and (number < 30103 and script.dialect and number > 20000 and script.kind ~= "customization"
        or has("simGetScriptExecutionCount", "simHandleChildScript", "sim_simulation_advancing_lastbeforestop"))
    then
        return "step"
    end
end

-- Values of the global `sim_call_type`, by which a script without callbacks determines why it is run. They depend on
-- the era and, up to 3.4, on the kind of script.
local common = {
    B = {
        init = 0, cleanup = 1, nonSimulation = 2, beforeSimulation = 3, afterSimulation = 4, actuation = 5, sensing = 6,
        suspended = 7, suspend = 8, resume = 9, beforeInstanceSwitch = 10, afterInstanceSwitch = 11, beforeCopy = 12,
        afterCopy = 13, run = 14, addonSuspend = 15, addonResume = 16, thread = -1,
    },
    C = {
        init = 2, cleanup = 1, nonSimulation = 3, beforeSimulation = 4, afterSimulation = 5, actuation = 6, sensing = 7,
        suspended = 8, suspend = 9, resume = 10, beforeInstanceSwitch = 11, afterInstanceSwitch = 12, beforeCopy = 13,
        afterCopy = 14, run = 15, addonSuspend = 16, addonResume = 17, thread = -1,
    },
}
local families = {
    main = {init = 0, cleanup = 1, actuation = 2},
    child = {init = 0, cleanup = 1, actuation = 2, sensing = 3, thread = 4},
    customization = {
        init = 0, cleanup = 1, nonSimulation = 2, beforeSimulation = 3, afterSimulation = 4, actuation = 5, sensing = 6,
        suspended = 7, suspend = 8, resume = 9, beforeInstanceSwitch = 10, afterInstanceSwitch = 11, beforeCopy = 12,
        afterCopy = 13,
    },
    addon = {init = 0, run = 1, addonSuspend = 2, addonResume = 3, cleanup = 4},
}
local kind = families[script.kind] and script.kind or "child"
local reasons = {}
for callback, value in pairs(common[era] or families[kind]) do
    reasons[callback] = value
end
if kind == "addon" then
    -- An add-on without callbacks is run only for the callbacks of add-ons, not for those of a simulation.
    for callback in pairs(reasons) do
        reasons[callback] = families.addon[callback] and reasons[callback] or nil
    end
end
if kind == "main" then
    -- Old main scripts have no sections for sensing or threads: a single section (`regular`) runs the whole step, and
    -- itself calls the other scripts twice.
    reasons.sensing, reasons.thread = nil, nil
end

-- By kind of script, the last parts of the names of constants such as `sim_childscriptcall_cleanup`, and the callbacks
-- whose values the constants have.
local names = {
    main = {initialization = "init", cleanup = "cleanup", regular = "actuation"},
    child = {
        initialization = "init", cleanup = "cleanup", actuation = "actuation", sensing = "sensing", threaded = "thread",
    },
    customization = {
        initialization = "init", first = "init", cleanup = "cleanup", last = "cleanup", nonsimulation = "nonSimulation",
        lastbeforesimulation = "beforeSimulation", firstaftersimulation = "afterSimulation",
        simulationactuation = "actuation", simulationsensing = "sensing", simulationpause = "suspended",
        simulationpausefirst = "suspend", simulationpauselast = "resume",
        lastbeforeinstanceswitch = "beforeInstanceSwitch", firstafterinstanceswitch = "afterInstanceSwitch",
        beforecopy = "beforeCopy", aftercopy = "afterCopy",
    },
    addon = {
        initialization = "init", cleanup = "cleanup", run = "run", suspend = "addonSuspend", restarting = "addonResume",
    },
}
local constants = {}
for family, list in pairs(names) do
    local values = common[era] or families[family]
    for name, callback in pairs(list) do
        constants["sim_" .. family .. "scriptcall_" .. name] = values[callback]
        constants["sim." .. family .. "scriptcall_" .. name] = values[callback]
    end
end
for callback, value in pairs(common[era] or families[kind]) do
    constants["sim.syscb_" .. callback:lower()] = value
end
constants["sim.syscb_regular"] = reasons.actuation
constants["sim.syscb_aos_run"] = constants["sim.syscb_run"]
constants["sim.syscb_aos_suspend"] = constants["sim.syscb_addonsuspend"]
constants["sim.syscb_aos_resume"] = constants["sim.syscb_addonresume"]

-- `simInvertMatrix` modifies its argument in place, which a command cannot do.
function simInvertMatrix(matrix)
    local inverse = simGetInvertedMatrix(matrix)
    if not inverse then
        return -1
    end
    for i = 1, 12 do
        matrix[i] = inverse[i]
    end
    return 1
end

-- Scripts of sensors are called after each measurement of the sensor, with the same arguments as in V-REP.
if sim and has("sysCall_vision", "sysCall_trigger") then
    function sysCall_measured(data) sim.handleSensorCallbacks(data.sensor) end
end

-- Scripts from before 3.1.3 that were saved by a later version count their runs themselves, using this command.
if era == "A" and has("simSetScriptAttribute") then
    local other, count = simSetScriptAttribute, nil
    function simSetScriptAttribute(which, attribute, value)
        if which == -4 and type(value) == "number" and attribute == (sim_scriptattribute_executioncount or 2) then
            count = value
            return 1
        end
        return other and other(which, attribute, value) or -1
    end
    local counted = simGetScriptExecutionCount
    function simGetScriptExecutionCount() return count or counted() end
end

-- The language implements time slices of threads; these functions configure them. The commands with the same names
-- serve callers that are not threads.
local delay, held = 2, 0
local function cut()
    -- With a delay of 0, the thread would be switched out at every check.
    return script.slice(held > 0 and 0 or math.max(delay, 1e-3))
end
local function timing(ms)
    delay = math.min(math.max(tonumber(ms) or 2, 0), 200)
    return cut() and 1 or 0
end
local function automatic(on)
    if era == "C" then
        held = math.max(held + (on and -1 or 1), 0)
    else
        held = on and 0 or 1
    end
    return cut() and 1 or 0
end
local function stepping(on)
    local before = held
    held = type(on) == "number" and math.max(on, 0) or math.max(held + (on and 1 or -1), 0)
    cut()
    return before
end
simSetThreadSwitchTiming, simSetThreadAutomaticSwitch = timing, automatic
if sim then
    sim.setThreadSwitchTiming, sim.setThreadAutomaticSwitch, sim.setStepping = timing, automatic, stepping
    function sim.setAutoYieldDelay(seconds) timing((tonumber(seconds) or 0.002) * 1000) end
    function sim.getAutoYieldDelay() return delay / 1000 end
    function sim.acquireLock() stepping(true) end
    function sim.releaseLock() stepping(false) end
end
return {
    -- Names of the functions that modern scripts define, where %s is the callback; `also` lists other names.
    functions = "sysCall_%s",
    -- Add-ons for 3.5 to 4.1 had their own function names, and 4.4 renamed others.
    also = {
        run = "sysCall_addOnScriptRun",
        addonSuspend = "sysCall_addOnScriptSuspend",
        addonResume = "sysCall_addOnScriptResume",
        thread = era == "B" and "sysCall_threadmain" or nil,
        joint = "sysCall_jointCallback",
        contact = "sysCall_contactCallback",
        dyn = "sysCall_dynCallback",
        beforeStep = "sysCall_beforeMainScript",
    },
    -- The host's names of callback arguments, mapped to those of this API.
    arguments = {
        dyn = { step = "passCnt", steps = "totalPasses", after = "afterStep" },
        -- The names of 4.4 and later, and those of `sysCall_jointCallback`.
        joint = {
            step = "passCnt", steps = "totalPasses", dt = { "dt", "dynStepSize" }, pos = { "pos", "currentPos" },
            error = { "error", "errorValue" }, force = { "force", "maxForce" }, maxVel = { "maxVel", "velUpperLimit" },
        },
        contact = { shape1 = "handle1", shape2 = "handle2" },
    },
    -- This API's names of callback results, mapped to those of the host.
    results = {
        beforeStep = { doNotRunMainScript = "skip" },
        contact = { ignoreContact = "ignore", collisionResponse = "respond", bullet = "material" },
    },
    style = style(),
    rerun = {
        variable = "sim_call_type",
        values = reasons,
        -- A script without callbacks runs as a thread only if it contains this word.
        needs = { thread = { "sim_childscriptcall_threaded" } },
        extra = { sim_current_script_id = "script" },
    },
    -- The return value by which an add-on exits: 0 in old versions, sim.syscb_cleanup in later ones.
    ends = script.kind == "addon" and (era == "A" and 0 or 1) or nil,
    constants = constants,
    -- The namespace of commands and constants.
    api = { "sim" },
    -- Modules of V-REP that are not provided.
    lacking = {
        "simUI", "simROS", "simROS2", "simURDF", "simGLTF", "simSDF", "simIGL", "simICP",
        "simMTB", "simBWF", "simCHAI3D", "simConvex", "simAssimp", "simEigen", "simGeom", "simQHull", "simLDraw",
        "simMujoco", "simBubble", "simK3", "simCam", "simJoy", "simWS", "simSkel", "simRuckig",
        "simRemoteApi", "simTest", "simPython", "simSurfRec", "simOpenMesh", "simPovRay", "simRRS1", "simStubs",
        "simDynamics", "simExtIK",
        "simSubprocess: start programs by `sim.launchExecutable` with `--allow exec`",
    },
    dialect = version,
    old_dialect = "3.2",
    new_dialect = "4.9",
    -- The order in which the scripts of a world are called, and the version since which it applies.
    orders = { { "0", "parents_first" }, { "3.6", "by_kind" }, { "4.4", "deepest_first" } },
    -- The command by which a thread waits for the next step.
    switch = "sim.switchThread",
    -- Before 4.5, numbers were passed as 32-bit floats, except to these commands.
    single = number < 40500,
    exact = {
        "sim.packDoubleTable", "sim.unpackDoubleTable", "simPackDoubles", "simUnpackDoubles", "sim.packTable",
        "sim.unpackTable", "simPackTable", "simUnpackTable", "sim.callScriptFunction", "simCallScriptFunction",
        "sim.wait", "simWait", "sim.setDoubleSignal", "sim.getDoubleSignal",
    },
}
