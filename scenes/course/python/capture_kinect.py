#python
# Prints the depth in the middle of the image each second. At each key `w`, saves the images of the Kinect: the
# colours, and the depths as grey, black near and white far.

import math


def sysCall_init():
    global sim, depth, rgb, resolution, near, far, pictures, told
    sim = require("sim")
    depth = sim.getObject("./kinect_depth")
    rgb = sim.getObject("./kinect_rgb")
    resolution = sim.getVisionSensorResolution(depth)
    near, far = 0.01, 3.5
    pictures, told = 0, -1


def next_message():
    # Without a message, the command returns only -1.
    found = sim.getSimulatorMessage()
    return found[:2] if isinstance(found, tuple) else (found, None)


def sysCall_sensing():
    global pictures, told
    wanted = False
    message, data = next_message()
    while message != -1:
        wanted = wanted or (message == sim.message_keypress and data[0] == ord("w"))
        message, data = next_message()

    second = math.floor(sim.getSimulationTime() + 0.001)
    if second != told:
        told = second
        x, y = resolution[0] // 2, resolution[1] // 2
        value = sim.getVisionSensorDepthBuffer(depth, x, y, 1, 1)[0]
        sim.addStatusbarMessage("the middle is %.3f m away" % (near + value * (far - near)))

    if wanted:
        pictures += 1
        name = "kinect_%d" % pictures
        image = sim.getVisionSensorCharImage(rgb)
        sim.saveImage(image[0] if isinstance(image, tuple) else image, resolution, 0, name + "_rgb.png", -1)
        levels = (math.floor(value * 255 + 0.5) for value in sim.getVisionSensorDepthBuffer(depth))
        grey = b"".join(bytes([level]) * 3 for level in levels)
        sim.saveImage(grey, resolution, 0, name + "_depth.png", -1)
        sim.addStatusbarMessage("saved " + name)
