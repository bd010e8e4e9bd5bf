-- `far` is pushed away; the tether takes `near` along. Momentum is preserved, and the distance stays near the length.
local near, far, tether, step, most = nil, nil, nil, 0, 0

function sysCall_init()
    near, far, tether = sim.getObject('/near'), sim.getObject('/far'), sim.getObject('/tether')
end

function sysCall_actuation()
    if step == 0 then sim.addForceAndTorque(far, {3 * 1 / sim.getSimulationTimeStep(), 0, 0}, {0, 0, 0}) end
end

function sysCall_sensing()
    step = step + 1
    most = math.max(most, tatu.read(tether).tension)
    if step < 2 then return end
    local momentum = sim.getObjectVelocity(near)[1] + 3 * sim.getObjectVelocity(far)[1]
    assert(math.abs(momentum - 3) < 1e-6, 'the momentum is ' .. momentum .. ' kg m/s, 3 was expected')
    local distance = sim.getObjectPosition(far)[1] - sim.getObjectPosition(near)[1]
    assert(distance < 1.2, 'the tether is ' .. distance .. ' m long')
end

function sysCall_cleanup()
    assert(step >= 60, 'the run was too short for the check: 60 steps are needed')
    assert(most > 1, 'there was no tension')
    assert(sim.getObjectVelocity(near)[1] > 0.3, '`near` was not taken along')
end

local ended = sysCall_cleanup
function sysCall_cleanup()
    if ended then ended() end
    print('the tether has held')
end
