-- Compares odometry and GPS with the true position, which only a referee can read; records both errors, draws the true
-- path, and raises an error if the robot leaves the line or the errors are not what the scene is meant to show.

local AXLE = 0.0445                   -- m, from the Pioneer's base to its axle, to which odometry and antenna refer
local STRAIGHT, RADIUS = 6.0, 2.5     -- m, of the course
local MAX_OFFSET = 0.30               -- m, maximum distance from the line
local MAX_LAP = 40.0                  -- s
local LAPS = 3
local LEAST_DRIFT = 0.1               -- m; with two equal tyres, it is 0.3 m
local MAX_GPS = 1.0                   -- m, maximum root mean square error of the GPS over all laps

local GREEN = {0.30, 0.85, 0.35}

function sysCall_init()
    robot, gps = sim.getObject('/Pioneer_p3dx'), sim.getObject('/gps')
    graph = sim.getObject('/Error')
    trail = sim.addDrawingObject(sim.drawing_lines, 3, 0, -1, 0, GREEN)
    lap, lap_start, fix = 0, 0, 0
end

local function new_run()
    sim.addDrawingObjectItem(trail, nil)
    sim.resetGraph(graph)
    worst, squares, fixes = 0, 0, 0
    drawn_x = nil
end

local function true_position()
    local m = sim.getObjectMatrix(robot, sim.handle_world)
    return m[4] + AXLE * m[1], m[8] + AXLE * m[5]
end

-- Returns the distance (m) from the line: two straights, joined by two semicircles.
local function offset(x, y)
    local beyond = math.max(0, math.abs(x) - STRAIGHT / 2)
    return math.abs(math.sqrt(beyond * beyond + y * y) - RADIUS)
end

local function judge()
    local rms = math.sqrt(squares / fixes)
    print(string.format('%d laps: odometry was off by up to %.2f m, GPS by %.2f m (root mean square)',
        LAPS, worst, rms))
    if worst < LEAST_DRIFT then error('the odometry has not drifted') end
    if rms > MAX_GPS then error('the GPS is worse than it should be') end
end

local function watch_laps(now)
    local current = sim.getInt32Signal('lap') or 0
    if current ~= lap then
        if lap == LAPS then judge() end
        lap, lap_start = current, now
        if lap == 1 then new_run() end
    elseif now - lap_start > MAX_LAP then
        error('lap ' .. lap .. ' is not finished in time')
    end
end

local function record(x, y)
    local ox, oy = sim.getFloatSignal('odometry_x'), sim.getFloatSignal('odometry_y')
    local off = math.sqrt((ox - x) ^ 2 + (oy - y) ^ 2)
    worst = math.max(worst, off)
    -- The error of a fix is computed at the time of measurement, and held until the next fix.
    local reading = tatu.read(gps)
    if reading.sequence ~= fix and reading.valid == 1 then
        fix = reading.sequence
        gps_off = math.sqrt((reading.position[1] - x) ^ 2 + (reading.position[2] - y) ^ 2)
        squares, fixes = squares + gps_off ^ 2, fixes + 1
    end
    sim.setGraphUserData(graph, 'odometry', off)
    if gps_off then sim.setGraphUserData(graph, 'GPS', gps_off) end
    sim.setGraphUserData(graph, 'true x', x)
    sim.setGraphUserData(graph, 'true y', y)
    sim.setGraphUserData(graph, 'odometry x', ox)
    sim.setGraphUserData(graph, 'odometry y', oy)
end

function sysCall_sensing()
    watch_laps(sim.getSimulationTime())
    if lap == 0 then return end
    local x, y = true_position()
    if offset(x, y) > MAX_OFFSET then error('the robot has left the line') end
    record(x, y)
    if drawn_x and math.abs(x - drawn_x) + math.abs(y - drawn_y) > 0.1 then
        sim.addDrawingObjectItem(trail, {drawn_x, drawn_y, 0.02, x, y, 0.02})
    elseif drawn_x then
        return
    end
    drawn_x, drawn_y = x, y
end
