-- Drives the robot. Set the speeds of the wheels, rad/s, from what the sensors measure.
-- Conduz o robô: defina as velocidades das rodas, em rad/s, a partir do que os sensores medem.

function sysCall_init()
    left = sim.getObject('./Pioneer_p3dx_leftMotor')
    right = sim.getObject('./Pioneer_p3dx_rightMotor')
end

-- Returns the measured position, m. / Devolve a posição medida, em m.
local function position()
    local x, y = sim.getFloatSignal('gpsX'), sim.getFloatSignal('gpsY')
    return x, y
end

function sysCall_actuation()
    local x, y = position()
    sim.setJointTargetVelocity(left, 0)
    sim.setJointTargetVelocity(right, 0)
end
