"""Writes the meshes of the Robotiq 2F-85, in the frames of its links (left side). Metres."""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

BAR = (0.0371575, 0.04342168)     # from the axis of a knuckle to that of its tip, x and z
FINGER = (0.03152616, -0.00376347)


def plate(outline, width, edge=0.0012):
    """An outline in x and z (counter-clockwise seen from -y), as a plate of a width about y = 0."""
    return shapes.turned(shapes.extrude(outline, -width / 2, width / 2, edge, 2), "x", 90)


def bar(a, b, ra, rb, width, steps=10):
    """A plate with round ends from a to b, in x and z."""
    angle = math.atan2(b[1] - a[1], b[0] - a[0])
    lean = math.asin((ra - rb) / math.hypot(b[0] - a[0], b[1] - a[1]))
    outline = []
    for (x, z), r, start, span in ((b, rb, angle - math.pi / 2 + lean, math.pi - 2 * lean),
                                   (a, ra, angle + math.pi / 2 - lean, math.pi + 2 * lean)):
        for i in range(steps + 1):
            t = start + span * i / steps
            outline.append((x + r * math.cos(t), z + r * math.sin(t)))
    return plate(outline, width)


def rounded(points, radius, steps=4):
    """A convex outline, counter-clockwise, with round corners."""
    out, n = [], len(points)
    for i in range(n):
        (ax, az), (bx, bz), (cx, cz) = points[i - 1], points[i], points[(i + 1) % n]
        u = ((ax - bx) / math.hypot(ax - bx, az - bz), (az - bz) / math.hypot(ax - bx, az - bz))
        v = ((cx - bx) / math.hypot(cx - bx, cz - bz), (cz - bz) / math.hypot(cx - bx, cz - bz))
        half = math.acos(u[0] * v[0] + u[1] * v[1]) / 2
        m = (u[0] + v[0], u[1] + v[1])
        length = math.hypot(*m)
        centre = (bx + m[0] / length * radius / math.sin(half), bz + m[1] / length * radius / math.sin(half))
        p = (bx + u[0] * radius / math.tan(half), bz + u[1] * radius / math.tan(half))
        start = math.atan2(p[1] - centre[1], p[0] - centre[0])
        for k in range(steps + 1):
            t = start + (math.pi - 2 * half) * k / steps
            out.append((centre[0] + radius * math.cos(t), centre[1] + radius * math.sin(t)))
    return out


def housing():
    """The round body, whose sides are flattened towards the top."""
    rings = []
    for z, x, y, corner in ((0.0085, 0.0365, 0.0365, 0.0364), (0.0095, 0.0375, 0.0375, 0.0374), (0.036, 0.0375, 0.0360, 0.0330),
                            (0.046, 0.0390, 0.0300, 0.0200), (0.056, 0.0330, 0.0170, 0.0100), (0.068, 0.0240, 0.0155, 0.0080),
                            (0.0705, 0.0215, 0.0135, 0.0070)):
        rings.append([(a, b, z) for a, b in shapes.rounded_rectangle(2 * x, 2 * y, corner, 8)])
    return shapes.loft(rings)


def cheek():
    """One of the two plates that hold the axles."""
    return plate(rounded([(-0.0385, 0.030), (0.0385, 0.030), (0.0425, 0.052), (0.030, 0.0675), (0.010, 0.0725),
                          (-0.010, 0.0725), (-0.030, 0.0675), (-0.0425, 0.052)], 0.005), 0.007)


for name, mesh in {
    "housing": housing(),
    "coupling": shapes.lathe(shapes.rounded_profile(0.0375, -0.0034, 0.008, 0.001, 1)),
    "cheek": cheek(),
    "knuckle": bar((0.0, 0.0), FINGER, 0.0085, 0.0075, 0.0166),
    "finger": bar((FINGER[0] + 0.001, FINGER[1] + 0.001), BAR, 0.0105, 0.0075, 0.0272),
    "inner_knuckle": bar((0.0, 0.0), BAR, 0.0065, 0.0060, 0.0045),
    "tip": plate(rounded([(0.006, -0.006), (0.006, 0.010), (-0.012, 0.049), (-0.0185, 0.051), (-0.0185, -0.002),
                          (-0.012, -0.006)], 0.002), 0.026),
    "pad": plate(rounded([(-0.018, 0.0135), (-0.018, 0.051), (-0.0253, 0.051), (-0.0253, 0.0135)], 0.0012, 2), 0.022, 0.0006),
}.items():
    shapes.write(name, mesh, __file__)
