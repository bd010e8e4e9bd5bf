"""Meshes of omni_platform. To regenerate them, run: python3 make.py"""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

# Wheel, in m, in its own frame: the axle is z.
RADIUS = 0.05          # radius of the wheel
ROLLER_CIRCLE = 0.036  # radius of the circle of the rollers' centres
ROLLER_HALF = 0.037    # half the length of a roller


def roller_radius(s):
    """Radius of a roller at s along its axis: the distance to the wheel's cylinder, which makes the wheel round."""
    def inside(r, turn):
        x = ROLLER_CIRCLE + r * math.cos(turn)
        y = (s + r * math.sin(turn)) / math.sqrt(2)
        return math.hypot(x, y) < RADIUS

    best = RADIUS
    for k in range(-60, 61):
        low, high = 0.0, RADIUS
        for _ in range(30):
            middle = (low + high) / 2
            low, high = (middle, high) if inside(middle, math.pi * k / 120) else (low, middle)
        best = min(best, low)
    return best


def roller():
    """One roller, about its axis z."""
    profile = []
    for k in range(-5, 6):
        s = ROLLER_HALF * k / 5
        profile.append((roller_radius(s) - 0.0003, s))
    profile = [(0.004, profile[0][1] - 0.001)] + profile + [(0.004, profile[-1][1] + 0.001)]
    return shapes.lathe(profile, 20)


def hub():
    """A hub between two plates that hold the rollers, with a cap on either side."""
    core = shapes.lathe([(0.019, -0.028), (0.019, 0.028)], 20)
    parts = [core]
    for side in (-1, 1):
        plate = shapes.lathe([(0.0405, 0.0285), (0.043, 0.0295), (0.043, 0.0325), (0.041, 0.0335)], 32)
        cap = shapes.lathe([(0.016, 0.033), (0.016, 0.0345), (0.0145, 0.036)], 20)
        parts += [shapes.scaled(plate, z=side), shapes.scaled(cap, z=side)]
        for k in range(6):
            turn = math.radians(60 * k + 30)
            screw = shapes.moved(shapes.lathe([(0.0035, 0.033), (0.003, 0.0352)], 6),
                                 x=0.032 * math.cos(turn), y=0.032 * math.sin(turn))
            parts.append(shapes.scaled(screw, z=side))
    return shapes.merge(*parts)


def chassis():
    """A long body between the wheels, with a panel on either side between front and rear wheel."""
    body = shapes.moved(shapes.extrude(shapes.rounded_rectangle(0.564, 0.232, 0.03, 8), -0.047, 0.047, 0.006), z=-0.024)
    side = shapes.moved(shapes.extrude(shapes.rounded_rectangle(0.334, 0.352, 0.012, 4), -0.044, 0.047, 0.005), z=-0.024)
    return shapes.merge(body, side)


def cover():
    """The top: a sheet over the wheels."""
    return shapes.extrude(shapes.rounded_rectangle(0.574, 0.372, 0.035, 8), 0.0225, 0.0345, 0.004)


def plate():
    """The load plate behind the arm."""
    return shapes.moved(shapes.extrude(shapes.rounded_rectangle(0.24, 0.30, 0.012, 5), 0.040, 0.046, 0.0015), x=-0.159)


def trim():
    """Black parts: front, rear and side panels, the block that carries the arm, the feet of the plate."""
    parts = [
        shapes.moved(shapes.box(0.012, 0.17, 0.05, 0.004, steps=2), 0.279, 0, -0.028),
        shapes.moved(shapes.box(0.012, 0.17, 0.05, 0.004, steps=2), -0.279, 0, -0.028),
        shapes.moved(shapes.extrude(shapes.rounded_rectangle(0.20, 0.20, 0.03, 6), 0.034, 0.0455, 0.003), 0.167, 0, 0),
    ]
    for y in (-0.1735, 0.1735):
        parts.append(shapes.moved(shapes.box(0.25, 0.009, 0.042, 0.004, steps=2), 0, y, -0.03))
    for x in (-0.265, -0.053):
        for y in (-0.135, 0.135):
            parts.append(shapes.moved(shapes.lathe([(0.008, 0.033), (0.008, 0.041)], 12), x, y, 0))
    return shapes.merge(*parts)


def laser():
    """The scanner, about its point of measurement: a square foot and a round head, on a bracket of the chassis."""
    foot = shapes.moved(shapes.box(0.05, 0.05, 0.034, 0.004, steps=2), z=-0.031)
    head = shapes.lathe(shapes.rounded_profile(0.019, -0.013, 0.022, 0.004, 2), 24)
    neck = shapes.lathe([(0.0225, -0.015), (0.0225, -0.010), (0.02, -0.008)], 24)
    return shapes.merge(foot, head, neck)


shapes.write("roller", roller(), __file__)
shapes.write("hub", hub(), __file__)
shapes.write("chassis", chassis(), __file__)
shapes.write("cover", cover(), __file__)
shapes.write("plate", plate(), __file__)
shapes.write("trim", trim(), __file__)
shapes.write("laser", laser(), __file__)
