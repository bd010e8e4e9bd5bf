-- Turns the axis about once per second. The speed depends on the number of turns that the sensor has counted, so the
-- run differs if the state of the sensor is lost.
function sysCall_init()
    axis, counter = sim.getObject('..'), sim.getObject('./table/counter')
end

function sysCall_sensing()
    turns = tatu.read(counter).turns
    sim.setJointTargetVelocity(axis, 2 * math.pi + 0.01 * math.sin(turns))
end

function sysCall_cleanup()
    local t = sim.getSimulationTime()
    assert(math.abs(turns - t) < 0.1, turns .. ' turns in ' .. t .. ' s')
end
