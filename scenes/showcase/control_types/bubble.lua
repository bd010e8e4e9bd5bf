-- Method 1, a script in the scene: drives ahead, and backwards in a curve for a while once the nose detects something.
--
-- All methods in this folder implement the same behaviour, with the same constants.

local AHEAD = {5, 5}                -- rad/s, left and right wheel
local BACK = {-2.5, -0.625}         -- rad/s
local BACK_TIME = 3                 -- s

function sysCall_init()
    left, right, nose = sim.getObject(':/leftMotor'), sim.getObject(':/rightMotor'), sim.getObject(':/sensingNose')
    back_until = 0                  -- s
end

function sysCall_actuation()
    local now = sim.getSimulationTime()
    if sim.readProximitySensor(nose) == 1 then back_until = now + BACK_TIME end
    local wheels = now < back_until and BACK or AHEAD
    sim.setJointTargetVelocity(left, wheels[1])
    sim.setJointTargetVelocity(right, wheels[2])
end
