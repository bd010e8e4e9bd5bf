-- Each box does what the surface below it decides; the one on the pad that decides nothing stays.
local step, box, surface, extra, highest = 0, {}, {}, nil, 0

function sysCall_init()
    for _, mode in ipairs({'none', 'open', 'ice', 'belt', 'bouncy'}) do
        box[mode], surface[mode] = sim.getObject('/box_' .. mode), sim.getObject('/surface_' .. mode)
    end
end

function sysCall_actuation()
    if step == 3 then extra = sim.createDummy(0.1) end
    if step == 6 then sim.removeObjects({extra}) end
end

local function at(mode) return sim.getObjectPosition(box[mode]) end

function sysCall_sensing()
    step = step + 1
    if step > 16 then highest = math.max(highest, at('bouncy')[3]) end
    if step ~= 38 then return end
    assert(math.abs(at('none')[1]) < 1e-3 and at('none')[3] > 0.14, 'the first box has moved')
    assert(at('open')[3] < -0.5, 'the second box has not fallen through: ' .. at('open')[3])
    assert(at('ice')[1] > 0.3, 'the third box has not slid: ' .. at('ice')[1])
    local speed = sim.getObjectVelocity(box.belt)[1]
    assert(at('belt')[1] > 0.3 and math.abs(speed - 0.3) < 0.01, 'the belt moves its box at ' .. speed)
    assert(highest > 0.35, 'the last box has bounced up to ' .. highest)
    for mode, handle in pairs(surface) do
        local told = tatu.read(handle)
        assert(told.calls > 0, 'no decisions of ' .. mode)
        assert(told.begun == 1 and told.removed == 1, mode .. ': ' .. told.begun .. ' starts, ' .. told.removed .. ' removals')
    end
    local added, removed, contact, separation = surfaces.counts()
    assert(added == 1 and removed == 1, added .. ' added, ' .. removed .. ' removed')
    assert(contact > 50 and separation > 0, contact .. ' contacts, ' .. separation .. ' separations')
end

function sysCall_cleanup()
    assert(step >= 38, 'the run was too short for the check: 38 steps are needed')
end

local ended = sysCall_cleanup
function sysCall_cleanup()
    if ended then ended() end
    print(surfaces.counts())
end
