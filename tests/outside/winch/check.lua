-- The crate hangs on its cable, and follows it upwards; without its hook it falls.
local winch, hook, step = nil, nil, 0

function sysCall_init()
    winch, hook = sim.getObject('/winch'), sim.getObject('/crate/hook')
end

function sysCall_actuation()
    if step >= 20 and step < 60 then
        tatu.set(winch, 'winch.length', 2 - 0.02 * (step - 19))
    elseif step == 100 then
        sim.removeObjects({hook})
    end
end

function sysCall_sensing()
    step = step + 1
    local tension = tatu.read(winch).tension
    if step == 20 or step == 100 then
        assert(math.abs(tension - 98.1) < 0.1, 'the tension is ' .. tension .. ' N')
        local length, expected = 3 - sim.getObjectPosition(hook)[3], step == 20 and 2 or 1.2
        assert(math.abs(length - expected - 98.1 / 2e4) < 1e-4, 'the cable is ' .. length .. ' m long')
    elseif step > 101 then
        assert(tension == 0 and sim.getObjectVelocity(sim.getObject('/crate'))[3] < 0, 'the crate does not fall')
    end
end

function sysCall_cleanup()
    assert(step >= 105, 'the run was too short for the check: 105 steps are needed')
end
