-- Stops the simulation on a condition: a time, a distance, a region, a standstill, or a collision.
-- Options: time=0        simulation time at which to stop, s; 0: never
--          object=       object to which the other conditions apply; default: the first model base
--          way=0         stop when the object has travelled this distance, m; 0: never
--          region=       x1,y1,x2,y2 in m: stop when the object is inside this region
--          outside=false true: stop when the object is outside the region
--          still=0       stop when the object has moved by at most 1 cm during this time, s; 0: never
--          hit=false     true: stop when the object or a descendant of it touches anything but a plane
--
--     tatu run scene.toml --seconds 600 --addon auto_stop:object=/Pioneer_p3dx,region=2,2,3,3
--
-- The first condition that is met is logged and stops the run. Two full steps follow, in which scripts can detect that
-- the run is stopping.

function sysCall_info()
    return {autoStart = false, menu = 'Stop\nOn a condition'}
end

local options, object, region, last, way, place, since, over

function sysCall_init()
    options = tatu.options{
        time = 0, object = '', way = 0, region = '', outside = false, still = 0, hit = false,
    }
    if options.region ~= '' then
        region = {}
        for part in options.region:gmatch('[^,]+') do
            region[#region + 1] = tonumber(part)
        end
        if #region ~= 4 then
            error('auto_stop: `region` must be four numbers in m: x1,y1,x2,y2')
        end
    end
    if options.hit then
        tatu.on('collision', function(e)
            local base = object and tatu.get(object, 'object.path')
            local function own(path)
                return path == base or path:sub(1, #base + 1) == base .. '/'
            end
            local function plane(o)
                return tatu.get(o, 'shape.primitive') == 'plane'
            end
            if base and own(e.a_path) ~= own(e.b_path) and not plane(e.a) and not plane(e.b) then
                stop(e.a_path .. ' and ' .. e.b_path .. ' touch')
            end
        end)
    end
end

function stop(why)
    if not over then
        over = true
        local time = sim.getSimulationTime() + sim.getSimulationTimeStep()
        sim.addLog(sim.verbosity_scriptinfos, string.format('auto_stop: %s at %.2f s', why, time))
        sim.stopSimulation()
    end
end

local function distance(a, b)
    return math.sqrt((a[1] - b[1]) ^ 2 + (a[2] - b[2]) ^ 2 + (a[3] - b[3]) ^ 2)
end

function sysCall_beforeSimulation()
    over, way, since, object = false, 0, 0, nil
    if options.object ~= '' then
        object = sim.getObject(options.object)
    else
        for _, o in ipairs(tatu.list()) do
            if not object and tatu.get(o, 'object.model_base') then
                object = o
            end
        end
    end
    if object then
        last = sim.getObjectPosition(object, -1)
        place = last
    elseif options.way > 0 or region or options.still > 0 or options.hit then
        error('auto_stop: the scene has no model; select an object with the option object=/A')
    end
end

function sysCall_sensing()
    local time = sim.getSimulationTime() + sim.getSimulationTimeStep()
    if options.time > 0 and time >= options.time - 1e-9 then
        stop('the time limit is reached')
    end
    if not object then
        return
    end
    local at = sim.getObjectPosition(object, -1)
    way, last = way + distance(at, last), at
    if options.way > 0 and way >= options.way then
        stop(string.format('the object has moved %.3f m', way))
    end
    if region then
        local inside = at[1] >= math.min(region[1], region[3]) and at[1] <= math.max(region[1], region[3])
            and at[2] >= math.min(region[2], region[4]) and at[2] <= math.max(region[2], region[4])
        if inside ~= options.outside then
            stop(options.outside and 'the object is outside the region' or 'the object is in the region')
        end
    end
    if distance(at, place) > 0.01 then
        place, since = at, time
    end
    if options.still > 0 and time - since >= options.still then
        stop('the object stands still')
    end
end
