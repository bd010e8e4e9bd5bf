-- The measurements for the card. Each function runs as a threaded script beside the model, on a floor, in a separate
-- world.

function straight_speed()
    local robot = measure.model()
    tatu.drive(robot, 0.2, 0, 0)
    sim.wait(1)
    local from = sim.getObjectPosition(robot)
    sim.wait(4)
    return measure.distance(from, sim.getObjectPosition(robot)) / 4
end

function rest_drift()
    sim.wait(1)
    return measure.drift(measure.model(), 10)
end
