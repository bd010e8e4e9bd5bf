-- Runs once in every new script state. Tells the language how scripts of this API are called.
local script = ...

-- `simInvertMatrix` changes the table that it is given, which no command can.
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

-- In old scripts the whole text runs at each call, with a variable telling why. The same numbers as in constants.rs,
-- "Lifecycle".
local reasons = {
    init = 0,
    cleanup = 1,
    actuation = 2,
    sensing = 3,
    thread = 4,
    afterSimulation = 4,
    nonSimulation = 5,
    beforeSimulation = 6,
    suspended = 7,
    suspend = 8,
    resume = 9,
    beforeInstanceSwitch = 10,
    afterInstanceSwitch = 11,
    beforeCopy = 12,
    afterCopy = 13,
}
if script.kind == "main" then
    -- Old main scripts have one part for the whole step, which calls the other scripts twice.
    reasons.sensing, reasons.thread = nil, nil
end
if script.kind == "addon" then
    -- Old add-ons are called at the end of each pass; the numbers changed with 3.5.
    reasons = {init = 0, cleanup = 1, run = 14, addonSuspend = 15, addonResume = 16}
    if script.dialect == "3.2" then
        reasons = {init = 0, run = 1, addonSuspend = 2, addonResume = 3, cleanup = 4}
        sim_addonscriptcall_initialization, sim_addonscriptcall_run, sim_addonscriptcall_suspend = 0, 1, 2
        sim_addonscriptcall_restarting, sim_addonscriptcall_cleanup = 3, 4
    end
end

return {
    -- Modern scripts define functions of these names, %s being the callback.
    functions = "sysCall_%s",
    -- Add-ons of 3.5 to 4.1 had functions of their own.
    also = {
        run = "sysCall_addOnScriptRun",
        addonSuspend = "sysCall_addOnScriptSuspend",
        addonResume = "sysCall_addOnScriptResume",
    },
    rerun = {
        variable = "sim_call_type",
        values = reasons,
        -- Only texts that speak of threads are run as one.
        needs = { thread = { "sim_childscriptcall_threaded" } },
        extra = { sim_current_script_id = "script" },
    },
    -- Old add-ons end by returning 0, later ones by sim.syscb_cleanup.
    ends = script.kind == "addon" and (script.dialect == "3.2" and 0 or 1) or nil,
    -- The name space of commands and constants.
    api = { "sim" },
    -- What tells an old script by its text, and which versions scripts are taken for.
    old_marks = { "sim_call_type" },
    old_dialect = "3.2",
    new_dialect = "4.9",
    -- From which version on scripts of a world are called in which order.
    orders = { { "0", "parents_first" }, { "3.6", "by_kind" }, { "4.4", "deepest_first" } },
}
