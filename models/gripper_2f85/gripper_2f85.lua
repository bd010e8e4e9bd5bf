-- Opens and closes the gripper every two seconds while it is not mounted on an arm.
--
-- On an arm, this script does nothing: the controller of the arm commands the driven joint,
--     sim.setJointTargetPosition(sim.getObject('/robotiq_85_base_link/robotiq_85_left_knuckle_joint'), angle)
-- where 0 opens the gripper and 0.793 rad leaves 1 mm between the pads.

local OPEN, CLOSED = 0, 0.793    -- angle of the driven joint, rad
local PAUSE = 2                  -- time between commands, s

function sysCall_thread()
    if sim.getObjectParent(sim.getObject(':')) ~= -1 then return end
    local joint = sim.getObject(':/robotiq_85_left_knuckle_joint')
    while true do
        for _, angle in ipairs{CLOSED, OPEN} do
            sim.setJointTargetPosition(joint, angle)
            sim.wait(PAUSE)
        end
    end
end
