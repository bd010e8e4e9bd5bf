-- Referee: reads the true pose of the robot, which the robot does not know. Each flag must be reached in time, and the
-- robot must not touch anything.

local FLAGS = {'/flag_1', '/flag_2', '/flag_3'}
local LIMIT = 60                -- s, from one flag to the next
local NEAR = 0.15               -- m: required distance from the flag, because odometry drifts
local TOUCH = 0.003             -- m: a smaller distance from an obstacle counts as a touch
local EVERY = 0.25              -- s between two measurements

function sysCall_init()
    robot = sim.getObject('/turtlebot3_burger')
    flags = {}
    for i, path in ipairs(FLAGS) do flags[i] = sim.getObject(path) end
    obstacles = sim.getObjectsInTree(sim.getObject('/room'), sim.object_shape_type, 1)
    number, since, next_at, least = 1, 0, 0, math.huge
end

function sysCall_sensing()
    local now = sim.getSimulationTime()
    if now < next_at then return end
    next_at = now + EVERY
    for _, obstacle in ipairs(obstacles) do
        local _, data = sim.checkDistance(robot, obstacle, 0)
        least = math.min(least, data[7])
        if data[7] < TOUCH then error('the robot touches ' .. sim.getObjectAlias(obstacle)) end
    end
    local p, f = sim.getObjectPosition(robot), sim.getObjectPosition(flags[number])
    local off = math.sqrt((p[1] - f[1]) ^ 2 + (p[2] - f[2]) ^ 2)
    if off < NEAR then
        print(string.format('flag %d after %.1f s; obstacles were at least %.3f m away', number, now - since, least))
        number, since, least = number % #flags + 1, now, math.huge
    elseif now - since > LIMIT then
        error(string.format('flag %d was not reached within %d s', number, LIMIT))
    end
end
