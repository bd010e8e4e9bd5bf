local function platform()
    return sim.getObject('/lift/platform')
end

-- Height of the platform's surface, m; the platform is 0.026 m thick.
local function surface()
    return sim.getObjectPosition(platform())[3] + 0.013
end

local function go(floor)
    sim.setInt32Signal('lift.floor', floor)
    local base = measure.model()
    sim.step()
    sim.step()
    while sim.readCustomStringData(base, 'at') ~= tostring(floor) do sim.step() end
    sim.wait(1)
end

local function load(mass)
    local box = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.5, 0.5, 0.2})
    sim.setObjectPosition(box, {0, 0, 0.131})
    sim.setFloatProperty(box, 'shape.mass', mass)
    sim.setBoolProperty(box, 'shape.respondable', true)
    sim.setBoolProperty(box, 'shape.dynamic', true)
end

function mass()
    return measure.mass(measure.model())
end

function middle_floor()
    go(1)
    return surface()
end

function highest_floor()
    go(2)
    return surface()
end

function loaded_height()
    load(150)
    sim.wait(0.5)
    go(2)
    return surface()
end

function loaded_drift()
    load(150)
    sim.wait(0.5)
    go(1)
    return measure.drift(platform(), 30)
end

function lifting_speed()
    sim.setInt32Signal('lift.floor', 2)
    while surface() < 0.2 do sim.step() end
    local from, time = surface(), sim.getSimulationTime()
    sim.wait(3)
    return (surface() - from) / (sim.getSimulationTime() - time)
end

function tour_floor()
    sim.wait(9)
    return surface()
end
