"""Writes the meshes of the AscTec Pelican beside this file, m. Heights are above the base frame."""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes  # noqa: E402

ARM = 0.21           # distance of the rotors from the centre
RADIUS = 0.128       # radius of a propeller
BEAM = 0.012         # height of the arms' middle


def blade(sign):
    """One blade along +x: a twisted, tapering section. `sign` is 1 for counter-clockwise turning."""
    rings, n = [], 12
    for i in range(n + 1):
        t = i / n
        r = 0.010 + (RADIUS - 0.010) * t
        chord = 0.026 * (0.50 + 1.75 * t - 1.85 * t * t + 0.12 * t ** 3) * (1 if t < 0.97 else 0.6)
        pitch = math.radians(34 - 25 * t) * sign
        ring = []
        for k in range(8):
            a = 2 * math.pi * k / 8
            y, z = chord / 2 * math.cos(a), 0.0018 * (1 - 0.6 * t) * math.sin(a)
            y -= 0.004 * t * t * sign
            ring.append((r, y * math.cos(pitch) - z * math.sin(pitch), y * math.sin(pitch) + z * math.cos(pitch)))
        rings.append(ring)
    return shapes.loft(rings)


def propeller(sign):
    one = blade(sign)
    hub = shapes.lathe(shapes.rounded_profile(0.0115, -0.0035, 0.0035, 0.0012, 2), 28)
    return shapes.merge(one, shapes.turned(one, "z", 180), hub)


def plate(size, z, thickness=0.002):
    """A square plate whose corners are cut."""
    return shapes.extrude(shapes.rounded_rectangle(size, size, 0.014, 4), z - thickness / 2, z + thickness / 2)


def arm():
    """A beam along +x with a clamp at the tower and a seat for the motor."""
    beam = shapes.moved(shapes.turned(shapes.box(0.015, 0.013, 0.150, 0.002, steps=2), "y", 90), 0.125, 0, BEAM)
    clamp = shapes.moved(shapes.box(0.030, 0.024, 0.021, 0.004, steps=2), 0.050, 0, BEAM)
    seat = shapes.moved(shapes.lathe(shapes.rounded_profile(0.0165, BEAM - 0.009, BEAM + 0.010, 0.002, 2), 28), ARM)
    return shapes.merge(beam, clamp, seat)


def motor():
    base = shapes.lathe(
        [(0.0125, BEAM + 0.010), (0.0125, BEAM + 0.014), (0.0100, BEAM + 0.0145), (0.0100, BEAM + 0.016)], 32)
    bell = shapes.lathe([(0.0130, BEAM + 0.016), (0.0140, BEAM + 0.017), (0.0140, BEAM + 0.028), (0.0120, BEAM + 0.031),
                         (0.0040, BEAM + 0.032), (0.0035, 0.047)], 32)
    return shapes.merge(base, bell)


def leg():
    """A leg below an arm, bent outwards, with a foot."""
    path = [(0.085, 0, 0.006), (0.092, 0, -0.010), (0.110, 0, -0.034), (0.135, 0, -0.064), (0.149, 0, -0.082),
            (0.155, 0, -0.088)]
    rod = shapes.tube(path, [0.0050, 0.0046, 0.0042, 0.0042, 0.0042, 0.0042], 10)
    return shapes.merge(rod, shapes.moved(shapes.ball(0.012, 16), 0.155, 0, -0.088))


shapes.write("propeller_ccw", propeller(1), __file__)
shapes.write("propeller_cw", propeller(-1), __file__)
shapes.write("spinner", shapes.lathe([(0.0062, 0.0035), (0.0060, 0.0070), (0.0046, 0.0100), (0.0020, 0.0118)], 24),
             __file__)
shapes.write("arm", arm(), __file__)
shapes.write("motor", motor(), __file__)
shapes.write("leg", leg(), __file__)
shapes.write("plates", shapes.merge(
    *[plate(size, z) for size, z in ((0.090, -0.022), (0.104, 0.0), (0.104, 0.024), (0.096, 0.050), (0.096, 0.076))]),
             __file__)
shapes.write("posts", shapes.merge(*[
    shapes.moved(shapes.lathe([(0.0028, -0.024), (0.0028, 0.082)], 14), x * 0.038, y * 0.038)
    for x in (1, -1) for y in (1, -1)]), __file__)
shapes.write("battery", shapes.moved(shapes.box(0.110, 0.044, 0.034, 0.005, steps=2), 0, 0, -0.042), __file__)
strap = shapes.box(0.014, 0.0452, 0.0352, 0.003, steps=2)
shapes.write("strap", shapes.merge(*[shapes.moved(strap, x, 0, -0.042) for x in (0.028, -0.028)]), __file__)
board = shapes.box(0.070, 0.070, 0.0018)
shapes.write("boards", shapes.merge(*[shapes.moved(board, 0, 0, z) for z in (0.032, 0.058)]), __file__)
shapes.write("chips", shapes.merge(
    shapes.moved(shapes.box(0.026, 0.026, 0.006, 0.001, steps=1), 0.008, 0, 0.036),
    shapes.moved(shapes.box(0.040, 0.034, 0.010, 0.002, steps=1), -0.004, 0, 0.064),
    shapes.moved(shapes.box(0.010, 0.052, 0.008, 0.001, steps=1), -0.030, 0, 0.037)), __file__)
# A rounded cover on the tower.
shapes.write("cover", shapes.loft([
    [(x, y, z) for x, y in shapes.rounded_rectangle(size, size, size * 0.3)]
    for size, z in ((0.078, 0.077), (0.078, 0.084), (0.075, 0.089), (0.068, 0.0925), (0.056, 0.0945))]), __file__)
shapes.write("bar", shapes.merge(
    shapes.moved(shapes.box(0.196, 0.010, 0.0024, 0.001, steps=1), 0, 0, 0.0945 - 0.0026),
    *[shapes.moved(shapes.lathe([(0.002, 0.093), (0.002, 0.099)], 10), s * 0.09) for s in (1, -1)]), __file__)
shapes.write("marker", shapes.ball(0.007, 16), __file__)
