
-- Helper functions for measures in card.lua; see docs/plugin-authors/robots.md.
measure = {}

function measure.model()
    for _, object in ipairs(sim.getObjectsInTree(sim.handle_scene)) do
        local alias = sim.getObjectAlias(object)
        if sim.getObjectParent(object) == -1 and alias ~= 'floor' and alias ~= 'measure' then return object end
    end
end

function measure.mass(object)
    local sum = 0
    for _, shape in ipairs(sim.getObjectsInTree(object, sim.object_shape_type)) do
        if tatu.get(shape, 'shape.dynamic') then sum = sum + tatu.get(shape, 'shape.mass') end
    end
    return sum
end

function measure.distance(a, b)
    local sum = 0
    for i = 1, #a do sum = sum + (a[i] - b[i]) ^ 2 end
    return math.sqrt(sum)
end

function measure.drift(object, seconds)
    local from, till, most = sim.getObjectPosition(object), sim.getSimulationTime() + seconds, 0
    while sim.getSimulationTime() < till do
        sim.step()
        most = math.max(most, measure.distance(from, sim.getObjectPosition(object)))
    end
    return most
end

local headings = {}
function measure.angle(object)
    local m = sim.getObjectMatrix(object)
    local now, before = math.atan(m[5], m[1]), headings[object] or 0
    now = now + 2 * math.pi * math.floor((before - now) / (2 * math.pi) + 0.5)
    headings[object] = now
    return now
end

-- Returns the length of the path that an object travels in `steps` steps, m, and the angle by which it rotates, rad.
function measure.motion(object, steps)
    local way, from, at = 0, measure.angle(object), sim.getObjectPosition(object)
    for _ = 1, steps do
        sim.step()
        local now = sim.getObjectPosition(object)
        way, at = way + measure.distance(at, now), now
        measure.angle(object)
    end
    return way, measure.angle(object) - from
end

function measure.speed(object)
    local v = sim.getObjectVelocity(object)
    return math.sqrt(v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2)
end

function measure.tilt(object)
    return math.acos(math.max(-1, math.min(1, sim.getObjectMatrix(object)[11])))
end
