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

return {
    -- Modern scripts define functions of these names, %s being the callback.
    functions = "sysCall_%s",
    rerun = {
        variable = "sim_call_type",
        values = reasons,
        -- Only texts that speak of threads are run as one.
        needs = { thread = { "sim_childscriptcall_threaded" } },
        extra = { sim_current_script_id = "script" },
    },
    -- The name space of commands and constants.
    api = { "sim" },
    -- What tells an old script by its text, and which versions scripts are taken for.
    old_marks = { "sim_call_type" },
    old_dialect = "3.2",
    new_dialect = "4.9",
    -- From which version on scripts of a world are called in which order.
    orders = { { "0", "parents_first" }, { "3.6", "by_kind" }, { "4.4", "deepest_first" } },
}
