-- The hand's demonstration: closes until the fingers meet or an object is between them, holds, and opens again.
-- The real hand reports only the distance of its fingers, so this script reads nothing else.

local OPEN = 0.04        -- m: position of a finger
local HOLD_TIME = 1.5    -- s
local STILL = 1e-4       -- m: the fingers have stopped when they move less in a step
local TIMEOUT = 2        -- s

local finger

local function go(position)
    sim.setJointTargetPosition(finger, position)
    local stop = sim.getSimulationTime() + TIMEOUT
    local before
    -- The first steps are ignored: the fingers start slowly, because the target is approached smoothly.
    for _ = 1, 4 do sim.step() end
    repeat
        before = sim.getJointPosition(finger)
        sim.step()
    until math.abs(sim.getJointPosition(finger) - before) < STILL or sim.getSimulationTime() > stop
end

function sysCall_init()
    finger = sim.getObject(':/panda_finger_joint1')
end

function sysCall_thread()
    while true do
        go(OPEN)
        sim.wait(HOLD_TIME)
        go(0)
        sim.wait(HOLD_TIME)
    end
end
