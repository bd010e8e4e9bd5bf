-- Checks holder: the integral removes the error that the weight causes, so the body ends at the commanded height.
local drone, holder, step = nil, nil, 0

function sysCall_init()
    drone, holder = sim.getObject('/drone'), sim.getObject('/holder')
    sim.setFloatProperty(holder, 'holder.height', 1.5)
end

function sysCall_sensing()
    step = step + 1
    if step ~= 160 then return end
    local height = sim.getObjectPosition(drone)[3]
    assert(math.abs(height - 1.5) < 1e-3, height .. ' m, where 1.5 m was expected')
    local told = tatu.read(holder).error
    assert(math.abs(told - (1.5 - height)) < 1e-9, 'its reading is ' .. told)
    print('holder works: the body is held at ' .. height .. ' m')
    sim.stopSimulation()
end

function sysCall_cleanup()
    assert(step >= 160, 'the run was too short for the check: 160 steps are needed')
end

local ended = sysCall_cleanup
function sysCall_cleanup()
    if ended then ended() end
    print('held')
end
