local function body(primitive, size, mass, position)
    local object = sim.createPrimitiveShape(primitive, size)
    sim.setObjectPosition(object, position)
    sim.setFloatProperty(object, 'shape.mass', mass)
    sim.setBoolProperty(object, 'shape.respondable', true)
    sim.setBoolProperty(object, 'shape.dynamic', true)
    return object
end

-- Turning rate about z, rad/s.
local function rate(object, seconds)
    local from = measure.angle(object)
    for _ = 1, math.floor(seconds / 0.5 + 0.5) do
        sim.wait(0.5)
        measure.angle(object)
    end
    return (measure.angle(object) - from) / seconds
end

-- Time until the platter turns at 1 rad/s, from rest.
local function startTime()
    local motor = sim.getObject('/turntable/turntable_motor')
    sim.setJointTargetVelocity(motor, 1)
    local from = sim.getSimulationTime()
    repeat sim.step() until sim.getJointVelocity(motor) > 0.99
    return sim.getSimulationTime() - from
end

function mass()
    return measure.mass(measure.model())
end

function turning_rate()
    sim.wait(1)
    return rate(sim.getObject('/turntable/platter'), 5)
end

function loaded_rate()
    local box = body(sim.primitiveshape_cuboid, {0.2, 0.2, 0.2}, 10, {0.15, 0, 0.221})
    sim.wait(2)
    return rate(box, 5)
end

function start_time()
    sim.setJointTargetVelocity(sim.getObject('/turntable/turntable_motor'), 0)
    sim.wait(1)
    return startTime()
end

function loaded_start_time()
    sim.setJointTargetVelocity(sim.getObject('/turntable/turntable_motor'), 0)
    body(sim.primitiveshape_cylinder, {0.6, 0.6, 0.1}, 50, {0, 0, 0.171})
    sim.wait(1)
    return startTime()
end
