-- Checks that snapshots contain the count of `counter`. It does not use tatu.on, because snapshots contain no
-- subscriptions.
step = 0

function sysCall_actuation()
    step = step + 1
    local ticks, due = sim.getInt32Signal('ticks'), math.min(step, 40)
    assert(ticks == due, 'step ' .. step .. ', but ' .. tostring(ticks) .. ' ticks')
end

function sysCall_cleanup() print('steps', step); assert(step >= 40) end
