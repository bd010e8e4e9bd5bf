-- Compares odometry, GPS and filter with the true position, which only a referee can read. Records the three errors,
-- and raises an error if the filter is not better than both others over a run of two eights.

local AXLE = 0.0445                   -- m, from the Pioneer's base ahead to its axle, to which all estimates refer
local MAX_RUN = 80.0                  -- s
local MAX_EKF = 1.0                   -- m, maximum root mean square error

local GREEN = {0.30, 0.85, 0.35}

local Mean = {}                       -- root mean square of errors
Mean.__index = Mean

function Mean.new() return setmetatable({sum = 0, count = 0}, Mean) end

function Mean:add(off)
    self.sum, self.count = self.sum + off * off, self.count + 1
end

function Mean:get() return math.sqrt(self.sum / self.count) end

function sysCall_init()
    robot, gps = sim.getObject('/Pioneer_p3dx'), sim.getObject('/gps')
    graph = sim.getObject('/Error')
    trail = sim.addDrawingObject(sim.drawing_lines, 3, 0, -1, 0, GREEN)
    run, run_start, fix = 0, 0, 0
end

local function true_position()
    local m = sim.getObjectMatrix(robot, sim.handle_world)
    return m[4] + AXLE * m[1], m[8] + AXLE * m[5]
end

local function begin_run(now)
    run_start, drawn = now, nil
    odometry, fixes, ekf = Mean.new(), Mean.new(), Mean.new()
    sim.addDrawingObjectItem(trail, nil)
    sim.resetGraph(graph)
end

local function judge()
    print(string.format('root mean square errors: odometry %.2f m, GPS %.2f m, EKF %.2f m',
        odometry:get(), fixes:get(), ekf:get()))
    if ekf:get() > odometry:get() then error('the filter is worse than the odometry') end
    if ekf:get() > fixes:get() then error('the filter is worse than the GPS') end
    if ekf:get() > MAX_EKF then error('the filter is off by too much') end
end

local function distance(name, x, y)
    local ex, ey = sim.getFloatSignal(name .. '_x'), sim.getFloatSignal(name .. '_y')
    return math.sqrt((ex - x) ^ 2 + (ey - y) ^ 2), ex, ey
end

local function record(x, y)
    local off = distance('odometry', x, y)
    odometry:add(off)
    sim.setGraphUserData(graph, 'odometry', off)
    local ekf_off, ekf_x, ekf_y = distance('ekf', x, y)
    ekf:add(ekf_off)
    sim.setGraphUserData(graph, 'EKF', ekf_off)

    local reading = tatu.read(gps)
    if reading.sequence ~= fix then
        fix = reading.sequence
        fix_off = nil                 -- without a fix, the graph has a gap
        if reading.valid == 1 then
            fix_off = math.sqrt((reading.position[1] - x) ^ 2 + (reading.position[2] - y) ^ 2)
            fixes:add(fix_off)
        end
    end
    if fix_off then sim.setGraphUserData(graph, 'GPS', fix_off) end

    sim.setGraphUserData(graph, 'true x', x)
    sim.setGraphUserData(graph, 'true y', y)
    sim.setGraphUserData(graph, 'EKF x', ekf_x)
    sim.setGraphUserData(graph, 'EKF y', ekf_y)
end

function sysCall_sensing()
    local now = sim.getSimulationTime()
    local current = sim.getInt32Signal('run') or 0
    if current ~= run then
        if run > 0 then judge() end
        run = current
        begin_run(now)
    elseif now - run_start > MAX_RUN then
        error('the robot has not finished its eights in time')
    end
    if run == 0 then return end
    local x, y = true_position()
    record(x, y)
    if not drawn or math.abs(x - drawn[1]) + math.abs(y - drawn[2]) > 0.08 then
        if drawn then sim.addDrawingObjectItem(trail, {drawn[1], drawn[2], 0.02, x, y, 0.02}) end
        drawn = {x, y}
    end
end
