"""Meshes of the Thymio II, in its base frame: on the floor between the wheels. The axis of the wheels is z.

`track.ply` is the line on the floor of the demo.
"""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

WHEEL = 0.021       # radius, m
WIDTH = 0.015       # width of a wheel, m
FRONT = 0.0808      # radius of the front edge about the middle of the axle, m
BACK = -0.0305      # m
HALF = 0.0570       # half of the width, m
INNER = 0.0412      # half of the width between the wheels, m
ROOF = 0.0440       # lower end of the cover above the wheels, m
TOP = 0.0530        # m
PROX = [(63.4, 50.6, 39.3), (76.8, 27.0, 20.1), (81.6, 0.0, 0.0), (76.8, -27.0, -20.1), (63.4, -50.6, -40.1),
        (-30.7, 31.8, 180.0), (-30.7, -31.8, 180.0)]


def outline(half, corner=0.005, steps=18):
    """The robot from above: an arc ahead, straight sides, rounded corners behind; counter-clockwise from the right."""
    end = math.asin((half - 0.002) / FRONT)
    arc = [(FRONT * math.cos(a), FRONT * math.sin(a)) for a in [-end + 2 * end * i / steps for i in range(steps + 1)]]
    side = FRONT * math.cos(end) - 0.003
    back = []
    for k, (x, y) in enumerate([(BACK + corner, half - corner), (BACK + corner, -half + corner)]):
        for i in range(5):
            a = math.pi / 2 * (k + 1) + math.pi / 2 * i / 4
            back.append((x + corner * math.cos(a), y + corner * math.sin(a)))
    return arc + [(side, half)] + back + [(side, -half)]


def cover():
    """The top, with rounded edges above and straight ones below."""
    rim = outline(HALF)
    rings = [[(x, y, ROOF) for x, y in rim]]
    edge = 0.0035
    for i in range(5):
        a = math.pi / 2 * i / 4
        inner = shapes.inset(rim, edge * (1 - math.cos(a))) if i else rim
        rings.append([(x, y, TOP - edge + edge * math.sin(a)) for x, y in inner])
    return shapes.loft(rings)


def tub():
    """Parts below the cover: the body between the wheels, and a wing in front of each wheel and a strip behind it."""
    middle = outline(INNER, 0.004)
    parts = [shapes.extrude(middle, 0.0095, ROOF, 0.0012, 1)]
    for side in (1, -1):
        start, end = math.asin(INNER / FRONT) - 0.01, math.asin((HALF - 0.002) / FRONT)
        front = FRONT - 0.0006
        arc = [(front * math.cos(a), front * math.sin(a)) for a in [start + (end - start) * i / 6 for i in range(7)]]
        wing = arc + [(FRONT * math.cos(end) - 0.003, HALF - 0.0006), (0.0255, HALF - 0.0006), (0.0255, INNER - 0.001)]
        strip = [(-0.0250, INNER - 0.001), (-0.0250, HALF - 0.0006), (-0.0275, HALF - 0.0006),
                 (BACK + 0.0006, HALF - 0.004), (BACK + 0.0006, INNER - 0.001)]
        for form in (wing, strip):
            mesh = shapes.extrude(form, 0.0105, ROOF)
            parts.append(mesh if side > 0 else shapes.scaled(mesh, y=-1))
    return shapes.merge(*parts)


def dark():
    """Windows of the sensors, the hole for a pen, the slit below the cover, the sockets behind, the ground sensors."""
    parts = []
    for x, y, heading in PROX:
        h = math.radians(heading)
        x, y = x / 1000 - 0.0016 * math.cos(h), y / 1000 - 0.0016 * math.sin(h)
        parts.append(shapes.block(0.003, 0.0105, 0.0062, x, y, 0.0346, heading))
    parts.append(shapes.extrude(shapes.inset(outline(HALF), 0.0009), ROOF - 0.0008, ROOF + 0.0004))
    parts.append(shapes.disc(0.0058, TOP - 0.001, TOP + 0.0002, 28))
    parts.append(shapes.block(0.002, 0.009, 0.0045, BACK - 0.0003, 0, 0.0300))
    parts.append(shapes.block(0.002, 0.013, 0.0026, BACK - 0.0003, 0, 0.0222))
    socket = shapes.turned(shapes.disc(0.0026, 0.0300, 0.0309, 20), "y", -90)
    parts.append(shapes.moved(socket, y=0.013, z=0.0290))
    parts += [shapes.block(0.007, 0.006, 0.0016, 0.0736, y, 0.0092) for y in (0.012, -0.012)]
    for x in (-0.020, 0.062):
        parts += [shapes.disc(0.0024, TOP - 0.001, TOP + 0.0002, 16, x, y) for y in (0.032, -0.032)]
    return shapes.merge(*parts)


