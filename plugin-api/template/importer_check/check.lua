-- Checks my_plugin: the blocks of demo.my_plugin exist, at twice the size stated in the file.
local function near(a, b)
    for i = 1, #b do
        if math.abs(a[i] - b[i]) > 1e-9 then return false end
    end
    return true
end

function sysCall_init()
    local box, ball = sim.getObject('/blocks/box'), sim.getObject('/blocks/ball')
    assert(near(sim.getObjectPosition(box), {2, 0, 0.2}), 'the box has the wrong position')
    assert(near(tatu.get(box, 'shape.size'), {0.8, 1.6, 0.4}), 'the box has the wrong size')
    assert(near(sim.getObjectPosition(ball), {2, 0, 0.7}), 'the ball has the wrong position')
    print('my_plugin works: the blocks are there')
    sim.stopSimulation()
end
