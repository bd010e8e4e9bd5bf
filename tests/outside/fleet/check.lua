-- Checks the commands of fleet.
function sysCall_init()
    local fast, slow = sim.getObject('/fast'), sim.getObject('/slow')
    local seen = fleet.each({fast, slow}, function(handle, about)
        assert(about.count == 2)
        return {handle = handle, index = about.index, y = sim.getObjectPosition(handle)[2]}
    end)
    assert(#seen == 2 and seen[1].handle == fast and seen[2].index == 2 and seen[2].y == 2)
    assert(#fleet.each({}, print) == 0)
    assert(fleet.each({fast}, function() end)[1] == false)
    local ok, why = pcall(fleet.each, {fast}, function() error('no luck') end)
    assert(not ok and why:find('no luck'), why)
    ok, why = pcall(fleet.each, 5, print)
    assert(not ok); print(why)
    ok, why = pcall(fleet.arrive, fast, {5, 0}, 0.1)        -- init cannot wait
    assert(not ok); print(why)
end

function sysCall_thread()
    local fast, slow = sim.getObject('/fast'), sim.getObject('/slow')
    local t = fleet.arrive(slow, {0, 2}, 0.1)               -- already there
    assert(t == 0, t)
    t = fleet.arrive(fast, {1, 0}, 0.06)
    print('the fast one came at', t)
    assert(t > 0.9 and t < 1.05, t)
    assert(math.abs(sim.getObjectPosition(fast)[1] - 1) <= 0.06)
    local ok, why = pcall(fleet.arrive, 12345, {0, 0}, 1)
    assert(not ok); print(why)
    t = fleet.arrive(slow, {1, 2}, 0.05)
    print('the slow one came at', t)
    assert(t > 1.8 and t < 2.1, t)
    done = true
end

function sysCall_cleanup()
    assert(done, 'the thread has not come to its end')
end
