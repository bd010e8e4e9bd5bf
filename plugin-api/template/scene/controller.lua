-- Drives forward, and turns right while an obstacle is near.
local left, right, sonars

function sysCall_init()
    left = sim.getObject('./Pioneer_p3dx_leftMotor')
    right = sim.getObject('./Pioneer_p3dx_rightMotor')
    sonars = {}
    for i = 2, 7 do
        sonars[#sonars + 1] = sim.getObject('./Pioneer_p3dx_ultrasonicSensor' .. i)
    end
end

function sysCall_actuation()
    local near = false
    for _, sonar in ipairs(sonars) do
        local seen, distance = sim.readProximitySensor(sonar)
        if seen == 1 and distance < 0.5 then near = true end
    end
    sim.setJointTargetVelocity(left, 2)
    sim.setJointTargetVelocity(right, near and -2 or 2)
end
