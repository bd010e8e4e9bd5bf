local function angle()
    return sim.getJointPosition(sim.getObject('/door/hinge'))
end

function mass()
    return measure.mass(measure.model())
end

function rest_drift()
    local from, most = angle(), 0
    for _ = 1, 60 do
        sim.wait(1)
        most = math.max(most, math.abs(angle() - from))
    end
    return most
end

-- Time that the closer needs to close the door from 90 degrees.
function closing_time()
    repeat sim.step() until angle() < 0.001
    return sim.getSimulationTime()
end

-- Applies a force of 10 N to the handle, always perpendicular to the leaf.
function opening_time()
    local leaf = sim.getObject('/door/leaf')
    while angle() < 1 do
        sim.addForce(leaf, {0, -0.795, 1.05}, {10, 0, 0})
        sim.step()
    end
    return sim.getSimulationTime()
end

function held_angle()
    local leaf = sim.getObject('/door/leaf')
    for _ = 1, 40 do
        sim.addForce(leaf, {0, -0.795, 1.05}, {100, 0, 0})
        sim.step()
    end
    return angle()
end
