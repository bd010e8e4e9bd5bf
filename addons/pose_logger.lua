-- Writes the poses of objects to a CSV file while a simulation runs.
-- Options: objects=/A,/B   which; default: every model base (robots and the like)
--          file=poses.csv  where to; within the folder for files (`--files`, else the working folder)
--          period=0        seconds between two lines; 0: every step
--          angles=false    true: Euler angles alpha, beta, gamma in degrees in place of the quaternion
--
--     tatu run scene.toml --addon pose_logger:objects=/Pioneer_p3dx,period=0.1

function sysCall_info()
    return {autoStart = false, menu = 'Logs\nPoses'}
end

local options, objects, file, due

function sysCall_init()
    options = tatu.options{objects = '', file = 'poses.csv', period = 0, angles = false}
end

-- The objects that are meant, in the order given, or of the tree.
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
        error('pose_logger: the scene has no model; name what to log: objects=/A,/B')
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
        -- An object that was removed leaves its cells empty.
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
    -- Physics has moved things to where they are at the end of this step.
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
