-- Checks bubble: the robot drives ahead, detects the wall, and backs up for 3 s.
function sysCall_init()
    left, right, nose = sim.getObject(':/leftMotor'), sim.getObject(':/rightMotor'), sim.getObject(':/sensingNose')
    steps_back, done = 0, false
end

function sysCall_actuation()
    local backing = bubble.drive(left, right, nose)
    assert(sim.getJointTargetVelocity(left) == (backing and -2.5 or 5), 'the left wheel has another speed')
    assert(sim.getJointTargetVelocity(right) == (backing and -0.625 or 5), 'the right wheel has another speed')
    if backing then steps_back = steps_back + 1 end
    if steps_back > 0 and not backing then
        local seconds = steps_back * sim.getSimulationTimeStep()
        assert(seconds >= 3 and seconds < 5, 'it backed up for ' .. seconds .. ' s')
        print('bubble works: the robot backed up for ' .. seconds .. ' s')
        done = true
        sim.stopSimulation()
        sysCall_actuation = nil
    end
end

function sysCall_cleanup()
    assert(done, 'the run was too short for the check: the robot has not backed up')
end
