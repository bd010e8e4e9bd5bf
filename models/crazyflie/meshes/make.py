"""Writes the meshes of the Crazyflie 2.1 beside this file, m."""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes  # noqa: E402

ARM = 0.031          # offset of the motors, along x and y
BOARD = 0.0125       # height of the board
PROPELLER = 0.021    # height of the propellers
RADIUS = 0.0231
CORNERS = [(1, -1), (-1, -1), (-1, 1), (1, 1)]


def blade(sign):
    """One blade along +x: a twisted, tapering section. `sign` is 1 for counter-clockwise turning."""
    rings = []
    n = 9
    for i in range(n + 1):
        t = i / n
        r = 0.0022 + (RADIUS - 0.0022) * t
        chord = 0.0062 * (0.45 + 1.9 * t - 1.75 * t * t) * (1 if t < 0.97 else 0.6)
        pitch = math.radians(30 - 20 * t) * sign
        sweep = -0.0012 * t * t * sign
        ring = []
        for k in range(8):
            a = 2 * math.pi * k / 8
            y, z = chord / 2 * math.cos(a), 0.00045 * (1 - 0.6 * t) * math.sin(a)
            c, s = math.cos(pitch), math.sin(pitch)
            ring.append((r, sweep + y * c - z * s, y * s + z * c))
        rings.append(ring)
    return shapes.loft(rings)


def propeller(sign):
    one = blade(sign)
    hub = shapes.lathe(shapes.rounded_profile(0.0026, -0.0016, 0.0018, 0.0007, 2), 20)
    return shapes.merge(one, shapes.turned(one, "z", 180), hub)


def board():
    """A rounded square, from which four arms reach to the motors."""
    middle = shapes.extrude(shapes.rounded_rectangle(0.030, 0.030, 0.004), BOARD - 0.0008, BOARD + 0.0008)
    arms = []
    for x, y in CORNERS:
        end = ARM * math.sqrt(2) - 0.004
        outline = [(0.010, -0.0048), (end, -0.0026), (end, 0.0026), (0.010, 0.0048)]
        arm = shapes.extrude(outline, BOARD - 0.0008, BOARD + 0.0008)
        arms.append(shapes.turned(arm, "z", math.degrees(math.atan2(y, x))))
    return shapes.merge(middle, *arms)


def mount():
    """The clip that holds a motor, the grip on the arm, along -x, and the foot."""
    clip = shapes.lathe([(0.0039, 0.0092), (0.0045, 0.0096), (0.0045, 0.0150), (0.0039, 0.0154)], 28)
    foot = shapes.lathe([(0.0014, 0.0), (0.0024, 0.0005), (0.0030, 0.0020), (0.0040, 0.0042), (0.0040, 0.0052)], 28)
    ribs = [shapes.moved(shapes.box(0.0010, 0.0016, 0.0052), 0.0036 * math.cos(a), 0.0036 * math.sin(a), 0.0073)
            for a in (math.pi, math.pi / 3, -math.pi / 3)]
    grip = shapes.moved(shapes.box(0.0080, 0.0062, 0.0042, 0.0012, steps=2), -0.0068, 0, BOARD)
    return shapes.merge(clip, foot, *ribs, grip)


shapes.write("propeller_ccw", propeller(1), __file__)
shapes.write("propeller_cw", propeller(-1), __file__)
shapes.write("board", board(), __file__)
shapes.write("mount", mount(), __file__)
shapes.write("motor", shapes.lathe(shapes.rounded_profile(0.0035, 0.0034, 0.0194, 0.0005, 1), 24), __file__)
shapes.write("cap", shapes.lathe(shapes.rounded_profile(0.0016, 0.0194, 0.0204, 0.0003, 1), 16), __file__)
shapes.write("battery", shapes.moved(shapes.box(0.0300, 0.0200, 0.0070, 0.0022), 0, 0, 0.0180), __file__)
shapes.write("label", shapes.merge(
    *[shapes.moved(shapes.box(0.0302, 0.0004, 0.0036, 0), 0, s * 0.0099, 0.0180) for s in (1, -1)],
    shapes.moved(shapes.box(0.0004, 0.0120, 0.0036, 0), 0.0149, 0, 0.0180)), __file__)
shapes.write("deck", shapes.merge(
    shapes.extrude(shapes.rounded_rectangle(0.028, 0.028, 0.003), 0.0230, 0.0246),
    shapes.moved(shapes.box(0.084, 0.0060, 0.0012), 0, 0, 0.0252)), __file__)
shapes.write("pins", shapes.merge(*[
    shapes.moved(shapes.box(0.0006, 0.0006, 0.0160, 0), -0.009 + 0.002 * i, s * 0.0118, 0.0190)
    for i in range(10) for s in (1, -1)]), __file__)
shapes.write("chips", shapes.merge(*[
    shapes.turned(shapes.moved(shapes.box(0.0024, 0.0049, 0.0025), 0.0128, 0, 0.0262), "z", 90 * k) for k in range(4)],
    shapes.moved(shapes.box(0.007, 0.007, 0.0012), -0.001, 0, BOARD - 0.0013)), __file__)
# The arrow on the deck that marks the front.
shapes.write("marks", shapes.merge(
    shapes.extrude([(0.0105, 0), (0.0065, 0.0032), (0.0065, -0.0032)], 0.02455, 0.02475),
    shapes.moved(shapes.box(0.0070, 0.0014, 0.0002, 0), 0.0032, 0.0052, 0.02465),
    shapes.moved(shapes.box(0.0070, 0.0014, 0.0002, 0), 0.0032, -0.0052, 0.02465)), __file__)


def light(x, y):
    return shapes.moved(shapes.box(0.0032, 0.0018, 0.0010), x, y, BOARD + 0.0012)


shapes.write("light_blue", shapes.merge(*[shapes.turned(light(0.0235, 0), "z", a) for a in (135, -135)]), __file__)
shapes.write("light_green", shapes.merge(*[shapes.turned(light(0.0235, 0), "z", a) for a in (45, -45)]), __file__)
shapes.write("marker", shapes.merge(
    shapes.moved(shapes.ball(0.0032, 16), 0, 0, 0.0318),
    shapes.lathe([(0.0007, 0.0250), (0.0007, 0.0290)], 10)), __file__)


def ring(radius, thickness, around=36, across=7):
    """A gate of the demonstration: a ring about the x axis."""
    points, triangles = [], []
    for i in range(around):
        a = 2 * math.pi * i / around
        for k in range(across):
            b = 2 * math.pi * k / across
            r = radius + thickness * math.cos(b)
            points.append((thickness * math.sin(b), r * math.cos(a), r * math.sin(a)))
            j, n = (i + 1) % around, (k + 1) % across
            p, q, s, t = i * across + k, j * across + k, j * across + n, i * across + n
            triangles += [(p, s, q), (p, t, s)]
    return points, triangles


shapes.write("ring", ring(0.15, 0.006), __file__)
