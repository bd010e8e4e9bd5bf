-- Writes the poses of objects to a CSV file while a simulation runs.
-- Options: objects=/A,/B   the objects; default: all model bases, such as robots
--          file=poses.csv  the file, in the folder for files of scripts (`--files`, by default the working folder)
--          period=0        interval between two lines, s; 0: one line per step
--          angles=false    true: Euler angles alpha, beta, gamma in degrees instead of the quaternion
--
--     tatu run scene.toml --addon pose_logger:objects=/Pioneer_p3dx,period=0.1

function sysCall_info()
    return {autoStart = false, menu = 'Logs\nPoses'}
end

local options, objects, file, due

function sysCall_init()
    options = tatu.options{objects = '', file = 'poses.csv', period = 0, angles = false}
end

-- Returns the selected objects in the given order, or all model bases in the order of the tree.
local function chosen()
    local list = {}
    for path in options.objects:gmatch('[^,]+') do
        list[#list + 1] = sim.getObject(path)
    end
    if options.objects == '' then
        for _, object in ipairs(tatu.list()) do
            if tatu.get(object, 'object.model_base') then
                list[#list + 1] = object
            end
        end
    end
    return list
end

function sysCall_beforeSimulation()
    objects, due = chosen(), 0
    if #objects == 0 then
        error('pose_logger: the scene has no model; select the objects to log with the option objects=/A,/B')
    end
    local why
    file, why = io.open(options.file, 'w')
    if not file then
        error('pose_logger: cannot write ' .. options.file .. ': ' .. tostring(why))
    end
    local columns = {'time_s'}
    local parts = options.angles and {'x_m', 'y_m', 'z_m', 'alpha_deg', 'beta_deg', 'gamma_deg'}
        or {'x_m', 'y_m', 'z_m', 'qx', 'qy', 'qz', 'qw'}
    for _, object in ipairs(objects) do
        local path = tatu.get(object, 'object.path'):gsub('"', '""')
        for _, part in ipairs(parts) do
            columns[#columns + 1] = '"' .. path .. ' ' .. part .. '"'
        end
    end
    file:write(table.concat(columns, ','), '\n')
end

local function line(time)
    local cells = {string.format('%.6f', time)}
    for _, object in ipairs(objects) do
        -- The cells of a removed object are empty.
        local there, pose = pcall(tatu.get, object, 'object.world_pose')
        local numbers = there and pose or {}
        if there and options.angles then
            local angles = sim.getObjectOrientation(object, -1)
            numbers = {pose[1], pose[2], pose[3], math.deg(angles[1]), math.deg(angles[2]), math.deg(angles[3])}
        end
        for i = 1, options.angles and 6 or 7 do
            cells[#cells + 1] = numbers[i] and string.format('%.6f', numbers[i]) or ''
        end
    end
    file:write(table.concat(cells, ','), '\n')
end

function sysCall_sensing()
    -- The physics engine has already advanced, so the poses are those at the end of this step.
    local time = sim.getSimulationTime() + sim.getSimulationTimeStep()
    if file and time >= due - 1e-9 then
        line(time)
        due = options.period > 0 and math.floor(time / options.period + 1e-6) * options.period + options.period or 0
    end
end

function sysCall_afterSimulation()
    if file then
        file:close()
        file = nil
        sim.addLog(sim.verbosity_scriptinfos, 'pose_logger: wrote ' .. options.file)
    end
end

function sysCall_cleanup()
    sysCall_afterSimulation()
end
