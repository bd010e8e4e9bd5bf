"""Meshes of scara, each in the frame of its link. To regenerate them, run: python3 make.py"""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

# m. Joint 1 is at (0.06, 0, 0.22) in the base's frame; links are centred on their own joint axis.
ARM_1 = 0.31
ARM_2 = 0.2615


def stadium(length, r1, r2, steps=10):
    """An outline around two circles: one about the origin, one ahead of it."""
    lean = math.asin((r1 - r2) / length)
    out = []
    for i in range(steps + 1):
        a = -math.pi / 2 + lean + (math.pi - 2 * lean) * i / steps
        out.append((length + r2 * math.cos(a), r2 * math.sin(a)))
    for i in range(steps + 1):
        a = math.pi / 2 - lean + (math.pi + 2 * lean) * i / steps
        out.append((r1 * math.cos(a), r1 * math.sin(a)))
    return out


def base():
    """Foot and column; the column's rear is sloped at the top, where the cables leave it."""
    foot = shapes.extrude(shapes.rounded_rectangle(0.216, 0.18, 0.015, 4), 0.0, 0.018, 0.003, 2)
    rings = []
    for z, back, front, half, corner in [(0.016, -0.092, 0.055, 0.058, 0.015), (0.19, -0.092, 0.055, 0.058, 0.015)]:
        ring = shapes.rounded_rectangle(front - back, 2 * half, corner, 4)
        rings.append([(x + (front + back) / 2, y, z) for x, y in ring])
    column = shapes.loft(rings)
    rings = []
    for z, back, front in [(0.25, -0.092, 0.10), (0.36, -0.092, 0.118), (0.41, -0.055, 0.118), (0.43, -0.01, 0.112), (0.435, 0.0, 0.10)]:
        ring = shapes.rounded_rectangle(front - back, 0.116, 0.015, 4)
        rings.append([(x + (front + back) / 2, y, z) for x, y in ring])
    head = shapes.loft(rings)
    rings = []
    for z, front in [(0.185, 0.055), (0.255, 0.055)]:
        ring = shapes.rounded_rectangle(front + 0.092, 0.116, 0.015, 4)
        rings.append([(x + (front - 0.092) / 2, y, z) for x, y in ring])
    neck = shapes.loft(rings)
    disc = shapes.moved(shapes.lathe([(0.05, 0.245), (0.052, 0.252), (0.052, 0.26)], 40), x=0.06)
    return shapes.moved(shapes.merge(foot, column, neck, head, disc), x=0.013)


def base_dark():
    """Connector plate at the rear, and the joint below arm 1."""
    plate = shapes.moved(shapes.box(0.006, 0.09, 0.12, 0.002, steps=2), -0.081, 0, 0.11)
    ring = shapes.moved(shapes.lathe(shapes.rounded_profile(0.046, 0.180, 0.2, 0.003, 2), 40), x=0.06)
    lamp = shapes.moved(shapes.lathe([(0.009, 0.43), (0.009, 0.447), (0.006, 0.452)], 20), 0.04, 0.03)
    return shapes.merge(plate, ring, lamp)


def arm_1():
    """A flat bar from joint 1 to joint 2, between z -0.03 and 0.02."""
    return shapes.merge(shapes.extrude(stadium(ARM_1, 0.055, 0.05, 14), -0.025, 0.022, 0.008),
                        shapes.moved(shapes.lathe(shapes.rounded_profile(0.044, 0.02, 0.03, 0.003, 2), 36), x=ARM_1))


def arm_2():
    """A bar from joint 2 to the shaft, with a cover over motors and belts; z 0 is 0.256 m above the base's foot."""
    bar = shapes.extrude(stadium(ARM_2, 0.055, 0.044, 14), -0.012, 0.05, 0.008)
    rings = []
    for z, r1, r2, grow in [(0.048, 0.053, 0.042, 1.0), (0.15, 0.050, 0.038, 1.0), (0.172, 0.045, 0.033, 1.0), (0.181, 0.035, 0.024, 1.0)]:
        rings.append([(x * 0.72, y, z) for x, y in stadium(ARM_2, r1, r2, 14)])
    cover = shapes.loft(rings)
    nose = shapes.moved(shapes.lathe(shapes.rounded_profile(0.034, 0.04, 0.085, 0.005, 2), 36), x=ARM_2)
    return shapes.merge(bar, cover, nose)


def arm_2_dark():
    """Seal around the shaft, and the button that releases the brake."""
    seal = shapes.moved(shapes.lathe(shapes.rounded_profile(0.022, -0.026, -0.01, 0.003, 2), 28), x=ARM_2)
    top = shapes.moved(shapes.lathe(shapes.rounded_profile(0.018, 0.082, 0.095, 0.003, 2), 28), x=ARM_2)
    button = shapes.moved(shapes.lathe([(0.006, 0.05), (0.006, 0.056), (0.004, 0.058)], 14), x=ARM_2 - 0.05, y=-0.026)
    return shapes.merge(seal, top, button)


def shaft():
    """The shaft, about its axis; its lower end is at z -0.074."""
    rod = shapes.lathe([(0.0085, -0.086), (0.01, -0.084), (0.01, 0.358), (0.0085, 0.36)], 24)
    stop = shapes.lathe(shapes.rounded_profile(0.016, 0.335, 0.35, 0.002, 2), 24)
    return shapes.merge(rod, stop)


def palm():
    """The gripper's body, below the shaft's lower end."""
    body = shapes.extrude(shapes.rounded_rectangle(0.036, 0.074, 0.005, 3), -0.036, -0.008, 0.002, 2)
    collar = shapes.lathe([(0.018, -0.01), (0.018, 0.004), (0.015, 0.006)], 28)
    return shapes.merge(body, collar)


def finger():
    """The left finger: its flat inner side is the plane y = 0; the tip is at z 0."""
    slide = shapes.moved(shapes.box(0.024, 0.014, 0.008, 0.0015, steps=2), 0, 0.009, 0.040)
    pad = shapes.moved(shapes.box(0.014, 0.007, 0.040, 0.0015, steps=2), 0, 0.0035, 0.020)
    return shapes.merge(slide, pad)


for make in (base, base_dark, arm_1, arm_2, arm_2_dark, shaft, palm, finger):
    shapes.write(make.__name__, make(), __file__)
