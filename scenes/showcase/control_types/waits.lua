-- Stops a robot once its external driver falls silent: a dead-man's switch.
--
-- A driver sets the integer signal named like the robot, at least every PATIENCE. Each step deletes the signal, so that
-- only a live driver maintains it. A ROS client cannot set signals: rosbridge itself stops the robot when /cmd_vel is
-- silent, and turning wheels indicate that there is a client (`data = { alive = "wheels" }`).

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
    heard = sim.getSimulationTime()     -- s, when the driver was last alive; initially the start
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
