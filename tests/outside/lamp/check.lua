-- Checks the sensor kind `lamp`.
local exact, cheap, step = nil, nil, 0
local n, lost, sum, squares = 0, 0, 0, 0

local function near(a, b) return math.abs(a - b) < 1e-9 end

function sysCall_init()
    exact, cheap = sim.getObject('/exact'), sim.getObject('/cheap')
    assert(tatu.get(exact, 'lamp.range') == 2 and tatu.get(cheap, 'lamp.range') == 4)
end

function sysCall_sensing()
    step = step + 1
    local r = tatu.read(exact)
    if step == 1 then
        assert(r.seen == 1 and near(r.level, 0.5), r.level)
        tatu.set(exact, 'lamp.range', 4)                                -- calls configure
    elseif step == 2 then
        assert(r.sequence == 2, 'made anew, where it should have been configured: ' .. r.sequence)
        assert(r.seen == 1 and near(r.level, 0.75), r.level)
        tatu.set(exact, 'lamp.tilt', math.rad(60) * 0.9)
    elseif step == 3 then
        assert(near(r.level, 1 - 1 / math.cos(math.rad(54)) / 4), r.level)
        local ok, why = pcall(tatu.set, exact, 'lamp.range', 10)        -- refused by configure
        assert(not ok and why:find('at most 0.5 rad', 1, true), why)
        assert(tatu.get(exact, 'lamp.range') == 4)
        ok, why = pcall(tatu.set, exact, 'lamp.range', -1)              -- refused by the host
        assert(not ok); print(why)
        tatu.set(exact, 'lamp.tilt', 0)
        tatu.set(exact, 'lamp.range', 0.9)
    elseif step == 4 then
        assert(r.seen == 0 and r.level == 0)
    end
    -- The noise of the preset has a sigma of 0.01 and loses one reading in five.
    local c = tatu.read(cheap)
    if c.seen == 1 then
        n, sum, squares = n + 1, sum + c.level, squares + (c.level - 0.75) ^ 2
    else
        lost = lost + 1
        assert(c.level == 0)
    end
end

function sysCall_cleanup()
    local sigma = math.sqrt(squares / n)
    print('steps', step, 'lost', lost, 'mean', sum / n, 'sigma', sigma)
    assert(step >= 40 and lost > 1 and lost < 20 and sigma > 0.004 and sigma < 0.02)
end
