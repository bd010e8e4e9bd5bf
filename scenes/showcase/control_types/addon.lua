-- Drives the robot /addon of control_types.toml: method 2, an add-on.
--
--     tatu run control_types.toml --realtime --addon control_types/addon.lua
--
-- An add-on belongs to the program, not to the scene: it drives the robot with this name in any scene.

local ROBOT = '/addon'
local AHEAD = {5, 5}                -- rad/s, left and right wheel
local BACK = {-2.5, -0.625}         -- rad/s
local BACK_TIME = 3                 -- s

function sysCall_info()
    return {autoStart = false}
end

local left, right, nose, back_until

function sysCall_beforeSimulation()
    left, right = sim.getObject(ROBOT .. '/leftMotor'), sim.getObject(ROBOT .. '/rightMotor')
    nose = sim.getObject(ROBOT .. '/sensingNose')
    back_until = 0                  -- s
end

function sysCall_actuation()
    local now = sim.getSimulationTime()
    if sim.readProximitySensor(nose) == 1 then back_until = now + BACK_TIME end
    local wheels = now < back_until and BACK or AHEAD
    sim.setJointTargetVelocity(left, wheels[1])
    sim.setJointTargetVelocity(right, wheels[2])
    sim.setInt32Signal('addon', 1)  -- alive: waits.lua stops the robot without it
end