def grey():
    """The buttons: a disc and four arrows around it; rings around the hole for the pen and the lamps."""
    parts = [shapes.disc(0.0042, TOP - 0.001, TOP + 0.0008, 28, 0.034, 0)]
    for k in range(4):
        arrow = shapes.extrude([(0.0135, 0.0), (0.0068, 0.0052), (0.0068, -0.0052)], TOP - 0.001, TOP + 0.0007)
        parts.append(shapes.moved(shapes.turned(arrow, "z", 90 * k), x=0.034))
    parts.append(shapes.ring_of(0.0058, 0.0074, TOP - 0.001, TOP + 0.0004, 28))
    return shapes.merge(*parts)


def slider():
    return shapes.moved(shapes.ball(0.0096, 20), x=0.0612, z=0.0096)


def strips():
    """The two shining strips on top, left and right of the buttons."""
    parts = []
    for side in (1, -1):
        path = [(-0.012 + 0.068 * i / 10, side * (0.044 - 0.010 * max(0.0, (i - 5) / 5) ** 2)) for i in range(11)]
        outer = [(x, y + 0.0032) for x, y in path]
        inner = [(x, y - 0.0032) for x, y in path]
        points = [(x, y, z) for z in (TOP - 0.001, TOP + 0.0005) for x, y in inner + outer[::-1]]
        n = 2 * len(path)
        triangles = []
        for i in range(len(path) - 1):
            a, b, c, d = i, i + 1, n - 2 - i, n - 1 - i
            triangles += [(a + n, b + n, c + n), (a + n, c + n, d + n), (a, c, b), (a, d, c)]
        for i in range(n):
            j = (i + 1) % n
            triangles += [(i, j, j + n), (i, j + n, i + n)]
        parts.append((points, triangles))
    return shapes.merge(*parts)


def tyre():
    return shapes.ring_of(0.0160, WHEEL, -WIDTH / 2 + 0.0010, WIDTH / 2 - 0.0010, 56)


def rim():
    """A disc with a collar; identical at both ends, so that it fits left and right."""
    return shapes.merge(shapes.lathe(shapes.rounded_profile(0.0162, -0.0060, 0.0060, 0.0006, 2), 44),
                        shapes.ring_of(0.0140, 0.0163, -0.0070, 0.0070, 44), shapes.disc(0.0050, -0.0070, 0.0070, 24))


def holes():
    """Six holes around the hub, and one through it."""
    parts = [shapes.disc(0.0024, -0.0072, 0.0072, 12)]
    for k in range(6):
        a = math.pi / 3 * k
        parts.append(shapes.disc(0.0022, -0.0062, 0.0062, 14, 0.0095 * math.cos(a), 0.0095 * math.sin(a)))
    return shapes.merge(*parts)


def track(width=0.045, steps=180):
    """A closed band on the floor, along a curve that bends both ways."""
    def at(t):
        r = 0.42 + 0.075 * math.cos(3 * t) + 0.03 * math.sin(2 * t)
        return 1.25 * r * math.cos(t), r * math.sin(t)
    points, triangles = [], []
    for i in range(steps):
        t = 2 * math.pi * i / steps
        (x, y), (ax, ay), (bx, by) = at(t), at(t - 1e-4), at(t + 1e-4)
        dx, dy = bx - ax, by - ay
        n = math.hypot(dx, dy)
        dx, dy = dx / n, dy / n
        for side in (1, -1):
            points.append((x + side * dy * width / 2, y - side * dx * width / 2, 0.0))
    for i in range(steps):
        a, b = 2 * i, 2 * ((i + 1) % steps)
        triangles += [(a, b, b + 1), (a, b + 1, a + 1)]
    return points, triangles


for make in (cover, tub, dark, grey, slider, strips, tyre, rim, holes, track):
    shapes.write(make.__name__, make(), __file__)
