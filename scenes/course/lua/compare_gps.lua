-- Drives a bend and prints, each second, the position that the GPS reports and the true position of its antenna. After
-- five seconds, it removes the errors of the GPS, which is impossible with a real one.

if sim_call_type == sim_childscriptcall_initialization then
    left = simGetObjectHandle('Pioneer_p3dx_leftMotor')
    right = simGetObjectHandle('Pioneer_p3dx_rightMotor')
    gps = simGetObjectHandle('GPS')
    antenna = simGetObjectHandle('GPS_reference')
    simSetJointTargetVelocity(left, 1.0)
    simSetJointTargetVelocity(right, 1.6)
    exact, told = false, -1
end

if sim_call_type == sim_childscriptcall_actuation then
    if not exact and simGetSimulationTime() >= 5 then
        exact = true
        local script = simGetScriptAssociatedWithObject(gps)
        for _, what in ipairs({'Noise', 'Shift'}) do
            for _, axis in ipairs({'x', 'y', 'z'}) do
                simSetScriptSimulationParameter(script, axis .. what .. 'Amplitude', '0')
            end
        end
    end
    -- The position that the GPS reported at the end of the last step, and its true position at that time.
    local x, y = simGetFloatSignal('gpsX'), simGetFloatSignal('gpsY')
    local second = math.floor(simGetSimulationTime() + 0.001)
    if x and second ~= told then
        told = second
        local p = simGetObjectPosition(antenna, -1)
        simAddStatusbarMessage(string.format('GPS (%.3f, %.3f) true (%.3f, %.3f) off by %.3f m',
            x, y, p[1], p[2], math.sqrt((x - p[1])^2 + (y - p[2])^2)))
    end
end
