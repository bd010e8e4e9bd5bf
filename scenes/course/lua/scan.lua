-- Turns the laser step by step through half a turn, measures at each step, and tells the result in four ways: a signal
-- with the least distance, a tube with all points, a file, and a graph.

if sim_call_type == sim_childscriptcall_initialization then
    laser = simGetObjectHandle('LaserScannerLaser_2D')
    joint = simGetObjectHandle('LaserScannerJoint_2D')
    graph = simGetObjectHandle('LaserScannerGraph_2D')
    tube = simTubeOpen(0, 'scan', 1)
    file = io.open('scan.log', 'w')
    beams = 91
end

if sim_call_type == sim_childscriptcall_sensing then
    local points, least = {}, 20
    simResetGraph(graph)
    for i = 0, beams - 1 do
        local angle = -math.pi / 2 + math.pi * i / (beams - 1)
        simSetJointPosition(joint, angle)
        local seen, distance = simHandleProximitySensor(laser)
        if seen > 0 then
            least = math.min(least, distance)
            points[#points + 1] = distance * math.cos(angle)
            points[#points + 1] = distance * math.sin(angle)
            simSetGraphUserData(graph, 'x', distance * math.cos(angle))
            simSetGraphUserData(graph, 'y', distance * math.sin(angle))
            simHandleGraph(graph, 0)
        end
    end
    file:write(string.format('%.2f %.4f %d\n', simGetSimulationTime(), least, #points / 2))
    simSetFloatSignal('LaserFrontal', least)
    if #points > 0 then simTubeWrite(tube, simPackFloats(points)) end
end

if sim_call_type == sim_childscriptcall_cleanup then
    file:close()
end
