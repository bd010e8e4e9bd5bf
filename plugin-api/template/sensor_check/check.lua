-- Checks my_plugin: the reading of a wall 1 m ahead, a change of a parameter, and noise.
local exact, cheap, step, sum, squares = nil, nil, 0, 0, 0

local function near(a, b) return math.abs(a - b) < 1e-6 end

function sysCall_init()
    exact, cheap = sim.getObject('/exact'), sim.getObject('/cheap')
end

function sysCall_sensing()
    step = step + 1
    local r = tatu.read(exact)
    if step == 1 then
        assert(#r.distance == 21 and near(r.distance[11], 1), 'the middle beam does not hit the wall')
        assert(near(r.distance[1], 1 / math.cos(0.5)), 'the first beam measures ' .. r.distance[1])
        assert(near(r.nearest, 1) and near(r.bearing, 0), 'nearest: ' .. r.nearest)
        tatu.set(exact, 'my_plugin.range', 0.5)
    elseif step == 2 then
        assert(r.nearest == 0.5, 'it measures beyond its range: ' .. r.nearest)
    end
    local error = tatu.read(cheap).nearest - 1
    sum, squares = sum + error, squares + error ^ 2
    if step == 100 then
        local sigma = math.sqrt(squares / step)
        assert(math.abs(sum / step) < 0.01 and sigma > 0.01 and sigma < 0.03, 'noise: sigma ' .. sigma)
        print('my_plugin works: the exact sensor measures 1 m, the cheap one has an error of ' .. sigma .. ' m')
        sim.stopSimulation()
    end
end

function sysCall_cleanup()
    assert(step >= 100, 'the run was too short for the check: 100 steps are needed')
end
