-- Checks an impact sensor: no force during the fall, one impact on the floor, and its weight at rest.
local feeler, step, before = nil, 0, 0

function sysCall_init()
    feeler = sim.getObject('/box/feeler')
end

function sysCall_sensing()
    step = step + 1
    local r = tatu.read(feeler)
    local fallen = step * sim.getSimulationTimeStep()
    if fallen < 0.449 then assert(r.strength < 1e-9 and r.count == 0, r.strength) end
    if fallen > 0.5 then assert(r.count >= 1, 'the blow is between two steps of the world, and is counted all the same') end
    if fallen > 2 then assert(math.abs(r.strength - 9.81) < 1e-3 and r.count == before, r.strength) end
    before = r.count
end

function sysCall_cleanup()
    assert(step >= 60 and before >= 1, before)
    print('shock: ' .. before .. ' counted')
end
