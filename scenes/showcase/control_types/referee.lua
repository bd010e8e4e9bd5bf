-- Referee: reads true poses, which robots do not know. Records the distance that each robot has driven, draws the
-- paths, and raises an error if a robot does not move although it is driven, or has left its pen.

local ROBOTS = {'lua', 'addon', 'plugin', 'socket', 'zeromq', 'legacy', 'ros', 'jsonl', 'python'}
local WITHIN = 20.0                 -- s within which a driven robot must move by at least LEAST
local LEAST = 0.6                   -- m
local PEN = {1.0, 0.85}             -- m, half the extents of a pen
local DRAW_EVERY = 0.03             -- m

local robots = {}

local function color_of(robot)
    local _, color = sim.getShapeColor(robot, '', sim.colorcomponent_ambient_diffuse)
    return color
end

function sysCall_init()
    local graph = sim.getObject('/Driven')
    for i, name in ipairs(ROBOTS) do
        local handle = sim.getObject('/' .. name)
        local color = color_of(handle)
        local p = sim.getObjectPosition(handle, sim.handle_world)
        robots[i] = {
            name = name, handle = handle, left = sim.getObject('/' .. name .. '/leftMotor'),
            pen = sim.getObjectPosition(sim.getObject('/pen_' .. name), sim.handle_world),
            trail = sim.addDrawingObject(sim.drawing_lines + sim.drawing_cyclic, 2, 0, -1, 400, color),
            stream = sim.addGraphStream(graph, name, 'm', 0, color),
            at = p, drawn = p, way = 0, since = 0, way_then = 0,
        }
    end
end

local function gap(a, b)
    return math.sqrt((a[1] - b[1]) ^ 2 + (a[2] - b[2]) ^ 2)
end

local function judge(it, now)
    if math.abs(it.at[1] - it.pen[1]) > PEN[1] or math.abs(it.at[2] - it.pen[2]) > PEN[2] then
        error(string.format('/%s has left its pen', it.name))
    end
    if sim.getJointTargetVelocity(it.left) == 0 then
        if it.name == 'lua' and now > 1 then error('/lua is not driven by its script') end
        it.since, it.way_then = now, it.way
    elseif now - it.since >= WITHIN then
        if it.way - it.way_then < LEAST then
            error(string.format('/%s is driven, but went only %.2f m in %.0f s', it.name, it.way - it.way_then, WITHIN))
        end
        it.since, it.way_then = now, it.way
    end
end

function sysCall_sensing()
    local now = sim.getSimulationTime()
    for _, it in ipairs(robots) do
        local p = sim.getObjectPosition(it.handle, sim.handle_world)
        it.way = it.way + gap(p, it.at)
        it.at = p
        sim.setGraphStreamValue(sim.getObject('/Driven'), it.stream, it.way)
        if gap(p, it.drawn) > DRAW_EVERY then
            sim.addDrawingObjectItem(it.trail, {it.drawn[1], it.drawn[2], 0.01, p[1], p[2], 0.01})
            it.drawn = p
        end
        judge(it, now)
    end
end
