#python
# Drives a Manta by keys: up and down change the speed of the wheels by 1 rad/s, left and right the steering by 6
# degrees, the space bar stops. Each key is printed on the status bar.

import math


def sysCall_init():
    global sim, steering, motor, speed, angle
    sim = require("sim")
    steering = sim.getObject("./steer_joint")
    motor = sim.getObject("./motor_joint")
    speed, angle = 10, 0


def next_message():
    # Without a message, the command returns only -1.
    found = sim.getSimulatorMessage()
    return found[:2] if isinstance(found, tuple) else (found, None)


def sysCall_actuation():
    global speed, angle
    step, most = math.radians(6), math.radians(30)
    message, data = next_message()
    while message != -1:
        if message == sim.message_keypress:
            key = data[0]
            if key == 2007:
                speed = min(speed + 1, 10)
            elif key == 2008:
                speed = max(speed - 1, -3)
            elif key == 2009:
                angle = min(angle + step, most)
            elif key == 2010:
                angle = max(angle - step, -most)
            elif key == ord(" "):
                speed = 0
            sim.addStatusbarMessage("key %d: %g rad/s, %.0f degrees" % (key, speed, math.degrees(angle)))
        message, data = next_message()
    sim.setJointTargetPosition(steering, angle)
    sim.setJointTargetForce(motor, 60)
    sim.setJointTargetVelocity(motor, speed)
