"""Meshes of the e-puck, in its base frame: on the floor between the wheels. The axis of the wheels is z."""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

WHEEL = 0.020       # radius, m
TRACK = 0.052       # m
BODY = 0.035        # radius of body and board, m
HALF = 0.0222       # half of the width of the body between the wheels, m
SENSORS = [(30, -10, -17.2), (22, -25, -45.9), (0, -31, -90), (-30, -15, -151.5),
           (-30, 15, 151.2), (0, 31, 90), (22, 25, 45.8), (30, 10, 17.1)]


def clipped_circle(radius, half, steps=16):
    """A circle clipped at `half` to the left and right, counter-clockwise."""
    a = math.asin(half / radius)
    front = [-a + 2 * a * i / steps for i in range(steps + 1)]
    return [(radius * math.cos(t), radius * math.sin(t)) for t in front + [t + math.pi for t in front]]


def body():
    """The clear plastic body: a tub for the battery between the wheels, and two walls up to the board."""
    tub = shapes.extrude(clipped_circle(BODY, HALF), 0.0026, 0.0262)
    parts = [tub]
    for x in (1, -1):
        posts = shapes.extrude(shapes.rounded_rectangle(0.006, 0.020, 0.002, 4), 0.026, 0.0385)
        parts.append(shapes.moved(posts, x=x * 0.0215))
    sliders = [shapes.moved(shapes.ball(0.005, 16), x=x * 0.03, z=0.005) for x in (1, -1)]
    return shapes.merge(*parts, *sliders)


def battery():
    """The battery in its tray, seen through front and back."""
    cell = shapes.extrude(clipped_circle(0.0353, 0.0115, 8), 0.0085, 0.0210)
    return shapes.merge(cell, shapes.block(0.046, 0.030, 0.010, 0, 0, 0.0245))


def motors():
    """Two stepper motors across the body, above the battery."""
    parts = []
    for side in (1, -1):
        can = shapes.turned(shapes.lathe(shapes.rounded_profile(0.0052, 0.001, 0.0225, 0.0008, 2), 28), "x", -90 * side)
        parts.append(shapes.moved(can, x=0.0, z=0.0318))
        axle = shapes.turned(shapes.lathe([(0.0015, 0.020), (0.0015, 0.0300)], 12), "x", -90 * side)
        parts.append(shapes.moved(axle, z=WHEEL))
    return shapes.merge(*parts)


def board():
    return shapes.disc(BODY, 0.0384, 0.0400, 48)


def ring():
    """The ring that spreads the light of the LEDs."""
    return shapes.ring_of(0.0305, 0.0362, 0.0400, 0.0432)


def upper():
    """The small board on top."""
    outline = shapes.rounded_rectangle(0.046, 0.058, 0.006, 5)
    return shapes.moved(shapes.extrude(outline, 0.0480, 0.0496), x=-0.002)


def black():
    """Infrared sensors, camera, speaker, selector, connectors."""
    parts = []
    for x, y, heading in SENSORS:
        h = math.radians(heading)
        x, y = x / 1000 - 0.0018 * math.cos(h), y / 1000 - 0.0018 * math.sin(h)
        parts.append(shapes.block(0.0042, 0.0070, 0.0040, x, y, 0.0362, heading))
    camera = shapes.turned(shapes.lathe(shapes.rounded_profile(0.0042, 0.024, 0.0352, 0.0008, 2), 32), "y", 90)
    parts.append(shapes.moved(camera, z=0.028))
    parts.append(shapes.block(0.008, 0.012, 0.010, 0.0285, 0, 0.0285))
    parts.append(shapes.disc(0.0075, 0.0496, 0.0512, 36, -0.012, 0.002))
    parts.append(shapes.disc(0.0045, 0.0496, 0.0540, 24, 0.012, 0.014))
    parts.append(shapes.block(0.0055, 0.026, 0.0050, 0.0140, -0.008, 0.0520))
    parts.append(shapes.block(0.020, 0.0055, 0.0050, -0.006, -0.0235, 0.0520))
    parts.append(shapes.block(0.007, 0.007, 0.0012, 0.002, -0.008, 0.0502))
    parts.append(shapes.block(0.009, 0.009, 0.0012, 0.012, 0.0, 0.0406))
    return shapes.merge(*parts)


def metal():
    """Spacers, pins, the knob of the selector, the frame of the speaker, microphones, a button."""
    parts = [shapes.disc(0.0020, 0.0400, 0.0500, 16, x, y) for x in (-0.020, 0.016) for y in (-0.024, 0.024)]
    parts.append(shapes.disc(0.0030, 0.0540, 0.0550, 6, 0.012, 0.014))
    parts.append(shapes.moved(shapes.ring_of(0.0062, 0.0075, 0.0512, 0.0516, 36), x=-0.012, y=0.002))
    parts += [shapes.disc(0.0026, 0.0496, 0.0514, 20, x, y) for x, y in ((0.004, 0.022), (0.004, -0.016), (-0.022, 0.012))]
    parts += [shapes.block(0.0008, 0.0008, 0.0006, 0.0140, -0.018 + 0.0025 * k, 0.0548) for k in range(9)]
    parts.append(shapes.block(0.005, 0.004, 0.0016, -0.020, -0.012, 0.0504))
    return shapes.merge(*parts)


def lens():
    """The camera's glass."""
    return shapes.moved(shapes.turned(shapes.disc(0.0026, 0.0350, 0.0355, 24), "y", 90), z=0.028)


def tyre():
    """The rubber ring."""
    return shapes.ring_of(0.0176, WHEEL, -0.0016, 0.0016, 56)


def wheel():
    """A rim with five spokes and a hub; the outside is at both ends, so that it fits left and right."""
    parts = [shapes.ring_of(0.0150, 0.0178, -0.0021, 0.0021, 48), shapes.disc(0.0050, -0.0024, 0.0024, 24)]
    for k in range(5):
        parts.append(shapes.turned(shapes.block(0.0115, 0.0034, 0.0030, 0.0100, 0, 0), "z", 72 * k))
    return shapes.merge(*parts)


def marks():
    """A disc behind the spokes."""
    return shapes.disc(0.0155, -0.0006, 0.0006, 40)


for make in (body, battery, motors, board, ring, upper, black, metal, lens, tyre, wheel, marks):
    shapes.write(make.__name__, make(), __file__)
