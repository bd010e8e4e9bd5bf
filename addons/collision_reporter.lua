-- Logs collisions with their objects, time, point and force, and prints a summary at the end.
-- Options: floors=false    true: also log collisions with planes, such as the floor
--          apart=0.5       time for which two objects must be apart before their next collision is logged, s
--          only=/A,/B      log only collisions of these objects and their descendants
--          file=           also write the collisions to this CSV file
--
--     tatu run scene.toml --addon collision_reporter:only=/Pioneer_p3dx

function sysCall_info()
    return {autoStart = false, menu = 'Reports\nCollisions'}
end

local options, pairs_of, file

local function is_plane(object)
    return tatu.get(object, 'shape.primitive') == 'plane'
end

-- Returns whether a path is that of a selected object, or of a descendant of a selected object.
local function is_meant(path)
    if options.only == '' then
        return true
    end
    for base in options.only:gmatch('[^,]+') do
        if path == base or path:sub(1, #base + 1) == base .. '/' then
            return true
        end
    end
    return false
end

local function say(text)
    sim.addLog(sim.verbosity_scriptinfos, 'collision_reporter: ' .. text)
end

local function collided(e)
    if not is_meant(e.a_path) and not is_meant(e.b_path) then
        return
    end
    if not options.floors and (is_plane(e.a) or is_plane(e.b)) then
        return
    end
    local time = sim.getSimulationTime()
    local key = e.a_path .. ' and ' .. e.b_path
    local pair = pairs_of[key]
    if not pair then
        pair = {key = key, count = 0, force = 0, last = -math.huge}
        pairs_of[key], pairs_of[#pairs_of + 1] = pair, pair
    end
    pair.force = math.max(pair.force, e.force)
    if time - pair.last >= options.apart then
        pair.count = pair.count + 1
        local p = e.point
        say(string.format('%.2f s: %s at (%.3f, %.3f, %.3f) m, %.1f N', time, key, p[1], p[2], p[3], e.force))
        if file then
            file:write(string.format('%.3f,"%s","%s",%.6f,%.6f,%.6f,%.3f\n', time, e.a_path, e.b_path, p[1], p[2], p[3],
                e.force))
        end
    end
    pair.last = time
end

function sysCall_init()
    options = tatu.options{floors = false, apart = 0.5, only = '', file = ''}
    tatu.on('collision', collided)
end

function sysCall_beforeSimulation()
    pairs_of = {}
    if options.file ~= '' then
        local why
        file, why = io.open(options.file, 'w')
        if not file then
            error('collision_reporter: cannot write ' .. options.file .. ': ' .. tostring(why))
        end
        file:write('time_s,a,b,x_m,y_m,z_m,force_n\n')
    end
end

function sysCall_afterSimulation()
    if #pairs_of == 0 then
        say('no collisions')
    end
    for _, pair in ipairs(pairs_of) do
        say(string.format('%d time(s) %s, at most %.1f N', pair.count, pair.key, pair.force))
    end
    if file then
        file:close()
        file = nil
    end
end
