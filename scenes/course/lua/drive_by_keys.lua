-- Drives a Manta by keys: up and down change the speed of the wheels by 1 rad/s, left and right the steering by 6
-- degrees, the space bar stops. Each key is printed on the status bar.

if sim_call_type == sim_childscriptcall_initialization then
    steering = simGetObjectHandle('steer_joint')
    motor = simGetObjectHandle('motor_joint')
    speed, angle = 10, 0
    step, most = math.rad(6), math.rad(30)
end

if sim_call_type == sim_childscriptcall_actuation then
    local message, data = simGetSimulatorMessage()
    while message ~= -1 do
        if message == sim_message_keypress then
            local key = data[1]
            if key == 2007 then speed = math.min(speed + 1, 10) end
            if key == 2008 then speed = math.max(speed - 1, -3) end
            if key == 2009 then angle = math.min(angle + step, most) end
            if key == 2010 then angle = math.max(angle - step, -most) end
            if key == string.byte(' ') then speed = 0 end
            simAddStatusbarMessage(string.format('key %d: %g rad/s, %.0f degrees', key, speed, math.deg(angle)))
        end
        message, data = simGetSimulatorMessage()
    end
    simSetJointTargetPosition(steering, angle)
    simSetJointForce(motor, 60)
    simSetJointTargetVelocity(motor, speed)
end
