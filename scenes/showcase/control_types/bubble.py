#python
# Method 9, a script in the scene, like method 1, but in Python and in a process of its own: drives ahead, and backwards in
# a curve for a while once the nose detects something. It runs only with --allow python.

AHEAD = 5, 5  # rad/s, left and right wheel
BACK = -2.5, -0.625  # rad/s
BACK_TIME = 3  # s


def sysCall_init():
    sim = require("sim")
    self.left, self.right = sim.getObject(":/leftMotor"), sim.getObject(":/rightMotor")
    self.nose = sim.getObject(":/sensingNose")
    self.back_until = 0  # s


def sysCall_actuation():
    now = sim.getSimulationTime()
    seen, *_ = sim.readProximitySensor(self.nose)
    if seen == 1:
        self.back_until = now + BACK_TIME
    left, right = BACK if now < self.back_until else AHEAD
    sim.setJointTargetVelocity(self.left, left)
    sim.setJointTargetVelocity(self.right, right)
    sim.setInt32Signal("python", 1)  # alive: waits.lua stops the robot without it
