-- Checks the service `counter`.
step, rounds = 0, 0

function sysCall_init()
    tatu.on('counter.round', function(e, name)
        assert(name == 'counter.round' and e.steps % 5 == 0 and e.commands == e.steps + e.steps / 5 - 1)
        rounds = rounds + 1
    end)
end

function sysCall_actuation()
    step = step + 1
    local ticks = sim.getInt32Signal('ticks')
    local due = math.min(step, 40)              -- services are not called after a stop
    assert(ticks == due, 'step ' .. step .. ', but ' .. tostring(ticks) .. ' ticks')
end

function sysCall_cleanup()
    print('steps', step, 'rounds', rounds)
    assert(step >= 40 and rounds >= 8)
end
