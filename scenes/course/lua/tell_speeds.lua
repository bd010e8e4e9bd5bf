-- Avoids obstacles, and publishes the speeds of its wheels as two signals: GVLeft and GVRight, rad/s.

if sim_call_type == sim_childscriptcall_initialization then
    sonars = {}
    for i = 1, 16 do
        sonars[i] = simGetObjectHandle('Pioneer_p3dx_ultrasonicSensor' .. i)
    end
    left = simGetObjectHandle('Pioneer_p3dx_leftMotor')
    right = simGetObjectHandle('Pioneer_p3dx_rightMotor')
    cruise = 2              -- rad/s of both wheels with nothing in sight
    near, far = 0.2, 0.6    -- m: full reaction within, none beyond
end

if sim_call_type == sim_childscriptcall_actuation then
    -- Weights of the front sonars, left (1) to right (8): those ahead count most; each slows the opposite wheel.
    local push = {0, 0}
    for i = 1, 8 do
        local seen, distance = simReadProximitySensor(sonars[i])
        if seen > 0 and distance < far then
            local nearness = math.min(1, (far - distance) / (far - near))
            local side = i <= 4 and 2 or 1
            push[side] = push[side] + nearness * (i <= 4 and i or 9 - i) * 0.5
        end
    end
    -- Slightly more on one side, so that the robot does not stop in front of an obstacle straight ahead.
    speed_left, speed_right = cruise - push[1] * 1.1, cruise - push[2]
    simSetJointTargetVelocity(left, speed_left)
    simSetJointTargetVelocity(right, speed_right)
    simSetFloatSignal('GVLeft', speed_left)
    simSetFloatSignal('GVRight', speed_right)
end
