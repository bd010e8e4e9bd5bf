"""Writes the meshes of the NXTway-GS: brick, motors, wheels, sensors and cables. All sizes in metres.

    python3 models/balancer/meshes/make.py
"""
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

R, W, TRACK = 0.04, 0.02, 0.14


def lying(mesh):
    """The mesh with its z axis turned to y."""
    return shapes.turned(mesh, "x", -90)


# Wheel: a round motorcycle tyre on a rim with six spokes. The axle is z, the outer face +z.
tyre = [(0.0290, -0.0065), (0.0325, -0.0085), (0.0365, -0.0075), (0.0390, -0.0045), (R, 0.0), (0.0390, 0.0045),
        (0.0365, 0.0075), (0.0325, 0.0085), (0.0290, 0.0065)]
parts = [shapes.revolve(tyre)]
for i in range(26):
    for side in (-1, 1):
        block = shapes.turned(shapes.box(0.0016, 0.0036, 0.0040), "y", -22 * side)
        parts.append(shapes.turned(shapes.moved(block, x=R - 0.0013, z=0.0042 * side), "z", (360 / 26) * i + (6.9 if side > 0 else 0)))
shapes.write("tyre", shapes.merge(*parts), __file__)
rim = [shapes.revolve([(0.0262, -0.0075), (0.0292, -0.0080), (0.0292, 0.0080), (0.0262, 0.0075)])]
for i in range(6):
    rim.append(shapes.turned(shapes.moved(shapes.box(0.020, 0.0060, 0.0075), x=0.0175, z=0.0015), "z", 60 * i))
rim.append(shapes.lathe([(0.0105, -0.0080), (0.0105, 0.0068), (0.0095, 0.0078)], 32))
rim.append(shapes.lathe([(0.0030, 0.0078), (0.0030, 0.0100)], 12))
shapes.write("rim", shapes.merge(*rim), __file__)

# The brick stands upright; its back holds the battery.
shapes.write("brick", shapes.moved(shapes.box(0.030, 0.072, 0.112, 0.004, 0.006), x=0.008, z=0.088), __file__)
shapes.write("back", shapes.merge(
    shapes.moved(shapes.box(0.018, 0.068, 0.108, 0.003, 0.005), x=-0.0145, z=0.088),
    # Sockets above and below, and the beams that hold the motors.
    shapes.moved(shapes.box(0.014, 0.060, 0.006), x=0.006, z=0.1455),
    shapes.moved(shapes.box(0.008, 0.096, 0.008), x=-0.014, z=0.046),
    shapes.moved(shapes.box(0.008, 0.096, 0.008), x=-0.014, z=0.100),
    shapes.moved(shapes.box(0.008, 0.008, 0.026), x=0.012, y=0.020, z=0.150),
    shapes.moved(shapes.box(0.008, 0.008, 0.026), x=0.012, y=-0.020, z=0.150),
    shapes.moved(lying(shapes.lathe([(0.0026, -0.062), (0.0026, 0.062)], 12)), z=0.0),
), __file__)

# A motor on each side: a round head at the axle, a slim arm up along the brick, a gear box at its end.
white, grey, hubs = [], [], []
for side in (-1, 1):
    y = 0.046 * side
    arm = shapes.loft([
        [(x, yy, z) for x, yy in shapes.rounded_rectangle(a, b, min(a, b) * 0.3, 3)]
        for z, a, b in ((0.008, 0.030, 0.018), (0.030, 0.024, 0.017), (0.060, 0.026, 0.018), (0.074, 0.034, 0.020))
    ])
    white.append(shapes.moved(arm, x=-0.004, y=y))
    white.append(shapes.moved(shapes.box(0.040, 0.020, 0.034, 0.005, steps=2), x=-0.002, y=y, z=0.088))
    head = lying(shapes.lathe(shapes.rounded_profile(0.0195, -0.0125, 0.0125, 0.003, 2), 32))
    white.append(shapes.moved(head, y=y))
    grey.append(shapes.moved(lying(shapes.lathe([(0.0150, -0.0150), (0.0150, 0.0150)], 36)), y=y))
    grey.append(shapes.moved(shapes.box(0.028, 0.0215, 0.014, 0.002), x=-0.002, y=y, z=0.106))
    hubs.append(shapes.moved(lying(shapes.lathe([(0.0120, -0.0160), (0.0120, 0.0160)], 36)), y=y))
shapes.write("motor", shapes.merge(*white), __file__)
shapes.write("motor_grey", shapes.merge(*grey), __file__)
shapes.write("hub", shapes.merge(*hubs), __file__)

# The ultrasonic sensor: a bar with two eyes, on top; the gyroscope: a small box.
SX, SZ = 0.010, 0.168
shapes.write("sonar", shapes.merge(
    shapes.moved(shapes.box(0.022, 0.054, 0.018, 0.004), x=SX, z=SZ),
    *[shapes.moved(shapes.turned(shapes.lathe(shapes.rounded_profile(0.0135, -0.008, 0.0150, 0.002, 2), 32), "y", 90), x=SX + 0.004,
                   y=0.0165 * s, z=SZ + 0.001) for s in (-1, 1)],
), __file__)
shapes.write("eyes", shapes.merge(*[
    shapes.moved(shapes.turned(shapes.lathe([(0.0112, 0.0), (0.0112, 0.0158)], 36), "y", 90), x=SX + 0.004, y=0.0165 * s, z=SZ + 0.001)
    for s in (-1, 1)]), __file__)
shapes.write("irises", shapes.merge(*[
    shapes.moved(shapes.turned(shapes.lathe([(0.0060, 0.0), (0.0060, 0.0164)], 24), "y", 90), x=SX + 0.004, y=0.0165 * s, z=SZ + 0.001)
    for s in (-1, 1)]), __file__)
shapes.write("gyro", shapes.box(0.022, 0.020, 0.020, 0.003), __file__)

# Cables: from the gear boxes in a bow to the sockets.
cables = []
for side in (-1, 1):
    path = []
    for i in range(17):
        t = i / 16
        # A cubic curve between four points.
        p = [(-0.014, 0.046 * side, 0.110), (-0.058, 0.058 * side, 0.140), (-0.050, 0.030 * side, 0.188), (0.004, 0.018 * side, 0.146)]
        w = [(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t ** 3]
        path.append(tuple(sum(a * q[k] for a, q in zip(w, p)) for k in range(3)))
    cables.append(shapes.tube(path, 0.0027, 8))
shapes.write("cables", shapes.merge(*cables), __file__)
