-- Checks my_plugin: after t seconds, a puck at 1 m/s has travelled t metres.
function sysCall_init()
    puck = sim.getObject('/puck')
    assert(my_plugin.travelled(puck) == 0, 'the first call must return 0')
    asked = 0
end

function sysCall_sensing()
    asked = asked + 1
    local metres, seconds = my_plugin.travelled(puck), sim.getSimulationTime() + sim.getSimulationTimeStep()
    assert(math.abs(metres - seconds) < 0.01, 'after ' .. seconds .. ' s it returns ' .. metres .. ' m')
    if asked == 40 then
        my_plugin.reset()
        assert(my_plugin.travelled(puck) == 0, 'reset() had no effect')
        print('my_plugin works: the puck has travelled ' .. metres .. ' m')
        sim.stopSimulation()
        sysCall_sensing = nil
    end
end

function sysCall_cleanup()
    assert(asked == 40, 'the run was too short for the check: 40 steps are needed')
end
