-- Runs in parallel with another script, and sets the velocity of its joint to the sum of the digits of a growing
-- number.
function sysCall_init()
    joint = sim.getObject('..')
    x = joint * 1234567
    tally.add('scripts')
end

function sysCall_actuation()
    x = x + 7919
    local n, digits = tally.digits(x)
    assert(n == #digits and n == #tostring(x))
    local sum = 0
    for _, d in ipairs(digits) do sum = sum + d end
    assert((sum - x) % 9 == 0)                      -- casting out nines
    sim.setJointTargetVelocity(joint, sum / 10)
    -- Parallel scripts cannot call commands with state per world. The first actuation after `init` runs alone.
    if turned then
        local done, why = pcall(tally.add, 'scripts')
        assert(not done and tostring(why):find('side_by_side'), why)
    end
    turned = (turned or 0) + 1
end

function sysCall_cleanup()
    assert(turned and turned >= 10, 'the run was too short')
    assert(tally.add('scripts', 0) == 2)
end
