-- Stops a robot whose driver is outside of the scene, once that is silent: a dead-man's switch.
--
-- A driver sets the integer signal that is called as the robot, at least every PATIENCE. Each step deletes it, so that
-- only a living driver keeps it. A ROS client cannot set signals: rosbridge stops its robot itself when /cmd_vel is
-- silent, and wheels that turn show that there is a client (`data = { alive = "wheels" }`).

local note = require 'note'

local PATIENCE = 1.0                -- s

function sysCall_init()
    robot = sim.getObject('..')
    left, right = sim.getObject(':/leftMotor'), sim.getObject(':/rightMotor')
    signal = sim.getObjectAlias(robot)
    by_wheels = sim.readCustomStringData(robot, 'alive') == 'wheels'
    missing = sim.readCustomStringData(robot, 'missing')
    if missing == '' then missing = 'NO CLIENT' end
    help = sim.readCustomStringData(robot, 'start')
    heard = sim.getSimulationTime()     -- s, when the driver was last alive; the start counts, too
end

local function alive()
    if by_wheels then return sim.getJointTargetVelocity(left) ~= 0 or sim.getJointTargetVelocity(right) ~= 0 end
    local set = sim.getInt32Signal(signal) ~= nil
    if set then sim.clearInt32Signal(signal) end
    return set
end

function sysCall_actuation()
    local now = sim.getSimulationTime()
    if alive() then heard = now end
    if now - heard <= PATIENCE then
        note.hide(robot)
    else
        sim.setJointTargetVelocity(left, 0)
        sim.setJointTargetVelocity(right, 0)
        note.show(robot, missing, help)
    end
end
