local elbow
function sysCall_init() elbow = sim.getObject('/elbow') end

local ended = sysCall_cleanup
function sysCall_cleanup()
    if ended then ended() end
    print(string.format('elbow %.9f', sim.getJointPosition(elbow)))
end
