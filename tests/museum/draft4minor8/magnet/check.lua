-- The magnet on the axis is pulled with 3 mu0 m1 m2 / (2 pi r^4), the other one turns, and momentum and angular momentum
-- are preserved.
local base, ahead, beside, step = nil, nil, nil, 0

function sysCall_init()
    base, ahead, beside = sim.getObject('/base'), sim.getObject('/ahead'), sim.getObject('/beside')
    sim.removeObjects({sim.getObject('/gone')})
end

function sysCall_sensing()
    step = step + 1
    local pulled, pushed, turned = sim.getObjectVelocity(ahead), sim.getObjectVelocity(base), nil
    local other, spin = sim.getObjectVelocity(beside)
    for k = 1, 3 do
        local momentum = pulled[k] + 4 * pushed[k] + other[k]
        assert(math.abs(momentum) < 1e-9, 'the momentum is ' .. momentum .. ' kg m/s')
    end
    local angular = {0, 0, 0}
    for body, mass in pairs({[base] = 4, [ahead] = 1, [beside] = 1}) do
        local p, v, w = sim.getObjectPosition(body), sim.getObjectVelocity(body)
        for k = 1, 3 do
            local a, b = k % 3 + 1, (k + 1) % 3 + 1
            -- The bodies are cubes.
            angular[k] = angular[k] + mass * (p[a] * v[b] - p[b] * v[a]) + mass * 0.05 ^ 2 / 6 * w[k]
        end
    end
    for k = 1, 3 do
        -- Without the reaction, it would be 1e-3; the engine's steps are not exact.
        assert(math.abs(angular[k]) < 1e-6, 'the angular momentum is ' .. angular[k] .. ' kg m^2/s')
    end
    if step == 1 then
        local expected = 6e-7 * 50 * 50 / 0.4 ^ 4 * sim.getSimulationTimeStep()
        assert(math.abs(pulled[3] / -expected - 1) < 0.02, pulled[3] .. ' m/s, where -' .. expected .. ' was expected')
        turned = math.sqrt(spin[1] ^ 2 + spin[2] ^ 2 + spin[3] ^ 2)
        assert(turned > 1e-4, 'the magnet beside does not turn')
    end
end

function sysCall_cleanup()
    assert(step >= 5, 'the run was too short for the check: 5 steps are needed')
end

local ended = sysCall_cleanup
function sysCall_cleanup()
    if ended then ended() end
    print('the magnet has pulled')
end
