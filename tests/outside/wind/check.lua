-- The quadcopter is within the box and drifts along x; the ball beside it falls straight down.
local drone, ball, step = nil, nil, 0

function sysCall_init()
    drone, ball = sim.getObject('/crazyflie'), sim.getObject('/ball')
end

function sysCall_sensing()
    step = step + 1
    if step ~= 10 then return end
    local v, still = sim.getObjectVelocity(drone), sim.getObjectVelocity(ball)
    assert(v[1] > 0.1 and v[1] < 6, 'the quadcopter drifts at ' .. v[1] .. ' m/s')
    assert(still[1] == 0, 'the ball drifts at ' .. still[1] .. ' m/s')
end

function sysCall_cleanup()
    assert(step >= 10, 'the run was too short for the check: 10 steps are needed')
end
