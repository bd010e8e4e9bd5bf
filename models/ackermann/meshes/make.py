"""Writes the meshes of the race car: wheels, chassis, bumpers, deck, suspension and scanner. All sizes in metres.

    python3 models/ackermann/meshes/make.py
"""
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

WHEELBASE, TRACK, R, W = 0.3302, 0.245, 0.05, 0.045


# Tyre: rounded shoulders and three rows of blocks. The axle is z, the outer face +z.
loop = [(0.031, -W / 2 + 0.004), (0.036, -W / 2), (0.0440, -W / 2 + 0.001), (0.0475, -W / 2 + 0.006), (0.0480, 0.0),
        (0.0475, W / 2 - 0.006), (0.0440, W / 2 - 0.001), (0.036, W / 2), (0.031, W / 2 - 0.004)]
tyre = [shapes.revolve(loop)]
for i in range(20):
    for row in (-1, 0, 1):
        block = shapes.moved(shapes.box(0.0032, 0.0068, 0.010), x=R - 0.0017, z=0.0128 * row)
        if row:
            block = shapes.moved(block, x=-0.0004)
        tyre.append(shapes.turned(block, "z", 18 * i + (9 if row == 0 else 0)))
shapes.write("tyre", shapes.merge(*tyre), __file__)

# Rim: a barrel, a dished centre, five double spokes, a nut.
rim = [shapes.revolve([(0.0275, -W / 2 + 0.004), (0.0312, -W / 2 + 0.003), (0.0312, W / 2 - 0.003), (0.0330, W / 2 - 0.0015),
                (0.0300, W / 2 - 0.001), (0.0275, W / 2 - 0.004)])]
for i in range(5):
    for side in (-1, 1):
        spoke = shapes.turned(shapes.box(0.022, 0.0034, 0.005), "y", 8)
        spoke = shapes.turned(shapes.moved(spoke, x=0.0185, y=0.0034 * side, z=W / 2 - 0.0085), "z", 72 * i)
        rim.append(spoke)
rim.append(shapes.moved(shapes.lathe(shapes.rounded_profile(0.0100, -0.012, 0.004, 0.0015, 2), 32), z=W / 2 - 0.0115))
rim.append(shapes.moved(shapes.lathe([(0.0045, 0.0), (0.0045, 0.006)], 6), z=W / 2 - 0.0085))
shapes.write("rim", shapes.merge(*rim), __file__)

# Chassis: a tub that narrows between the wheels, built as a loft of rounded sections from the rear to the front.
def section(x, half, low, high, corner=0.010):
    """A rounded section across x, counter-clockwise seen from the front."""
    shape = shapes.rounded_rectangle(2 * half, high - low, min(corner, half - 1e-3, (high - low) / 2 - 1e-3), 4)
    return [(x, y, z + (low + high) / 2) for y, z in shape]


tub = shapes.loft([
    section(-0.070, 0.030, -0.018, 0.014), section(-0.055, 0.042, -0.024, 0.020), section(0.045, 0.046, -0.026, 0.022),
    section(0.080, 0.088, -0.027, 0.014), section(0.120, 0.094, -0.027, 0.012), section(0.190, 0.092, -0.027, 0.012),
    section(0.235, 0.084, -0.027, 0.014), section(0.270, 0.044, -0.026, 0.020), section(0.370, 0.040, -0.022, 0.016),
    section(0.392, 0.030, -0.016, 0.008),
])
shapes.write("chassis", tub, __file__)

