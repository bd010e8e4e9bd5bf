--- sim.getPathLengths
local lengths, total = sim.getPathLengths({0, 0, 3, 4, 3, 5}, 2)
assert(total == 6 and lengths[2] == 5)
--- sim.getPathInterpolatedConfig
local path = {0, 0, 3, 4}
local at = sim.getPathInterpolatedConfig(path, sim.getPathLengths(path, 2), 2.5)
assert(at[1] == 1.5 and at[2] == 2)
--- sim.resamplePath
local path = {0, 0, 4, 0}
local even = sim.resamplePath(path, sim.getPathLengths(path, 2), 5)
assert(#even == 10 and even[3] == 1)
--- sim.getClosestPosOnPath
local path = {0, 0, 0, 4, 0, 0}
assert(sim.getClosestPosOnPath(path, sim.getPathLengths(path, 3), {1, 2, 0}) == 1)
--- sim.getConfigDistance
assert(sim.getConfigDistance({0, 0}, {3, 4}) == 5)
--- sim.createPath
local p = sim.createPath({0, 0, 0, 0, 0, 0, 1, 2, 0, 0, 0, 0, 0, 1})
assert(sim.getPathLength(p) == 2)
--- sim.insertPathCtrlPoints
local p = sim.createPath(-1)
sim.insertPathCtrlPoints(p, 0, 0, 2, {0,0,0, 0,0,0, 1,0,1,0.5,0.5, 0,0,3, 0,0,0, 1,0,1,0.5,0.5})
assert(sim.getPathLength(p) == 3)
--- sim.cutPathCtrlPoints
local p = sim.createPath({0, 0, 0, 0, 0, 0, 1, 2, 0, 0, 0, 0, 0, 1})
sim.cutPathCtrlPoints(p, 1, 1)
assert(sim.getPathLength(p) == 0)
--- sim.getPositionOnPath
local p = sim.createPath({0, 0, 0, 0, 0, 0, 1, 2, 0, 0, 0, 0, 0, 1})
sim.setObjectPosition(p, {0, 0, 1})
local at = sim.getPositionOnPath(p, 0.25)
assert(at[1] == 0.5 and at[3] == 1)
--- sim.getOrientationOnPath
local p = sim.createPath({0, 0, 0, 0, 0, 0, 1, 2, 0, 0, 0, 0, 1, 0})
assert(math.abs(sim.getOrientationOnPath(p, 0.5)[3] - math.pi / 2) < 1e-6)
--- sim.getPathLength
local p = sim.createPath({0, 0, 0, 0, 0, 0, 1, 3, 4, 0, 0, 0, 0, 1}, 2)
assert(sim.getPathLength(p) == 10)
--- sim.getPathPosition
assert(sim.getPathPosition(sim.createPath(-1)) == 0)
--- sim.setPathPosition
local p = sim.createPath(-1)
sim.setPathPosition(p, 0.5)
assert(sim.getPathPosition(p) == 0.5)
--- sim.getClosestPositionOnPath
local p = sim.createPath({0, 0, 0, 0, 0, 0, 1, 2, 0, 0, 0, 0, 0, 1})
assert(sim.getClosestPositionOnPath(p, {0.5, 1, 0}) == 0.25)
--- sim.followPath
function sysCall_thread()
    local p = sim.createPath({0, 0, 0, 0, 0, 0, 1, 0.2, 0, 0, 0, 0, 0, 1})
    local d = sim.createDummy(0.01)
    sim.followPath(d, p, 3, 0, 2, 0)
    assert(math.abs(sim.getObjectPosition(d)[1] - 0.2) < 1e-9)
end
