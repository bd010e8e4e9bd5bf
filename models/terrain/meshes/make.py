"""Writes the terrain's meshes: 6 m x 6 m, about the origin, flat at the edge. `terrain.lua` stretches them to other sizes."""
import math, pathlib, sys
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

SIZE, CELLS, HEIGHT = 6.0, 26, 0.5


def noise(ix, iy, seed):
    """A deterministic pseudo-random value between 0 and 1 for a point of a grid."""
    n = (ix * 374761393 + iy * 668265263 + seed * 2147483647) & 0xFFFFFFFF
    n = ((n ^ (n >> 13)) * 1274126177) & 0xFFFFFFFF
    return ((n ^ (n >> 16)) & 0xFFFF) / 65535


def smooth(x, y, seed):
    ix, iy = math.floor(x), math.floor(y)
    u, v = (t * t * (3 - 2 * t) for t in (x - ix, y - iy))
    a, b, c, d = (noise(ix + i, iy + j, seed) for i, j in ((0, 0), (1, 0), (0, 1), (1, 1)))
    return (a * (1 - u) + b * u) * (1 - v) + (c * (1 - u) + d * u) * v


# For each hill: position of its top and width, as fractions of the size, and height.
HILLS = [(0.28, 0.30, 0.085, 0.75), (0.70, 0.26, 0.10, 1.0), (0.50, 0.55, 0.07, 0.6), (0.25, 0.72, 0.09, 0.9), (0.75, 0.72, 0.075, 0.7)]


def crater(u, v):
    rim = max(0.0, 1 - abs(math.hypot(u - 0.5, v - 0.5) - 0.26) / 0.16)
    return rim * rim * (3 - 2 * rim)


FORMS = {
    "hills": lambda u, v: sum(a * math.exp(-((u - x) ** 2 + (v - y) ** 2) / (2 * s * s)) for x, y, s, a in HILLS)
    + 0.08 * smooth(8 * u, 8 * v, 11),
    "waves": lambda u, v: 0.5 - 0.5 * math.cos(2 * math.pi * 4 * u),
    "rough": lambda u, v: 0.25 * noise(round(u * CELLS), round(v * CELLS), 3) + 0.1 * smooth(6 * u, 6 * v, 9),
    "crater": crater,
}

for name, form in FORMS.items():
    raw = {}
    for i in range(CELLS + 1):
        for j in range(CELLS + 1):
            u, v = i / CELLS, j / CELLS
            edge = min(1.0, 6 * min(u, 1 - u, v, 1 - v))
            raw[i, j] = form(u, v) * edge * edge * (3 - 2 * edge)
    most = max(raw.values())
    points = [(SIZE * (i / CELLS - 0.5), SIZE * (j / CELLS - 0.5), HEIGHT * raw[i, j] / most)
              for i in range(CELLS + 1) for j in range(CELLS + 1)]
    index = lambda i, j: i * (CELLS + 1) + j
    triangles = []
    for i in range(CELLS):
        for j in range(CELLS):
            a, b, c, d = index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)
            # Diagonals alternate, so that slopes are not smoother in one direction.
            triangles += [(a, b, c), (a, c, d)] if (i + j) % 2 else [(a, b, d), (b, c, d)]
    shapes.write(name, (points, triangles), __file__)
