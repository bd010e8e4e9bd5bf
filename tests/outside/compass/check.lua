-- Turns the needle, changes the compass's offset, and checks its readings.
local function near(a, b, what)
    assert(math.abs(a - b) < 1e-9, what .. ': ' .. a .. ', expected ' .. b)
end

-- For each step: orientation of the needle (about its own x, y, z), offset, and expected reading (nil: no reading).
local steps = {
    {{0, 0, 0}, 0.1, 0.1},
    {{0, 0, 1}, 0.1, 1.1},
    {{0, 0, -2}, 0.1, -1.9},
    {{0, 0, 1}, 0.5, 1.5},                     -- the offset changes during the run
    {{0, 0, 3}, 0.5, 3.5 - 2 * math.pi},       -- above pi
    {{0, -math.pi / 2, 0}, 0.5, nil},          -- the x axis points up
    {{0, -math.pi / 2 + 0.04, 0}, 0.5, nil},   -- nearly up: still no heading
    {{0, -math.pi / 2 + 0.1, 0}, 0.5, 0.5},    -- just far enough from the vertical for a heading
    {{1, 0, 0}, -0.5, -0.5},                   -- rolled about its x axis
}

function sysCall_init()
    needle = sim.getObject('/needle')
    compass = sim.getObject('/needle/compass')
    second = sim.getObject('/second')
    n = 0
    near(tatu.get(compass, 'needle.offset'), 0.1, 'offset of the scene')
    assert(tatu.read(compass).sequence == 0)
end

function sysCall_actuation()
    n = n + 1
    local step = steps[n]
    if step then
        tatu.set(needle, 'object.orientation', step[1])
        if tatu.get(compass, 'needle.offset') ~= step[2] then
            tatu.set(compass, 'needle.offset', step[2])
        end
        near(tatu.get(compass, 'needle.offset'), step[2], 'offset')
    end
end

function sysCall_sensing()
    local step = steps[n]
    if not step then return end
    local r = tatu.read(compass)
    assert(r.sequence == n, 'sequence ' .. r.sequence .. ' in step ' .. n) -- changes do not reset the sensor
    assert(r.time == sim.getSimulationTime())
    if step[3] then
        assert(r.valid == 1, 'no heading in step ' .. n)
        near(r.heading, step[3], 'heading in step ' .. n)
    else
        assert(r.valid == 0 and r.heading == 0, 'a heading in step ' .. n)
    end
    near(tatu.read(second).heading, math.pi / 2 + 0.0716, 'the preset')
    if n == 1 then
        assert(not pcall(tatu.set, compass, 'needle.offset', 4), 'out of range')
        near(tatu.get(compass, 'needle.offset'), 0.1, 'offset after a refusal')
    end
end

function sysCall_cleanup()
    assert(n >= #steps, 'the run was too short')
    assert(tatu.read(second).sequence < n, 'its rate is 10 Hz')
    print('compass: ' .. n .. ' steps checked')
end
