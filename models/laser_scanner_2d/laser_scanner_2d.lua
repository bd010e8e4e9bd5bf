-- Turns the ray in increments over the scanning angle, and measures at each. The result is published in four ways: a
-- tube with all points in the scanner's frame, a signal with the minimum distance, a graph, and, if named, a file.

local function parameter(name, low, high)
    local value = tonumber(sim.getScriptSimulationParameter(sim.handle_self, name)) or low
    return math.max(low, math.min(high, value))
end

function sysCall_init()
    scanner = sim.getObjectAssociatedWithScript(sim.handle_self)
    laser = sim.getObjectHandle('LaserScannerLaser_2D')
    joint = sim.getObjectHandle('LaserScannerJoint_2D')
    graph = sim.getObjectHandle('LaserScannerGraph_2D')
    tube = sim.tubeOpen(0, sim.getObjectName(scanner) .. '_2D_SCANNER_DATA', 1)
    local name = sim.getScriptSimulationParameter(sim.handle_self, 'log', true) or ''
    if name ~= '' then file = assert(io.open(name, 'w')) end
end

function sysCall_sensing()
    local angle = parameter('scanningAngle', 5, 180)
    local steps = math.floor(angle * parameter('scanningDensity', 0.1, 5) + 0.5)
    local first, step = math.rad(-angle / 2), math.rad(angle) / steps
    local points, least = {}, math.huge
    sim.resetGraph(graph)
    for i = 0, steps do
        sim.setJointPosition(joint, first + i * step)
        local seen, distance, point = sim.handleProximitySensor(laser)
        if seen > 0 then
            point = sim.multiplyVector(sim.getObjectMatrix(laser, scanner), point)
            for k = 1, 3 do points[#points + 1] = point[k] end
            if distance < least then least = distance end
            sim.setGraphUserData(graph, 'x', point[1])
            sim.setGraphUserData(graph, 'y', point[2])
            sim.handleGraph(graph, 0)
        end
    end
    if #points > 0 then
        sim.tubeWrite(tube, sim.packFloatTable(points) or '')
        sim.setFloatSignal('LaserFrontal', least)
    else
        sim.clearFloatSignal('LaserFrontal')
    end
    if file then file:write(string.format('%.2f %.4f %d\n', sim.getSimulationTime(), least, #points / 3)) end
end

function sysCall_cleanup()
    if file then file:close() end
end
