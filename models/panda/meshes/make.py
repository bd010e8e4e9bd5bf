"""Meshes of the Panda's shells. Plain cylinders and boxes are primitives in `model.toml`.

Half housings and bends are used by two to four links each, at poses defined in `model.toml`; all other meshes are in
the frame of their link, where z is the joint's axis. Lengths are those of the kinematics; radii and roundings are estimates
by eye, and were not fitted to the capsules of the collision model.
"""
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

COLUMN = 0.0550          # radius of the tubes between joints, m
ELBOW = 0.0565           # radius of the housings of joints 2 and 4, m
HALF = 0.126             # length of a housing from the middle of the joint, m
SEGMENTS = 36


def bezier(a, b, c, d, steps=9):
    """Points of a cubic curve."""
    out = []
    for i in range(steps + 1):
        t = i / steps
        k = ((1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t ** 3)
        out.append(tuple(sum(w * p[axis] for w, p in zip(k, (a, b, c, d))) for axis in range(3)))
    return out


def section(width, depth, power, count=SEGMENTS):
    """A rounded cross-section: an ellipse for a power of 2, nearly a rectangle for a high one."""
    out = []
    for i in range(count):
        a = 2 * math.pi * i / count
        c, s = math.cos(a), math.sin(a)
        out.append((math.copysign(abs(c) ** (2 / power), c) * width, math.copysign(abs(s) ** (2 / power), s) * depth))
    return out


def write(name, mesh):
    shapes.write(name, mesh, __file__)


def foot():
    """The base: a plate with round corners that grows into a column."""
    rings = []
    for z in (0.0, 0.004, 0.014, 0.026, 0.040, 0.056, 0.072, 0.088, 0.104, 0.118, 0.1385):
        t = min(1.0, max(0.0, (z - 0.014) / 0.104))
        t = t * t * (3 - 2 * t)
        inset = 0.003 if z == 0.0 else 0.0
        front, back, side = 0.072 - inset, 0.134 - inset, 0.094 - inset
        low = [(x * (front if x > 0 else back), y * side) for x, y in section(1.0, 1.0, 3.2)]
        high = section(COLUMN, COLUMN, 2)
        rings.append([((1 - t) * a + t * c, (1 - t) * b + t * d, z) for (a, b), (c, d) in zip(low, high)])
    write("foot", shapes.loft(rings))


def housing():
    """Half of the housing of joint 2 or 4 about z, from the middle of the joint to its rounded end."""
    arc = [math.pi / 2 * i / 5 for i in range(6)]
    edge = 0.022
    end = [(ELBOW - edge + edge * math.cos(a), HALF - edge + edge * math.sin(a)) for a in arc]
    write("housing", shapes.lathe([(ELBOW, 0.0008)] + end, SEGMENTS))


def bends():
    """From a column below the joint to its housing, which points to -y at the shoulder and to +y at the elbow."""
    path = bezier((0, 0, -0.150), (0, 0, -0.070), (0, -0.030, -0.004), (0, -0.088, -0.004))
    write("shoulder_bend", shapes.tube(path, 0.0515, 28))
    # The bend has the radius of the column at its lower end, and is narrower than the housing at its upper end.
    path = bezier((-0.0825, 0, -0.100), (-0.0825, 0, -0.030), (-0.0600, 0.062, 0.002), (0, 0.064, 0), 11)
    radii = [COLUMN - 0.0100 * (i / 11) ** 2 for i in range(12)]
    write("elbow_bend", shapes.tube(path, radii, 28))


def forearm():
    """Link 5: a tube that narrows, and is offset to the side to hold the wrist."""
    rings = []
    for z, y, width, depth, power in (
        (-0.2575, 0.0000, 0.0535, 0.0535, 2.0), (-0.2555, 0.0000, 0.0550, 0.0550, 2.0),
        (-0.2200, 0.0005, 0.0550, 0.0549, 2.0), (-0.2050, 0.0022, 0.0548, 0.0545, 2.0),
        (-0.1900, 0.0055, 0.0545, 0.0536, 2.0), (-0.1750, 0.0100, 0.0539, 0.0520, 2.1),
        (-0.1600, 0.0162, 0.0530, 0.0496, 2.2), (-0.1450, 0.0234, 0.0519, 0.0467, 2.3),
        (-0.1300, 0.0311, 0.0508, 0.0434, 2.3), (-0.1150, 0.0390, 0.0498, 0.0399, 2.4),
        (-0.1000, 0.0459, 0.0491, 0.0366, 2.5), (-0.0850, 0.0518, 0.0486, 0.0338, 2.5),
        (-0.0700, 0.0566, 0.0483, 0.0315, 2.6), (-0.0550, 0.0604, 0.0481, 0.0298, 2.6),
        (-0.0350, 0.0632, 0.0478, 0.0286, 2.6), (0.0000, 0.0640, 0.0470, 0.0275, 2.6),
    ):
        rings.append([(a, b + y, z) for a, b in section(width, depth, power)])
    wrist = shapes.lathe(shapes.rounded_profile(0.0485, 0.034, 0.094, 0.010, 3), SEGMENTS)
    write("forearm", shapes.merge(shapes.loft(rings), shapes.turned(wrist, "x", -90)))


def wrist():
    """Link 6: two crossing housings, that of joint 6 about z, and that of joint 7 about y, 88 mm ahead."""
    one = shapes.lathe(shapes.rounded_profile(0.0485, -0.0295, 0.046, 0.010, 3), SEGMENTS)
    profile = [(0.0455, -0.0515), (0.0455, 0.030)]
    arc = [math.pi / 2 * i / 5 for i in range(1, 6)]
    profile += [(0.0255 + 0.020 * math.cos(a), 0.030 + 0.020 * math.sin(a)) for a in arc]
    two = shapes.moved(shapes.turned(shapes.lathe(profile, SEGMENTS), "x", -90), 0.088)
    rings = []
    for x, width, depth in ((0.010, 0.038, 0.036), (0.040, 0.037, 0.033), (0.075, 0.039, 0.034)):
        rings.append([(x, a - 0.004, b + 0.006) for a, b in section(width, depth, 2.8, 28)])
    write("wrist", shapes.merge(one, two, shapes.loft(rings)))


def end():
    """Link 7: the last housing with its pilot grip, which points to the side at +45 degrees, and the flange."""
    profile = [(0.0455, 0.0555), (0.0455, 0.080), (0.0440, 0.0865), (0.0410, 0.0900), (0.0380, 0.0910)]
    body = shapes.lathe(profile, SEGMENTS)
    neck = []
    for x, width, depth in (
        (0.020, 0.0300, 0.0150), (0.050, 0.0265, 0.0150), (0.072, 0.0255, 0.0145), (0.080, 0.0245, 0.0135),
        (0.084, 0.0225, 0.0115),
    ):
        neck.append([(x, a, b + 0.0735) for a, b in section(width, depth, 3.0, 28)])
    write("end", shapes.merge(body, shapes.turned(shapes.loft(neck), "z", 45)))


for part in (foot, housing, bends, forearm, wrist, end):
    part()
