#python
# Drives ahead until the laser's signal reports an obstacle nearer than 0.6 m, then turns on the spot.


def sysCall_init():
    global sim, left, right
    sim = require("sim")
    left = sim.getObject("./Pioneer_p3dx_leftMotor")
    right = sim.getObject("./Pioneer_p3dx_rightMotor")


def sysCall_actuation():
    nearest = sim.getFloatSignal("LaserFrontal")
    turning = nearest is not None and nearest < 0.6
    sim.setJointTargetVelocity(left, -1.5 if turning else 2.5)
    sim.setJointTargetVelocity(right, 1.5 if turning else 2.5)
