-- Draws the paths of objects, and logs their lengths.
-- Options: objects=/A,/B   the objects; default: all model bases
--          step=0.05       distance between two points of a path, m
--          most=10000      maximum number of points of a path
--          color=1 0.4 0   red, green, blue, 0 to 1; the components are rotated for each further object
--          width=2         line width, pixels
--
--     tatu run scene.toml --addon path_tracer:objects=/Pioneer_p3dx

function sysCall_info()
    return {autoStart = false, menu = 'View\nPaths'}
end

local options, traced

function sysCall_init()
    options = tatu.options{objects = '', step = 0.05, most = 10000, color = '1 0.4 0', width = 2}
end

-- Returns the colour of path n: the given colour, with its components rotated by n - 1 positions.
local function color(n)
    local parts = {}
    for part in options.color:gmatch('%S+') do
        parts[#parts + 1] = tonumber(part)
    end
    if #parts ~= 3 then
        error('path_tracer: `color` must be three numbers separated by spaces, such as "1 0.4 0"')
    end
    local shift = (n - 1) % 3
    return {parts[shift % 3 + 1], parts[(shift + 1) % 3 + 1], parts[(shift + 2) % 3 + 1]}
end

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

local function distance(a, b)
    return math.sqrt((a[1] - b[1]) ^ 2 + (a[2] - b[2]) ^ 2 + (a[3] - b[3]) ^ 2)
end

function sysCall_beforeSimulation()
    traced = {}
    for i, object in ipairs(chosen()) do
        local at = sim.getObjectPosition(object, -1)
        local drawing = sim.addDrawingObject(sim.drawing_lines, options.width, 0, -1, options.most, color(i))
        traced[i] = {
            object = object, path = tatu.get(object, 'object.path'), drawing = drawing, drawn = at, last = at, length = 0,
        }
    end
end

function sysCall_sensing()
    for _, t in ipairs(traced) do
        local there, at = pcall(sim.getObjectPosition, t.object, -1)
        if there then
            t.length = t.length + distance(at, t.last)
            t.last = at
            if distance(at, t.drawn) >= options.step then
                local a = t.drawn
                sim.addDrawingObjectItem(t.drawing, {a[1], a[2], a[3], at[1], at[2], at[3]})
                t.drawn = at
            end
        end
    end
end

function sysCall_afterSimulation()
    for _, t in ipairs(traced) do
        sim.addLog(sim.verbosity_scriptinfos, string.format('path_tracer: %s went %.3f m', t.path, t.length))
    end
end
