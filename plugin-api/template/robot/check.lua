-- Drives 1 m at 0.5 m/s and checks the position of the robot. An error in a script makes the run fail.
local me, from, passed

function sysCall_init()
    me = sim.getObject('..')
    from = sim.getObjectPosition(me)
end

function sysCall_actuation()
    local t = sim.getSimulationTime()
    tatu.drive(me, t < 2 and 0.5 or 0, 0, 0)
    if t >= 3 then
        local to = sim.getObjectPosition(me)
        assert(math.abs(to[1] - from[1] - 1) < 0.1, 'it has driven ' .. to[1] - from[1] .. ' m instead of 1 m')
        assert(math.abs(to[2] - from[2]) < 0.02, 'it has not driven straight')
        assert(math.abs(to[3] - from[3]) < 0.01, 'it has left the floor')
        local pitch = math.deg(sim.getObjectOrientation(me)[2])
        assert(math.abs(pitch) < 5, 'it leans by ' .. pitch .. ' degrees')
        if not passed then print(sim.getObjectAlias(me, 2) .. ' passes') end
        passed = true
    end
end
