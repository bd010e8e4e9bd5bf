#python
# Drives a bend and prints, each second, the position that the GPS reports and the true position of its antenna. After
# five seconds, it removes the errors of the GPS, which is impossible with a real one.

import math


def sysCall_init():
    global sim, gps, antenna, exact, told
    sim = require("sim")
    gps = sim.getObject("./GPS")
    antenna = sim.getObject("./GPS_reference")
    sim.setJointTargetVelocity(sim.getObject("./Pioneer_p3dx_leftMotor"), 1.0)
    sim.setJointTargetVelocity(sim.getObject("./Pioneer_p3dx_rightMotor"), 1.6)
    exact, told = False, -1


def sysCall_actuation():
    global exact, told
    if not exact and sim.getSimulationTime() >= 5:
        exact = True
        script = sim.getScriptAssociatedWithObject(gps)
        for what in ("Noise", "Shift"):
            for axis in "xyz":
                sim.setScriptSimulationParameter(script, axis + what + "Amplitude", "0")
    # The position that the GPS reported at the end of the last step, and its true position at that time.
    x, y = sim.getFloatSignal("gpsX"), sim.getFloatSignal("gpsY")
    second = math.floor(sim.getSimulationTime() + 0.001)
    if x is not None and second != told:
        told = second
        p = sim.getObjectPosition(antenna, -1)
        off = math.hypot(x - p[0], y - p[1])
        sim.addStatusbarMessage("GPS (%.3f, %.3f) true (%.3f, %.3f) off by %.3f m" % (x, y, p[0], p[1], off))
