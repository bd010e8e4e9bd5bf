"""Meshes of BubbleRob. The origin of the body is the centre of the sphere; the axis of the wheels is z."""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

BODY = 0.1          # radius of the body's sphere, m
TYRE = 0.04         # radius of a wheel, m
WIDTH = 0.02        # width of a wheel, m


def on_ball(radius, low, high, steps):
    """The profile of a spherical zone between two heights."""
    first, last = math.asin(low / radius), math.asin(high / radius)
    angles = [first + (last - first) * i / steps for i in range(steps + 1)]
    return [(radius * math.cos(a), radius * math.sin(a)) for a in angles]


def bowl():
    """A dish around the lower part of the body, 1 mm thick, open above."""
    return shapes.lathe(on_ball(BODY + 0.001, -0.0999, -0.030, 8) + [(0.0945, -0.0292)], 48)


def seam():
    """A thin ring at the rim of the bowl."""
    return shapes.lathe(on_ball(BODY + 0.0014, -0.030, -0.0265, 1), 64)


def ahead(mesh):
    """The mesh, rotated so that its z axis points ahead."""
    return shapes.turned(mesh, "y", 90)


def nose():
    """A short barrel that protrudes from the sphere."""
    return ahead(shapes.lathe([(0.026, 0.090), (0.026, 0.0985), (0.0255, 0.0995), (0.0245, 0.100)], 48))


def bezel():
    """The ring between barrel and sphere."""
    return ahead(shapes.lathe([(0.0295, 0.0925), (0.0295, 0.0962), (0.0285, 0.0972), (0.0262, 0.0975)], 48))


def lens():
    """The domed glass, 2 mm ahead of the barrel at its middle."""
    dome = [(0.015 * math.cos(a), 0.0998 + 0.0022 * math.sin(a)) for a in [math.pi / 2 * i / 5 for i in range(5)]]
    return ahead(shapes.lathe([(0.015, 0.098)] + dome, 40))


def gears():
    """For each motor, a round housing between body and wheel, and the axle."""
    parts = []
    for side in (1, -1):
        box = shapes.lathe(shapes.rounded_profile(0.019, 0.030, 0.084, 0.004, 3), 32)
        axle = shapes.lathe([(0.006, 0.080), (0.006, 0.092)], 24)
        both = shapes.turned(shapes.merge(box, axle), "x", -90 * side)
        parts.append(shapes.moved(both, x=0.05, z=-0.08))
    return shapes.merge(*parts)


def tyre():
    """A ring with a rounded tread; its hole is hidden by the rim."""
    return shapes.lathe(shapes.rounded_profile(TYRE, -WIDTH / 2, WIDTH / 2, 0.005, 3), 56)


def rim():
    """A disc that protrudes by half a millimetre on both sides."""
    return shapes.lathe(shapes.rounded_profile(0.0275, -WIDTH / 2 - 0.0006, WIDTH / 2 + 0.0006, 0.001, 2), 48)


def spokes():
    """On each face a hub and five spokes."""
    parts = []
    for side in (1, -1):
        z = side * (WIDTH / 2 + 0.0006)
        parts.append(shapes.moved(shapes.lathe(shapes.rounded_profile(0.008, -0.0012, 0.0012, 0.0006, 1), 24), z=z))
        for k in range(5):
            spoke = shapes.moved(shapes.box(0.019, 0.005, 0.0016), x=0.0155, z=z)
            parts.append(shapes.turned(spoke, "z", 72 * k))
    return shapes.merge(*parts)


for make in (bowl, seam, nose, bezel, lens, gears, tyre, rim, spokes):
    shapes.write(make.__name__, make(), __file__)
