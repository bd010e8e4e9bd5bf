#python
# Avoids obstacles, and publishes the speeds of its wheels as two signals: GVLeft and GVRight, rad/s.


def sysCall_init():
    global sim, sonars, left, right, cruise, near, far
    sim = require("sim")
    sonars = [sim.getObject("./Pioneer_p3dx_ultrasonicSensor%d" % i) for i in range(1, 17)]
    left = sim.getObject("./Pioneer_p3dx_leftMotor")
    right = sim.getObject("./Pioneer_p3dx_rightMotor")
    cruise = 2              # rad/s of both wheels with nothing in sight
    near, far = 0.2, 0.6    # m: full reaction within, none beyond


def sysCall_actuation():
    # Weights of the front sonars, left (0) to right (7): those ahead count most; each slows the opposite wheel.
    push = [0, 0]
    for i in range(8):
        seen, distance, *_ = sim.readProximitySensor(sonars[i])
        if seen > 0 and distance < far:
            nearness = min(1, (far - distance) / (far - near))
            side = 1 if i < 4 else 0
            push[side] += nearness * (i + 1 if i < 4 else 8 - i) * 0.5
    # Slightly more on one side, so that the robot does not stop in front of an obstacle straight ahead.
    speed_left, speed_right = cruise - push[0] * 1.1, cruise - push[1]
    sim.setJointTargetVelocity(left, speed_left)
    sim.setJointTargetVelocity(right, speed_right)
    sim.setFloatSignal("GVLeft", speed_left)
    sim.setFloatSignal("GVRight", speed_right)
