#python
# Prints the speeds that a robot publishes as the signals GVLeft and GVRight; nothing before the first ones.


def sysCall_init():
    global sim, console
    sim = require("sim")
    console = sim.auxiliaryConsoleOpen("Speeds", 500, 0)


def sysCall_sensing():
    left, right = sim.getFloatSignal("GVLeft"), sim.getFloatSignal("GVRight")
    if left is not None and right is not None:
        sim.auxiliaryConsolePrint(console, "left %.2f right %.2f\n" % (left, right))
