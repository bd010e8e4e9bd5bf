-- Checks the robot my_plugin: it drives straight at 0.3 m/s for 2 s, then turns at 0.5 rad/s for 2 s.
local me, left, step, from = nil, nil, 0, nil

function sysCall_init()
    me, left = sim.getObject('..'), sim.getObject('./left_motor')
    assert(tatu.get(me, 'object.drive').radius == 0.12, 'the wheels have the wrong radius')
end

function sysCall_actuation()
    step = step + 1
    local p, e = sim.getObjectPosition(me), sim.getObjectOrientation(me)
    if step == 11 then -- the robot is at rest
        assert(math.abs(p[1]) < 0.005 and math.abs(p[3] - 0.12) < 0.005, 'the robot does not stand on the floor')
        assert(math.abs(e[1]) < 0.01 and math.abs(e[2]) < 0.01, 'the robot leans')
        from = p
        tatu.drive(me, 0.3, 0, 0)
    elseif step == 51 then
        assert(math.abs(p[1] - from[1] - 0.6) < 0.03, 'it went ' .. p[1] - from[1] .. ' m, not 0.6 m')
        assert(math.abs(p[2] - from[2]) < 0.01, 'the robot did not drive straight')
        tatu.drive(me, 0, 0, 0.5)
        from = e
    elseif step == 91 then
        assert(math.abs(e[3] - from[3] - 1) < 0.06, 'it turned by ' .. e[3] - from[3] .. ' rad, not by 1 rad')
        print('my_plugin works: it drives straight, and turns')
        sim.stopSimulation()
    end
end

function sysCall_cleanup()
    assert(step >= 91, 'the run was too short for the check: 91 steps are needed')
end
