-- Starts the robot. Once it has explored the whole apartment, compares its map with the floor plan, moves the robot
-- back to its start, and restarts it. Raises an error if the map is late, incomplete or wrong. Only the referee knows
-- the plan and the true position.

local plan = require 'apartment_plan'

local APARTMENT = {-2.85, 0.0}        -- m, its middle in the world
local CELL, COLUMNS, ROWS = 0.08, 70, 52
local LEFT, BOTTOM = -2.8, -2.08      -- m, corner of the grid in the apartment's frame

local MAX_TIME = 100.0                -- s, time limit for a map
local PAUSE = 4.0                     -- s between two maps
local LEAST_KNOWN = 0.95              -- fraction of the floor that must be free in the map
local LEAST_TRUE = 0.95               -- fraction of the occupied cells that must be near a wall or furniture
local TOLERANCE = 0.12                -- m: maximum distance of such a cell from the wall or furniture

function sysCall_init()
    robot, graph = sim.getObject('/turtlebot3_burger'), sim.getObject('/Map')
    home = sim.getObjectPose(robot)
    run, judged = 0, math.huge
end

local function start(now)
    run, started, judged = run + 1, now, nil
    sim.resetGraph(graph)
    sim.setInt32Signal('start', run)
end

local function judge(odds)
    local floor, known, occupied, right = 0, 0, 0, 0
    for i, value in ipairs(odds) do
        local x, y = LEFT + ((i - 1) % COLUMNS + 0.5) * CELL, BOTTOM + ((i - 1) // COLUMNS + 0.5) * CELL
        local distance = plan.distance(x, y)
        local inside = math.abs(x) < plan.width / 2 and math.abs(y) < plan.depth / 2
        if inside and distance > CELL then
            floor = floor + 1
            if value < 0 then known = known + 1 end
        end
        if value > 0.5 then
            occupied = occupied + 1
            if math.abs(distance) < TOLERANCE then right = right + 1 end
        end
    end
    return known / floor, right / occupied
end

local function check(now)
    local known, right = judge(sim.unpackFloatTable(sim.getStringSignal('map')))
    print(string.format('map %d after %.0f s: %.1f %% of the floor is known, %.1f %% of the occupied cells are right',
        run, now - started, 100 * known, 100 * right))
    if known < LEAST_KNOWN then error('the map is incomplete') end
    if right < LEAST_TRUE then error('the map is wrong') end
end

local function record()
    local x, known = sim.getFloatSignal('odometry_x'), sim.getFloatSignal('known')
    if not x or judged then return end
    local y, p = sim.getFloatSignal('odometry_y'), sim.getObjectPosition(robot)
    sim.setGraphUserData(graph, 'explored', known)
    sim.setGraphUserData(graph, 'error of odometry',
        math.sqrt((x + APARTMENT[1] - p[1]) ^ 2 + (y + APARTMENT[2] - p[2]) ^ 2))
end

function sysCall_sensing()
    local now = sim.getSimulationTime()
    if run == 0 then return start(now) end
    record()
    if not judged then
        if sim.getInt32Signal('explored') == run then
            judged = now
            check(now)
        elseif now - started > MAX_TIME then
            error('the apartment is not explored in time')
        end
    elseif now - judged > PAUSE then
        sim.setObjectPose(robot, home)
        start(now)
    end
end
