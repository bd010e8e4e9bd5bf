"""Writes the meshes of traffic signs, of full size and 1:8: layers of flat shapes, each in one color.

A sign is defined as seen from the front, u to the right, v up, about its middle, and then rotated to face +x."""
import math, pathlib, sys
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes


def polygon(n, inner_radius, turn=0.0, corner=0.0):
    """A regular polygon, given by its inner radius, with round corners."""
    outer = inner_radius / math.cos(math.pi / n)
    out = []
    for k in range(n):
        a = turn + 2 * math.pi * k / n
        if corner <= 0:
            out.append((outer * math.cos(a), outer * math.sin(a)))
            continue
        m = outer - corner / math.cos(math.pi / n)
        for i in range(7):
            b = a + math.pi / n * (2 * i / 6 - 1)
            out.append((m * math.cos(a) + corner * math.cos(b), m * math.sin(a) + corner * math.sin(b)))
    return out


def disc(radius, n=48):
    return [(radius * math.cos(2 * math.pi * i / n), radius * math.sin(2 * math.pi * i / n)) for i in range(n)]


def face(outline, z):
    """Only the front of a flat shape; its back is never visible."""
    n = len(outline)
    middle = (sum(u for u, v in outline) / n, sum(v for u, v in outline) / n, z)
    return [(u, v, z) for u, v in outline] + [middle], [(n, i, (i + 1) % n) for i in range(n)]


def bar(a, b, width):
    """A stroke from a to b with round ends."""
    (ax, ay), (bx, by) = a, b
    t = math.atan2(by - ay, bx - ax)
    half = [(math.cos(t - math.pi / 2 + math.pi * i / 4), math.sin(t - math.pi / 2 + math.pi * i / 4)) for i in range(5)]
    r = width / 2
    return [(bx + r * x, by + r * y) for x, y in half] + [(ax - r * x, ay - r * y) for x, y in half]


def arc(cx, cy, rx, ry, first, last, n=8):
    return [(cx + rx * math.cos(math.radians(first + (last - first) * i / n)),
             cy + ry * math.sin(math.radians(first + (last - first) * i / n))) for i in range(n + 1)]


# Letters and digits as strokes, in a field 0.6 wide and 1 high, about its middle.
GLYPHS = {
    "S": [arc(0, 0.24, 0.26, 0.22, 25, 270) + arc(0, -0.24, 0.26, 0.24, 90, -155)[1:]],
    "T": [[(-0.28, 0.46), (0.28, 0.46)], [(0, 0.46), (0, -0.48)]],
    "O": [arc(0, 0, 0.27, 0.48, 0, 360, 14)],
    "P": [[(-0.22, -0.48), (-0.22, 0.46), (0.05, 0.46)] + arc(0.03, 0.22, 0.23, 0.24, 90, -90)[1:] + [(-0.22, -0.02)]],
    "0": [arc(0, 0, 0.25, 0.48, 0, 360, 14)],
    "3": [arc(-0.02, 0.23, 0.25, 0.23, 150, -90) + arc(-0.02, -0.24, 0.28, 0.24, 90, -150)[1:]],
    "5": [[(0.22, 0.46), (-0.20, 0.46), (-0.23, 0.06)] + arc(-0.02, -0.16, 0.28, 0.31, 125, -145)],
}


def text(word, height, pitch, stroke):
    """Outlines of a word about the origin."""
    out = []
    for k, letter in enumerate(word):
        x = (k - (len(word) - 1) / 2) * pitch
        for path in GLYPHS[letter]:
            path = [(x + u * height, v * height) for u, v in path]
            out += [bar(a, b, stroke) for a, b in zip(path, path[1:])]
    return out


up = math.pi / 2
OCTAGON = lambda r: polygon(8, r, math.pi / 8, 0.02)
DOWN = lambda r: polygon(3, r, -up, 0.05)
# For each sign: layers from the back to the front. Sizes in m of the full-size sign.
SIGNS = {
    "stop": {"plate": [OCTAGON(0.45)], "red": [OCTAGON(0.432)], "white": text("STOP", 0.30, 0.208, 0.046)},
    "yield": {"plate": [DOWN(0.26)], "red": [DOWN(0.252)], "white": [DOWN(0.165)]},
    "speed_30": {"plate": [disc(0.30)], "red": [disc(0.294)], "white": [disc(0.225)], "black": text("30", 0.26, 0.19, 0.042)},
    "speed_50": {"plate": [disc(0.30)], "red": [disc(0.294)], "white": [disc(0.225)], "black": text("50", 0.26, 0.19, 0.042)},
    "no_entry": {"plate": [disc(0.30)], "red": [disc(0.294)],
                 "white": [[(0.225, -0.05), (0.225, 0.05), (-0.225, 0.05), (-0.225, -0.05)]]},
    "priority": {"plate": [polygon(4, 0.30, 0, 0.04)], "white": [polygon(4, 0.294, 0, 0.038)], "yellow": [polygon(4, 0.20, 0, 0.02)]},
    "keep_right": {"plate": [disc(0.30)], "blue": [disc(0.294)],
                   "white": [bar((-0.11, 0.11), (0.12, -0.12), 0.07), bar((0.12, -0.12), (-0.04, -0.12), 0.07),
                             bar((0.12, -0.12), (0.12, 0.04), 0.07)]},
}
LAYERS = ["plate", "red", "blue", "white", "yellow", "black"]

folder = pathlib.Path(__file__).parent
for scale, size in ((1.0, "full"), (0.125, "small")):
    (folder / size).mkdir(exist_ok=True)
    step = 0.0012 if size == "full" else 0.0003
    for sign, layers in SIGNS.items():
        front = 0.0
        for layer in LAYERS:
            if layer not in layers:
                continue
            low, front = front, front + (0.004 if layer == "plate" else 1.0) * (step if layer != "plate" else max(scale, 0.3))
            outlines = [[(scale * u, scale * v) for u, v in o] for o in layers[layer]]
            forms = [shapes.extrude(o, low, front) if layer == "plate" else face(o, front) for o in outlines]
            points, triangles = shapes.merge(*forms)
            # u, v and the distance to the front become y, z and x: a rotation, so the triangles still face outwards.
            shapes.write(f"{sign}_{layer}", ([(w, u, v) for u, v, w in points], triangles), folder / size / "x")
