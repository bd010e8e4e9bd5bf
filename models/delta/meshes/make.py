"""Meshes of the delta robot: head, upper arm and platform.

The head and the platform are in the robot's frame, z up; arms at 0, 120 and 240 degrees. The upper arm is in the frame
of its joint: x along the arm, z along the axis. All shapes are estimates in the style of such robots.
"""
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

R0, L1, R3 = 0.330, 0.420, 0.125      # m: axes of the base, upper arm, platform


def lobes(inner, outer, power=4, count=60, turn=0.0):
    """An outline with three lobes, of radius `outer` towards the arms and `inner` between them."""
    out = []
    for i in range(count):
        a = 2 * math.pi * i / count
        lobe = ((1 + math.cos(3 * a)) / 2) ** power
        r = inner + (outer - inner) * lobe
        out.append((r * math.cos(a + turn), r * math.sin(a + turn)))
    return out


def stacked(levels):
    """Rings of an outline scaled to each height: (outline, z)."""
    return shapes.loft([[(x, y, z) for x, y in outline] for outline, z in levels])


def head():
    """The body between the motors."""
    levels = [
        (lobes(0.150, 0.200, 2), -0.075), (lobes(0.200, 0.255, 2), -0.070), (lobes(0.215, 0.275, 2), -0.055),
        (lobes(0.235, 0.300, 2), 0.000), (lobes(0.240, 0.305, 2), 0.070), (lobes(0.232, 0.297, 2), 0.086),
        (lobes(0.210, 0.270, 2), 0.094),
    ]
    shapes.write("head", stacked(levels), __file__)


def upper_arm():
    """A hub about the axis, and a beam that narrows towards the elbow."""
    rings = []
    for x, half_y, half_z in (
        (0.020, 0.056, 0.044), (0.060, 0.054, 0.043), (0.110, 0.049, 0.040), (0.180, 0.043, 0.036),
        (0.260, 0.037, 0.031), (0.340, 0.031, 0.027), (0.400, 0.026, 0.024), (0.428, 0.021, 0.021),
        (0.436, 0.012, 0.013),
    ):
        ring = []
        for i in range(32):
            a = 2 * math.pi * i / 32
            c, s = math.cos(a), math.sin(a)
            ring.append((x, math.copysign(abs(c) ** 0.7, c) * half_y, math.copysign(abs(s) ** 0.7, s) * half_z))
        rings.append(ring)
    hub = shapes.lathe(shapes.rounded_profile(0.064, -0.052, 0.052, 0.010, 3), 36)
    shapes.write("upper_arm", shapes.merge(hub, shapes.loft(rings)), __file__)


def platform():
    levels = [
        (lobes(0.052, 0.124, 2, 72), -0.011), (lobes(0.056, 0.129, 2, 72), -0.007), (lobes(0.057, 0.130, 2, 72), 0.006),
        (lobes(0.052, 0.125, 2, 72), 0.010),
    ]
    plate = stacked(levels)
    tower = shapes.lathe([(0.050, 0.008), (0.046, 0.020), (0.040, 0.032), (0.038, 0.036), (0.030, 0.037)], 36)
    shapes.write("platform", shapes.merge(plate, tower), __file__)


def cup():
    """A suction cup with two folds; its lip is at z = 0."""
    profile = [
        (0.0170, 0.0000), (0.0185, 0.0015), (0.0120, 0.0085), (0.0165, 0.0135), (0.0110, 0.0200), (0.0085, 0.0230),
        (0.0085, 0.0300),
    ]
    shapes.write("cup", shapes.lathe(profile, 32), __file__)


for part in (head, upper_arm, platform, cup):
    part()
