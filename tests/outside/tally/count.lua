-- Counts its steps, and checks the results of the commands.
function sysCall_init()
    n = 0
    joint = sim.getObject('..')
    assert(tally.add('apples', 3) == 3 and tally.add('apples') == 4)
    assert(tally.add('pears', -2) == -2)
    local count, digits = tally.digits(-4072)
    assert(count == 4 and #digits == 4)
    assert(digits[1] == 4 and digits[2] == 0 and digits[3] == 7 and digits[4] == 2)
    assert(tally.digits(0) == 1)

    -- Invalid arguments are refused and have no effect.
    assert(not pcall(tally.add, 'apples', 'many'))
    assert(not pcall(tally.each))
    assert(not pcall(tally.add, 'apples', math.maxinteger))
    -- If the function fails, `each` stops and raises the function's error.
    local done, why = pcall(tally.each, function(name) error('not ' .. name) end)
    assert(not done and tostring(why):find('not apples'), why)
end

function sysCall_actuation()
    n = n + 1
    local steps = tally.add('steps')
    assert(steps == n)                          -- snapshots contain both, saved by different plugins
    sim.setJointTargetVelocity(joint, steps % 7 - 3)    -- makes the run's hash depend on the count
end

function sysCall_sensing()
    local seen, order = {}, {}
    local count = tally.each(function(name, count)
        seen[name] = count
        order[#order + 1] = name
        tally.add('rounds')                     -- a command of the same plugin, from within it
    end)
    assert(count == #order)
    assert(seen.apples == 4 and seen.pears == -2 and seen.steps == n)
    for i = 2, #order do assert(order[i - 1] < order[i]) end
end

function sysCall_cleanup()
    assert(n >= 30, 'the run was too short')
    print('tally: ' .. n .. ' steps counted')
end