# Front bumper: a curved bar of foam with its mount; rear: a short bar.
FRONT, REAR = 0.17145 + 0.29 - 0.012, 0.17145 - 0.29 + 0.012
bow = [(FRONT - 0.055 * (abs(t) / 6) ** 2.4, 0.1375 * t / 6, -0.004) for t in range(-6, 7)]
back = [(REAR + 0.020 * (abs(t) / 5) ** 2, 0.075 * t / 5, -0.004) for t in range(-5, 6)]
bumper = [
    shapes.moved(shapes.scaled(shapes.tube(bow, 0.011, 12), 1, 1, 1.5), z=0.002),
    shapes.moved(shapes.scaled(shapes.tube(back, 0.008, 10), 1, 1, 1.3), z=0.001),
    shapes.moved(shapes.box(0.070, 0.060, 0.006), x=0.410, z=-0.012),
    shapes.moved(shapes.box(0.055, 0.050, 0.006), x=-0.085, z=-0.008),
]
shapes.write("bumper", shapes.merge(*bumper), __file__)

# Upper deck: a plate with a nose that carries the scanner.
outline = [(0.300, -0.034), (0.300, 0.034), (0.288, 0.046), (0.215, 0.060), (-0.030, 0.070), (-0.042, 0.060),
           (-0.042, -0.060), (-0.030, -0.070), (0.215, -0.060), (0.288, -0.046)]
shapes.write("deck", shapes.extrude(outline, 0.049, 0.053), __file__)

# Suspension: for each wheel two arms and a damper that leans to a tower above the axle.
arms, dampers, springs = [], [], []
for x, lean in ((0.0, 0.030), (WHEELBASE, -0.030)):
    for side in (-1, 1):
        for dx in (-0.022, 0.022):
            arms.append(shapes.tube([(x + dx, 0.030 * side, -0.016), (x + 0.3 * dx, 0.094 * side, -0.014)], 0.0045, 10))
        arms.append(shapes.tube([(x, 0.034 * side, 0.020), (x, 0.094 * side, 0.016)], 0.0030, 10))
        arms.append(shapes.tube([(x, 0.030 * side, 0.0), (x, 0.110 * side, 0.0)], 0.0038, 12))
        foot, head = (x + lean, 0.080 * side, -0.008), (x + lean, 0.040 * side, 0.062)

        def between(t):
            return tuple(a + (b - a) * t for a, b in zip(foot, head))

        dampers.append(shapes.tube([foot, between(0.95)], 0.0030, 10))
        dampers.append(shapes.tube([between(0.50), between(0.97)], 0.0066, 14))
        turns = 4.5
        coil = []
        for i in range(int(turns * 9) + 1):
            t = 2 * math.pi * i / 9
            p = between(0.08 + 0.66 * i / (turns * 9))
            coil.append((p[0] + 0.0086 * math.cos(t), p[1] + 0.0080 * math.sin(t), p[2] + 0.0043 * math.sin(t) * side))
        springs.append(shapes.tube(coil, 0.0013, 3))
    tower = shapes.extrude([(0.052, -0.006), (0.052, 0.010), (0.036, 0.030), (-0.036, 0.030), (-0.052, 0.010), (-0.052, -0.006)],
                           -0.0025, 0.0025)
    tower = shapes.turned(shapes.turned(tower, "x", 90), "z", 90)
    arms.append(shapes.moved(tower, x=x + 0.62 * lean, z=0.040))
shapes.write("arms", shapes.merge(*arms), __file__)
shapes.write("dampers", shapes.merge(*dampers), __file__)
shapes.write("springs", shapes.merge(*springs), __file__)

# The computer's heat sink.
fins = [shapes.moved(shapes.box(0.060, 0.060, 0.006), z=0.003)]
fins += [shapes.moved(shapes.box(0.060, 0.0018, 0.020), y=-0.0285 + 0.0057 * i, z=0.015) for i in range(11)]
shapes.write("heatsink", shapes.merge(*fins), __file__)

# The scanner; z = 0 is the plane of its beams.
shapes.write("scanner", shapes.moved(shapes.box(0.050, 0.050, 0.030, 0.003, 0.006), z=-0.029), __file__)
shapes.write("window", shapes.lathe([(0.0215, -0.0145), (0.0205, 0.009)], 36), __file__)
shapes.write("cap", shapes.lathe(shapes.rounded_profile(0.0230, 0.008, 0.021, 0.004, 2), 36), __file__)
