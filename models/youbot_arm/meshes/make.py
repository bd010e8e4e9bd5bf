"""Meshes of youbot_arm, each in the frame of its link (z along the link). To regenerate them, run: python3 make.py"""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

UPPER, FORE = 0.155, 0.135      # m, lengths of arm_link_2 and arm_link_3
SHOULDER = (0.033, 0.019)       # m, x and z of joint 2 in arm_link_1


def slab(length, radius, low, high, edge=0.006, steps=6):
    """A bar from the origin along +z with round ends, between two values of y."""
    outline = shapes.rounded_rectangle(length + 2 * radius, 2 * radius, radius * 0.999, steps)
    bar = shapes.moved(shapes.extrude(outline, low, high, edge, 2), x=length / 2)
    return shapes.turned(shapes.turned(bar, "x", -90.0), "y", -90.0)


def rod(radius, low, high, edge=0.003):
    """The profile of a cylinder with bevelled edges, for `shapes.lathe`."""
    return [(radius - edge, low), (radius, low + edge), (radius, high - edge), (radius - edge, high)]


def drum(radius, low, high, edge=0.003, segments=24):
    """A cylinder about y, between two values of y."""
    return shapes.turned(shapes.lathe(rod(radius, low, high, edge), segments), "x", -90.0)


def foot():
    """arm_link_0: a round column that narrows, about the axis of joint 1."""
    column = shapes.lathe([(0.078, 0.012), (0.078, 0.030), (0.074, 0.038), (0.062, 0.050), (0.056, 0.062), (0.054, 0.082)], 40)
    return shapes.moved(column, x=0.024)


def foot_dark():
    """Plate and motor of the foot."""
    plate = shapes.moved(shapes.extrude(shapes.rounded_rectangle(0.17, 0.16, 0.02, 4), 0.0, 0.0125, 0.002, 2), x=0.024)
    ring = shapes.moved(shapes.lathe(rod(0.049, 0.08, 0.092, 0.003), 32), x=0.024)
    return shapes.merge(plate, ring)


def turret():
    """arm_link_1: a disc on joint 1 and a cheek up to joint 2, on its left."""
    disc = shapes.lathe(rod(0.052, -0.004, 0.016, 0.004), 32)
    x, z = SHOULDER
    cheek = shapes.moved(slab(0.030, 0.034, 0.006, 0.046), x, 0, z - 0.030)
    web = shapes.moved(shapes.box(0.05, 0.04, 0.03, 0.006, steps=2), 0.012, 0.024, 0.008)
    return shapes.merge(disc, cheek, web)


def turret_dark():
    """Motor of joint 2."""
    x, z = SHOULDER
    return shapes.moved(shapes.merge(drum(0.031, 0.044, 0.066), drum(0.022, 0.064, 0.070)), x, 0, z)


def upper():
    """arm_link_2: to the right of the arm's plane."""
    return slab(UPPER, 0.033, -0.050, -0.002)


def upper_dark():
    """Covers of joint 2 and motor of joint 3."""
    return shapes.merge(drum(0.027, -0.056, -0.004), shapes.moved(drum(0.030, -0.066, -0.048), z=UPPER),
                        shapes.moved(drum(0.020, -0.070, -0.060), z=UPPER),
                        shapes.moved(shapes.box(0.032, 0.006, 0.075, 0.0), 0, -0.050, UPPER / 2))


def fore():
    """arm_link_3: to the left of the arm's plane."""
    return slab(FORE, 0.029, 0.002, 0.043)


def fore_dark():
    """Covers of joint 3 and motor of joint 4."""
    return shapes.merge(drum(0.024, 0.004, 0.049), shapes.moved(drum(0.026, 0.041, 0.058), z=FORE),
                        shapes.moved(drum(0.017, 0.056, 0.062), z=FORE),
                        shapes.moved(shapes.box(0.028, 0.006, 0.062, 0.0), 0, 0.043, FORE / 2))


def wrist():
    """arm_link_4: a cheek on joint 4 and the housing of joint 5 above it."""
    cheek = slab(0.045, 0.026, -0.036, -0.002)
    house = shapes.moved(shapes.extrude(shapes.rounded_rectangle(0.056, 0.078, 0.02, 4), 0.040, 0.092, 0.006, 2), y=0.0)
    return shapes.merge(cheek, house)


def wrist_dark():
    """Cover of joint 4 and the drum of joint 5."""
    return shapes.merge(drum(0.021, -0.041, -0.004), shapes.lathe(rod(0.027, 0.088, 0.122, 0.003), 32))


def palm():
    """Flange and palm of the gripper, in the frame of arm_link_5."""
    flange = shapes.lathe([(0.024, -0.010), (0.024, 0.002)], 32)
    block = shapes.extrude(shapes.rounded_rectangle(0.058, 0.098, 0.008, 3), 0.001, 0.036, 0.003, 2)
    return shapes.merge(flange, block)


def rails():
    """The two rods on which the fingers slide."""
    rods = []
    for x in (-0.013, 0.013):
        rod = shapes.turned(shapes.lathe([(0.0035, -0.046), (0.0035, 0.046)], 12), "x", 90.0)
        rods.append(shapes.moved(rod, x, 0, 0.041))
    return shapes.merge(*rods)


def finger():
    """The left finger, in its own frame: its flat inner side is the plane y = 0."""
    slider = shapes.moved(shapes.box(0.040, 0.020, 0.010), 0, 0.012, -0.005)
    neck = shapes.moved(shapes.box(0.018, 0.010, 0.022), 0, 0.0085, 0.008)
    pad = shapes.moved(shapes.box(0.018, 0.007, 0.036, 0.0), 0, 0.0035, 0.027)
    return shapes.merge(slider, neck, pad)


for make in (foot, foot_dark, turret, turret_dark, upper, upper_dark, fore, fore_dark, wrist, wrist_dark, palm, rails, finger):
    shapes.write(make.__name__, make(), __file__)
