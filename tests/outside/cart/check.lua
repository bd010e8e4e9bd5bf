-- Checks the model `cart`: two seconds straight ahead at 0.3 m/s, then two seconds of turning at 0.5 rad/s.
local me, step, from, height, left = nil, 0, nil, nil, nil

function sysCall_init()
    me = sim.getObject('..')
    left = sim.getObject('./left_motor')
    height = sim.getObjectPosition(me)[3]
    assert(height == tatu.get(me, 'object.drive').radius)
end

function sysCall_actuation()
    step = step + 1
    local p, e = sim.getObjectPosition(me), sim.getObjectOrientation(me)
    if step == 11 then                               -- the cart has come to rest
        assert(math.abs(p[1]) < 0.005 and math.abs(p[3] - height) < 0.005, p[1] .. ' ' .. p[3])
        assert(math.abs(e[1]) < 0.01 and math.abs(e[2]) < 0.01)
        from = p
        tatu.drive(me, 0.3, 0, 0)
    elseif step == 31 then
        assert(math.abs(sim.getJointVelocity(left) - 0.3 / height) < 0.05 / height)
    elseif step == 51 then
        print(sim.getObjectAlias(me), 'went', p[1] - from[1], 'beside', p[2] - from[2])
        assert(math.abs(p[1] - from[1] - 0.6) < 0.03 and math.abs(p[2] - from[2]) < 0.01)
        tatu.drive(me, 0, 0, 0.5)
        from = e
    elseif step == 91 then
        print(sim.getObjectAlias(me), 'turned', e[3] - from[3])
        assert(math.abs(e[3] - from[3] - 1) < 0.06)
        done = true
        tatu.drive(me, 0, 0, 0)
    end
end

function sysCall_cleanup() assert(done, 'too few steps') end
