-- The referee: reads the true pose of the trunk, records tilt and height, and raises an error if the robot falls or
-- takes too long from one end of the course to the other.

local ENDS = {3.6, 0.4}          -- m: x of the trunk from which the far and the near end count as reached
local TIME_MOST = 28             -- s: time limit from one end to the other, including the turn
local TILT_MOST = math.rad(35)

local robot, graph, streams
local going, since, ways = 1, 0, 0

function sysCall_init()
    robot = sim.getObject('/go1')
    graph = sim.getObject('/walk')
    streams = {sim.addGraphStream(graph, 'tilt', 'deg'), sim.addGraphStream(graph, 'height of the trunk', 'm')}
end

function sysCall_sensing()
    local now, m = sim.getSimulationTime(), sim.getObjectMatrix(robot)
    local tilt = math.acos(math.max(-1, math.min(1, m[11])))
    sim.setGraphStreamValue(graph, streams[1], math.deg(tilt))
    sim.setGraphStreamValue(graph, streams[2], m[12])
    if tilt > TILT_MOST then error(string.format('the robot has fallen at x = %.2f m after %.1f s', m[4], now)) end
    if going == 1 and m[4] > ENDS[1] or going == 2 and m[4] < ENDS[2] then
        ways = ways + 1
        print(string.format('way %d ends after %.1f s', ways, now))
        going, since = 3 - going, now
    end
    if now - since > TIME_MOST then
        error(string.format('way %d has taken more than %d s: x = %.2f m', ways + 1, TIME_MOST, m[4]))
    end
end
