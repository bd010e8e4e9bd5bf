-- Puts a carton of 1 kg on the belt at `x`.
local function carton(x)
    local box = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.2, 0.15, 0.1})
    sim.setObjectPosition(box, {x, 0, 0.65})
    sim.setFloatProperty(box, 'shape.mass', 1)
    sim.setBoolProperty(box, 'shape.respondable', true)
    sim.setBoolProperty(box, 'shape.dynamic', true)
    return box
end

-- Mean speed along x, m/s.
local function speedAlong(object, seconds)
    local from = sim.getObjectPosition(object)[1]
    sim.wait(seconds)
    return (sim.getObjectPosition(object)[1] - from) / seconds
end

local function ask(speed)
    sim.writeCustomStringData(measure.model(), 'speed', tostring(speed))
end

function carried_speed()
    local box = carton(-0.8)
    sim.wait(1)
    return speedAlong(box, 4)
end

function signal_speed()
    sim.setFloatSignal('conveyor.speed', 0.4)
    sim.wait(1)
    local box = carton(-0.8)
    sim.wait(1)
    return speedAlong(box, 2)
end

function reversed_speed()
    ask(-0.3)
    sim.wait(2)
    local box = carton(0.8)
    sim.wait(1)
    return speedAlong(box, 3)
end

function stopped()
    ask(0)
    sim.wait(2)
    local box = carton(0)
    sim.wait(1)
    return measure.drift(box, 5)
end

function start_time()
    ask(0)
    sim.wait(2)
    ask(0.5)
    local from = sim.getSimulationTime()
    while tonumber(sim.readCustomStringData(measure.model(), 'belt_speed')) < 0.4999 do sim.step() end
    return sim.getSimulationTime() - from
end
