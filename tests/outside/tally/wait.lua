-- Waits until the other script has counted far enough.
function sysCall_thread()
    assert(tally.wait('apples', 4) == 0)         -- already reached
    local t = tally.wait('steps', 10)
    assert(math.abs(t - 0.45) < 1e-9 or math.abs(t - 0.5) < 1e-9, 'woke at ' .. t)
    assert(t == sim.getSimulationTime())
    local u = tally.wait('steps', 20)
    assert(math.abs(u - t - 0.5) < 1e-9, 'woke at ' .. u)
    woke = true
    print('tally: waited until ' .. t .. ' and ' .. u)
end

function sysCall_cleanup()
    assert(woke, 'still waits')
end
