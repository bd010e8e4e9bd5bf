-- The errors of the ranges have the declared deviation, the wall hides one beacon, and a removed beacon has no range.
local box, tag, step, sum, squares, n = nil, nil, 0, 0, 0, 0
local sees = {1, 0, 1, 0}

function sysCall_init()
    box, tag = sim.getObject('/box'), sim.getObject('/tag')
end

function sysCall_actuation()
    if step == 0 then
        sim.addForceAndTorque(box, {0, 0.5 / sim.getSimulationTimeStep(), 0}, {0, 0, 0})
    elseif step == 30 then
        sim.removeObjects({sim.getObject('/near')})
        assert(#tatu.get(tag, 'sensor.targets') == 4)
    elseif step == 40 then
        tatu.set(tag, 'sensor.targets', {'/lamp'})
        sees = {1}
    end
end

function sysCall_sensing()
    step = step + 1
    local told = tatu.read(tag)
    local ranges, seen = told.range, told.line_of_sight
    if step == 41 then
        assert(type(ranges) == 'number' or #ranges == 1, 'the fields have another size')
    end
    if step > 40 then return end
    for k, name in ipairs({'/near', '/hidden', '/lamp', '/distant'}) do
        local gone = name == '/near' and step > 30
        assert(seen[k] == (gone and 0 or sees[k]), name .. ' in step ' .. step .. ': ' .. seen[k])
        if gone or name == '/distant' then
            assert(ranges[k] == 0, name .. ' is ' .. ranges[k] .. ' m away')
        else
            local p = sim.getObjectPosition(sim.getObject(name), tag)
            local distance = math.sqrt(p[1] ^ 2 + p[2] ^ 2 + p[3] ^ 2) + (name == '/hidden' and 0.5 or 0)
            local wrong = ranges[k] - distance
            assert(math.abs(wrong) < 0.15, name .. ': ' .. ranges[k] .. ' m instead of ' .. distance .. ' m')
            sum, squares, n = sum + wrong, squares + wrong ^ 2, n + 1
        end
    end
end

function sysCall_cleanup()
    assert(step >= 41, 'the run was too short for the check: 41 steps are needed')
    assert(sim.getObjectVelocity(box)[2] > 0.4, 'the box rests')
    local mean, deviation = sum / n, math.sqrt(squares / n)
    assert(math.abs(mean) < 0.01 and deviation > 0.015 and deviation < 0.025, mean .. ' m, ' .. deviation .. ' m')
end

local ended = sysCall_cleanup
function sysCall_cleanup()
    if ended then ended() end
    print('the tag has measured')
end
