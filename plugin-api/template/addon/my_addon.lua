-- my_addon: logs the distance that each robot has travelled, when the simulation ends.
-- Options: every=0   interval between two log lines during the run, s; 0: none
--
--     tatu run scene.toml --addon my_addon.lua
--     tatu run scene.toml --addon my_addon.lua:every=2

function sysCall_info()
    return {autoStart = false} -- the add-on starts only if it is given by --addon
end

local options, robots, due

local function tell()
    for _, robot in ipairs(robots) do
        local text = string.format('%s: %.2f m after %.2f s', robot.path, robot.metres, sim.getSimulationTime())
        sim.addLog(sim.verbosity_scriptinfos, text)
    end
end

function sysCall_init()
    options = tatu.options{every = 0}
end

function sysCall_beforeSimulation()
    robots, due = {}, options.every
    for _, object in ipairs(sim.getObjectsInTree(sim.handle_scene)) do
        if tatu.get(object, 'object.model_base') then
            robots[#robots + 1] = {object = object, path = tatu.get(object, 'object.path'), metres = 0}
        end
    end
end

function sysCall_sensing()
    for _, robot in ipairs(robots) do
        local at = sim.getObjectPosition(robot.object)
        if robot.at then
            robot.metres = robot.metres + math.sqrt((at[1] - robot.at[1]) ^ 2 + (at[2] - robot.at[2]) ^ 2)
        end
        robot.at = at
    end
    if options.every > 0 and sim.getSimulationTime() >= due then
        due = due + options.every
        tell()
    end
end

function sysCall_afterSimulation()
    tell()
end
