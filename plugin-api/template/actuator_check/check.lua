-- Checks my_plugin: a force F with a lag T gives a mass m the speed F/m (t - T (1 - exp(-t/T))).
local hull, propeller, step = nil, nil, 0

function sysCall_init()
    hull, propeller = sim.getObject('/hull'), sim.getObject('/propeller')
    sim.setFloatProperty(propeller, 'my_plugin.force', 100) -- clamped to max_force, 5 N
end

function sysCall_sensing()
    step = step + 1
    if step ~= 40 then return end
    local t = step * sim.getSimulationTimeStep()
    local expected = 5 / 2 * (t - 0.5 * (1 - math.exp(-t / 0.5)))
    local v = sim.getObjectVelocity(hull)
    assert(math.abs(v[1] - expected) < 0.01 * expected, v[1] .. ' m/s, where ' .. expected .. ' was expected')
    assert(math.abs(v[2]) < 1e-6 and math.abs(v[3]) < 1e-6, 'the hull moves sideways')
    print('my_plugin works: the hull moves at ' .. v[1] .. ' m/s')
    sim.stopSimulation()
end

function sysCall_cleanup()
    assert(step >= 40, 'the run was too short for the check: 40 steps are needed')
end
