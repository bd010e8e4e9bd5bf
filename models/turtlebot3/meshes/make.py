"""Writes the meshes of the TurtleBot3 Burger: plates, wheels, motors, battery and scanner. All sizes in metres.

    python3 models/turtlebot3/meshes/make.py
"""
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes


def ring(outer, inner, low, high):
    """An upright wall between two outlines of equally many points, closed above and below."""
    n = len(outer)
    points = [(x, y, z) for z in (low, high) for outline in (outer, inner) for x, y in outline]
    triangles = []
    for i in range(n):
        j = (i + 1) % n
        for a, b, c, d in (
            (i, j, 2 * n + j, 2 * n + i),                      # outside
            (n + j, n + i, 3 * n + i, 3 * n + j),              # inside
            (2 * n + i, 2 * n + j, 3 * n + j, 3 * n + i),      # top
            (j, i, n + i, n + j),                              # bottom
        ):
            triangles += [(a, b, c), (a, c, d)]
    return points, triangles


def circle(radius, n, turn=0.0):
    return [(radius * math.cos(2 * math.pi * (i + turn) / n), radius * math.sin(2 * math.pi * (i + turn) / n)) for i in range(n)]


def bar(x0, y0, x1, y1, width, low, high):
    """A straight bar between two points of the plane."""
    length = math.hypot(x1 - x0, y1 - y0)
    mesh = shapes.moved(shapes.box(length, width, high - low), z=(low + high) / 2)
    mesh = shapes.turned(mesh, "z", math.degrees(math.atan2(y1 - y0, x1 - x0)))
    return shapes.moved(mesh, (x0 + x1) / 2, (y0 + y1) / 2)


# A plate: an octagon of 0.14 m with a lattice of ribs, as two moulded "waffles" side by side.
HALF, CUT, THICK, RIM = 0.070, 0.026, 0.004, 0.005
octagon = [(HALF, -HALF + CUT), (HALF, HALF - CUT), (HALF - CUT, HALF), (-HALF + CUT, HALF),
           (-HALF, HALF - CUT), (-HALF, -HALF + CUT), (-HALF + CUT, -HALF), (HALF - CUT, -HALF)]
# Rounded: each corner becomes three points.
outline = []
for i in range(8):
    (ax, ay), (bx, by), (cx, cy) = octagon[i - 1], octagon[i], octagon[(i + 1) % 8]
    for (px, py) in ((ax, ay), (cx, cy)):
        d = math.hypot(px - bx, py - by)
        outline.append((bx + (px - bx) * 0.004 / d, by + (py - by) * 0.004 / d))
pieces = [ring(outline, shapes.inset(outline, RIM), 0.0, THICK)]


def reach(c):
    """Extent of the octagon along one axis where the other coordinate is c, minus half of the rim."""
    return min(HALF, 2 * HALF - CUT - abs(c)) - RIM / 2


for c in (-0.056, -0.042, -0.028, -0.014, 0.0, 0.014, 0.028, 0.042, 0.056):
    wide = 0.0075 if c in (-0.028, 0.0, 0.028) else 0.0032
    pieces.append(bar(-reach(c), c, reach(c), c, wide, 0.0006, THICK - 0.0006))
    pieces.append(bar(c, -reach(c), c, reach(c), wide, 0.0004, THICK - 0.0004))
# Bosses for the screws.
for x in (-0.052, -0.026, 0.0, 0.026, 0.052):
    for y in (-0.052, 0.0, 0.052):
        if (x, y) != (0.0, 0.0):
            pieces.append(shapes.moved(shapes.lathe([(0.0058, 0.0001), (0.0058, THICK - 0.0001)], 12), x, y))
shapes.write("plate", shapes.merge(*pieces), __file__)

# The tyre: tread blocks around the rim, on a ring with rounded shoulders. The axle is z, the outer face +z.
R, W = 0.033, 0.018
loop = [(0.0265, -W / 2 + 0.001), (0.030, -W / 2), (R - 0.0012, -W / 2 + 0.002), (R - 0.0007, 0.0), (R - 0.0012, W / 2 - 0.002),
        (0.030, W / 2), (0.0265, W / 2 - 0.001)]
tyre = [shapes.revolve(loop)]
for i in range(30):
    for side in (-1, 1):
        block = shapes.box(0.0016, 0.0030, W / 2 - 0.0028)
        block = shapes.turned(block, "x", 14 * side)
        block = shapes.moved(block, x=R - 0.0009, z=side * W / 4)
        tyre.append(shapes.turned(block, "z", 12 * i + (6 if side > 0 else 0)))
shapes.write("tyre", shapes.merge(*tyre), __file__)

hub = [shapes.revolve([(0.0235, -W / 2 + 0.002), (0.0266, -W / 2 + 0.002), (0.0266, W / 2 - 0.002), (0.0235, W / 2 - 0.002)])]
for i in range(6):
    spoke = shapes.moved(shapes.box(0.016, 0.0075, 0.006), x=0.0165, z=0.0035)
    hub.append(shapes.turned(spoke, "z", 60 * i))
hub.append(shapes.lathe(shapes.rounded_profile(0.0115, -W / 2 + 0.002, W / 2 - 0.001, 0.001, 2), 36))
for i in range(4):
    hub.append(shapes.moved(shapes.lathe([(0.0017, W / 2 - 0.001), (0.0017, W / 2 + 0.0004)], 12), 0.008 * math.cos(math.pi * i / 2),
                            0.008 * math.sin(math.pi * i / 2)))
shapes.write("hub", shapes.merge(*hub), __file__)

# A servo, its shaft to the side at the front.
shapes.write("motor", shapes.box(0.0465, 0.034, 0.0285, 0.002), __file__)
shapes.write("battery", shapes.box(0.035, 0.088, 0.026, 0.004), __file__)

# The scanner: a housing with the belt's motor behind the turning head. Its foot is z = 0.
LOW = 0.019
hull = []
for i in range(25):
    t = -math.pi / 2 + math.pi * i / 24
    hull.append((0.000 + 0.0348 * math.cos(t), 0.0348 * math.sin(t)))
for i in range(13):
    t = math.pi / 2 + math.pi * i / 12
    hull.append((-0.034 + 0.022 * math.cos(t), 0.022 * math.sin(t)))
shapes.write("scanner_base", shapes.merge(
    shapes.extrude(hull, 0.0025, LOW, 0.003, 2),
    *[shapes.moved(shapes.lathe([(0.004, 0.0), (0.004, 0.005)], 16), x, y) for x in (-0.045, 0.018) for y in (-0.016, 0.016)],
), __file__)
shapes.write("scanner_head", shapes.lathe([(0.0300, LOW), (0.0300, 0.0205), (0.0335, 0.0215), (0.0335, 0.0365), (0.0315, 0.0372)], 48), __file__)
shapes.write("scanner_cap", shapes.merge(
    shapes.lathe(shapes.rounded_profile(0.0345, 0.0362, 0.0405, 0.0018, 2), 48),
    shapes.lathe([(0.0345, 0.0198), (0.0345, 0.0222)], 48),
), __file__)
