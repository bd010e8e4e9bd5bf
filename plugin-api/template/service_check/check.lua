-- Checks my_plugin: simulation time advances only after the third tick, and the number of ticks never decreases.
local step, last = 0, 3

function sysCall_actuation()
    step = step + 1
    local ticks = sim.getInt32Signal('my_plugin.ticks')
    assert(ticks and ticks >= last, 'step ' .. step .. ': expected ' .. last .. ' ticks, found ' .. tostring(ticks))
    last = ticks
    if step == 20 then
        print('my_plugin works: ' .. ticks .. ' ticks')
        sim.stopSimulation() -- a run with a service continues until it is stopped
    end
end

function sysCall_cleanup()
    assert(step >= 20, 'the run was too short for the check: 20 steps are needed')
end
