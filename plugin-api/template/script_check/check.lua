-- Checks the language my_plugin: the lines of demo.my_plugin have run.
local step = 0

function sysCall_sensing()
    step = step + 1
    assert(sim.getInt32Signal('my_plugin.ready') == 1, 'its `init` has not run')
    assert(sim.getStringSignal('my_plugin.says') == 'hello', 'its first `actuation` has not run')
    assert(sim.getFloatSignal('my_plugin.half') == 0.5, 'its second `actuation` has not run')
    if step == 3 then
        print('my_plugin works: its lines have run')
        sim.stopSimulation()
    end
end

function sysCall_cleanup()
    assert(step >= 3, 'the run was too short for the check: 3 steps are needed')
end
