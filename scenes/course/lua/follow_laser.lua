-- Drives ahead until the laser's signal reports an obstacle nearer than 0.6 m, then turns on the spot.

if sim_call_type == sim_childscriptcall_initialization then
    left = simGetObjectHandle('Pioneer_p3dx_leftMotor')
    right = simGetObjectHandle('Pioneer_p3dx_rightMotor')
end

if sim_call_type == sim_childscriptcall_actuation then
    local nearest = simGetFloatSignal('LaserFrontal')
    local turning = nearest and nearest < 0.6
    simSetJointTargetVelocity(left, turning and -1.5 or 2.5)
    simSetJointTargetVelocity(right, turning and 1.5 or 2.5)
end
