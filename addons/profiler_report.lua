-- Logs, at the end of a run, the cost of each script and each kind of sensor: calls, instructions, readings, beams.
-- Options: top=20    number of scripts to log, the most expensive first
--          file=     also write the report to this CSV file
--
--     tatu run scene.toml --addon profiler_report
--
-- The report contains counts instead of times, so it is the same for each run of a scene. Instructions are those of the
-- script's language. The add-on itself is excluded.

function sysCall_info()
    return {autoStart = false, menu = 'Reports\nUse'}
end

local options, sensors, scripts, steps

function sysCall_init()
    options = tatu.options{top = 20, file = ''}
end

function sysCall_beforeSimulation()
    sensors, scripts, steps = {}, {}, 0
end

-- Collects the counts while the simulation is running, because sensors are created again when it stops, and scripts may
-- be removed earlier.
local function look()
    sensors = {}
    local of_kind = {}
    for _, sensor in ipairs(tatu.list('sensor')) do
        local kind = tatu.get(sensor, 'sensor.kind')
        local s = of_kind[kind]
        if not s then
            s = {kind = kind, count = 0, measured = 0, beams = 0}
            of_kind[kind], sensors[#sensors + 1] = s, s
        end
        local measured = tatu.get(sensor, 'sensor.measured')
        s.count, s.measured = s.count + 1, s.measured + measured
        s.beams = s.beams + measured * tatu.get(sensor, 'sensor.beams')
    end
    local own = sim.getScript(sim.handle_self)
    for _, script in ipairs(tatu.list('script')) do
        if script ~= own then
            -- Use only the file name, because paths differ between machines.
            local name = tatu.get(script, 'script.name'):match('[^/\\]*$')
            local owner = tatu.get(script, 'object.parent')
            local path = owner ~= 0 and tatu.get(owner, 'object.path') or tatu.get(script, 'script.kind')
            scripts[script] = {
                name = path .. ' (' .. name .. ')', calls = tatu.get(script, 'script.calls'),
                instructions = tatu.get(script, 'script.instructions'),
            }
        end
    end
end

function sysCall_sensing()
    steps = steps + 1
    -- Counts are collected in every tenth step, and in the passes before the end.
    if steps % 10 == 1 or sim.getSimulationStopping() then
        look()
    end
end

local function say(text)
    sim.addLog(sim.verbosity_scriptinfos, 'profiler_report: ' .. text)
end

function sysCall_afterSimulation()
    local list, total = {}, 0
    for script, s in pairs(scripts) do
        s.number = script
        list[#list + 1], total = s, total + s.instructions
    end
    table.sort(list, function(a, b)
        if a.instructions ~= b.instructions then
            return a.instructions > b.instructions
        end
        return a.number < b.number
    end)
    say(string.format('%d steps, %d scripts, %d instructions', steps, #list, total))
    for i = 1, math.min(#list, options.top) do
        local s = list[i]
        local share = total > 0 and 100 * s.instructions / total or 0
        say(string.format('%5.1f %%  %d instructions in %d calls  %s', share, s.instructions, s.calls, s.name))
    end
    for _, s in ipairs(sensors) do
        say(string.format('%d sensor(s) of kind %s: %d readings, %d beams', s.count, s.kind, s.measured, s.beams))
    end
    if options.file ~= '' then
        local file, why = io.open(options.file, 'w')
        if not file then
            error('profiler_report: cannot write ' .. options.file .. ': ' .. tostring(why))
        end
        file:write('what,name,calls_or_readings,instructions_or_beams\n')
        for _, s in ipairs(list) do
            file:write(string.format('script,"%s",%d,%d\n', s.name, s.calls, s.instructions))
        end
        for _, s in ipairs(sensors) do
            file:write(string.format('sensor,"%s",%d,%d\n', s.kind, s.measured, s.beams))
        end
        file:close()
    end
end
