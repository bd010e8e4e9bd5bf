"""Writes the surface details of balls of real size about the origin: the football's pentagons and seams, the tennis
ball's seam, and the marble's ribbons."""
import itertools, math, pathlib, sys
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes


def unit(p):
    length = math.sqrt(sum(c * c for c in p))
    return tuple(c / length for c in p)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def patch(corners, radius, steps=4):
    """A patch of a sphere: a convex polygon of unit vectors, counter-clockwise from outside, projected onto it."""
    middle = unit([sum(c) for c in zip(*corners)])
    points, triangles = [], []
    for a, b in zip(corners, corners[1:] + corners[:1]):
        rows = []
        for i in range(steps + 1):
            row = []
            for j in range(i + 1):
                t = i / steps
                s = j / i if i else 0
                p = unit([(1 - t) * m + t * ((1 - s) * u + s * v) for m, u, v in zip(middle, a, b)])
                row.append(len(points))
                points.append(tuple(radius * c for c in p))
            rows.append(row)
        for upper, lower in zip(rows, rows[1:]):
            for j in range(len(upper)):
                triangles.append((upper[j], lower[j], lower[j + 1]))
                if j + 1 < len(upper):
                    triangles.append((upper[j], lower[j + 1], upper[j + 1]))
    return points, triangles


# The football: a truncated icosahedron. Its pentagons are centred on the vertices of an icosahedron.
GOLDEN = (1 + math.sqrt(5)) / 2
corners = [unit(p) for a, b in itertools.product((1, -1), (GOLDEN, -GOLDEN)) for p in ((0, a, b), (a, b, 0), (b, 0, a))]
RADIUS = 0.11
pentagons, seams = [], []
for corner in corners:
    near = sorted(corners, key=lambda q: -sum(x * y for x, y in zip(corner, q)))[1:6]
    side = unit(cross(corner, near[0]))
    ahead = cross(side, corner)
    near.sort(key=lambda q: math.atan2(sum(x * y for x, y in zip(q, side)), sum(x * y for x, y in zip(q, ahead))))
    # A third of the way to each neighbour, in the order of the angle about the vertex.
    ring = [unit([(2 * c + q) / 3 for c, q in zip(corner, n)]) for n in near]
    if sum(x * y for x, y in zip(cross(ring[0], ring[1]), corner)) < 0:
        ring.reverse()
    pentagons.append(patch(ring, RADIUS + 0.0006))
    for n, start in ((n, unit([(2 * c + q) / 3 for c, q in zip(corner, n)])) for n in near):
        if corners.index(n) > corners.index(corner):
            end = unit([(c + 2 * q) / 3 for c, q in zip(corner, n)])
            path = [unit([(1 - k / 6) * s + k / 6 * e for s, e in zip(start, end)]) for k in range(7)]
            seams.append(shapes.tube([tuple((RADIUS - 0.0004) * c for c in p) for p in path], 0.0009, 4))
shapes.write("pentagons", shapes.merge(*pentagons), __file__)
shapes.write("seams", shapes.merge(*seams), __file__)


def seam(radius, width, count):
    """The closed curve of a tennis ball's seam, as a tube in its surface."""
    path = []
    for k in range(count + 1):
        t = 2 * math.pi * k / count
        # x = A cos t + B cos 3t, y = A sin t - B sin 3t, z = C sin 2t lies on a sphere if C^2 = 4 A B, A + B = 1.
        A, B = 0.75, 0.25
        p = unit((A * math.cos(t) + B * math.cos(3 * t), A * math.sin(t) - B * math.sin(3 * t), 2 * math.sqrt(A * B) * math.sin(2 * t)))
        path.append(tuple(radius * c for c in p))
    return shapes.tube(path, width, 6)


shapes.write("tennis_seam", seam(0.0332, 0.0009, 120), __file__)
shapes.write("marble_ribbon", seam(0.00745, 0.0006, 80), __file__)
