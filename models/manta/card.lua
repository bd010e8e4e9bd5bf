-- Measurements for the card of the Manta.

function mass()
    return measure.mass(measure.model())
end

function rest_drift()
    sim.wait(1)
    return measure.drift(measure.model(), 60)
end

function straight_speed()
    local car = measure.model()
    sim.setJointTargetVelocity(sim.getObject('/motor_joint'), 10)
    sim.wait(3)
    local from, at = sim.getObjectPosition(car), sim.getSimulationTime()
    sim.wait(4)
    return measure.distance(from, sim.getObjectPosition(car)) / (sim.getSimulationTime() - at)
end

-- Radius of a slow circle: the speed of the rear axle's middle, divided by the turning rate.
function least_radius()
    sim.setJointTargetPosition(sim.getObject('/steer_joint'), math.rad(30))
    sim.setJointTargetVelocity(sim.getObject('/motor_joint'), 3)
    sim.wait(4)
    local way, angle = measure.motion(measure.model(), 200)
    return way / angle
end

function steering_rate()
    local joint = sim.getObject('/steer_joint')
    sim.setJointTargetPosition(joint, math.rad(-30))
    sim.wait(2)
    sim.setJointTargetPosition(joint, math.rad(30))
    local greatest = 0
    for _ = 1, 30 do
        local before = sim.getJointPosition(joint)
        sim.step()
        greatest = math.max(greatest, (sim.getJointPosition(joint) - before) / sim.getSimulationTimeStep())
    end
    return greatest
end
