-- The cart moves at 0.5 m/s, the box at 2 m/s; the radial speed is the difference, without any difference quotient.
local cart, box, radar, step = nil, nil, nil, 0

function sysCall_init()
    cart, box, radar = sim.getObject('/cart'), sim.getObject('/box'), sim.getObject('/radar')
end

function sysCall_actuation()
    if step == 0 then
        sim.addForceAndTorque(cart, {1 * 0.5 / sim.getSimulationTimeStep(), 0, 0}, {0, 0, 0})
        sim.addForceAndTorque(box, {2 * 2 / sim.getSimulationTimeStep(), 0, 0}, {0, 0, 0})
    end
end

function sysCall_sensing()
    step = step + 1
    if step < 3 or step > 30 then return end
    local r = tatu.read(radar)
    assert(r.object == box, 'it sees ' .. tostring(r.object))
    local relative = sim.getObjectVelocity(box)[1] - sim.getObjectVelocity(cart)[1]
    assert(math.abs(r.speed - relative) < 1e-9, r.speed .. ' m/s, where ' .. relative .. ' was expected')
    assert(r.speed > 1, 'the box does not move away: ' .. r.speed .. ' m/s')
end

local ended = sysCall_cleanup
function sysCall_cleanup()
    if ended then ended() end
    print(string.format('range %.6f', ({ros.message.radar(sim.getObject('/radar'))})[2].max_range))
end
