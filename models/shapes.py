"""Parametric meshes of models: lathed, extruded and rounded shapes, written as PLY.

Scripts `models/NAME/meshes/make.py` import this module. A mesh is a pair of lists: points (x, y, z) in metres, and
triangles of indices, counter-clockwise seen from outside. Requires Python 3.8 and no other packages.
"""

import math
import pathlib


def merge(*meshes):
    """Joins meshes into one."""
    points, triangles = [], []
    for p, t in meshes:
        n = len(points)
        points += p
        triangles += [(a + n, b + n, c + n) for a, b, c in t]
    return points, triangles


def moved(mesh, x=0.0, y=0.0, z=0.0):
    """The mesh, translated."""
    points, triangles = mesh
    return [(a + x, b + y, c + z) for a, b, c in points], triangles


def scaled(mesh, x=1.0, y=1.0, z=1.0):
    """The mesh, scaled along each axis. A negative factor mirrors it; the triangles still face outwards."""
    points, triangles = mesh
    if x * y * z < 0:
        triangles = [(a, c, b) for a, b, c in triangles]
    return [(a * x, b * y, c * z) for a, b, c in points], triangles


def turned(mesh, axis, degrees):
    """The mesh, rotated about an axis of its frame: "x", "y" or "z"."""
    s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    turn = {
        "x": lambda p: (p[0], c * p[1] - s * p[2], s * p[1] + c * p[2]),
        "y": lambda p: (c * p[0] + s * p[2], p[1], c * p[2] - s * p[0]),
        "z": lambda p: (c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]),
    }[axis]
    points, triangles = mesh
    return [turn(p) for p in points], triangles


def loft(rings):
    """Joins closed rings of equally many points, one above the other; fans close the first and the last ring.

    Rings run counter-clockwise seen from the end of the loft. A ring with a fan must be star-shaped about its middle.
    """
    n = len(rings[0])
    points = [p for ring in rings for p in ring]
    triangles = []
    for level in range(len(rings) - 1):
        for i in range(n):
            a, b = level * n + i, level * n + (i + 1) % n
            triangles += [(a, b, b + n), (a, b + n, a + n)]
    for first, flip in ((0, True), ((len(rings) - 1) * n, False)):
        ring = points[first:first + n]
        middle = len(points)
        points.append(tuple(sum(axis) / n for axis in zip(*ring)))
        for i in range(n):
            a, b = first + i, first + (i + 1) % n
            triangles.append((middle, b, a) if flip else (middle, a, b))
    return points, triangles


def lathe(profile, segments=48):
    """A body of revolution about z. The profile lists (radius, z) from the bottom to the top, radii above 0."""
    turns = [2 * math.pi * i / segments for i in range(segments)]
    return loft([[(r * math.cos(t), r * math.sin(t), z) for t in turns] for r, z in profile])


def rounded_profile(radius, low, high, edge, steps=4):
    """The profile of a cylinder with rounded edges, for `lathe`."""
    arc = [math.pi / 2 * i / steps for i in range(steps + 1)]
    bottom = [(radius - edge + edge * math.sin(a), low + edge - edge * math.cos(a)) for a in arc]
    top = [(radius - edge + edge * math.cos(a), high - edge + edge * math.sin(a)) for a in arc]
    return bottom + top


def rounded_rectangle(length, width, corner, steps=6):
    """An outline about the origin, counter-clockwise from the right of the front."""
    out = []
    for k, (sx, sy) in enumerate([(1, -1), (1, 1), (-1, 1), (-1, -1)]):
        for i in range(steps + 1):
            a = math.pi / 2 * (k - 1) + math.pi / 2 * i / steps
            out.append((sx * (length / 2 - corner) + corner * math.cos(a), sy * (width / 2 - corner) + corner * math.sin(a)))
    return out


def inset(outline, by):
    """A convex outline, offset inwards by a distance, with the same number of points."""
    n = len(outline)
    out = []
    for i in range(n):
        (ax, ay), (bx, by_), (cx, cy) = outline[i - 1], outline[i], outline[(i + 1) % n]
        d1, d2 = (bx - ax, by_ - ay), (cx - bx, cy - by_)
        l1, l2 = math.hypot(*d1) or 1.0, math.hypot(*d2) or 1.0
        nx, ny = -d1[1] / l1 - d2[1] / l2, d1[0] / l1 + d2[0] / l2
        length = math.hypot(nx, ny) or 1.0
        nx, ny = nx / length, ny / length
        half = max(0.3, (-d1[1] * nx + d1[0] * ny) / l1)
        out.append((bx + nx * by / half, by_ + ny * by / half))
    return out


def extrude(outline, low, high, edge=0.0, steps=3):
    """A convex outline (counter-clockwise from above) between two heights, with rounded edges."""
    if edge <= 0:
        return loft([[(x, y, z) for x, y in outline] for z in (low, high)])
    rings = []
    for i in range(steps + 1):
        a = math.pi / 2 * i / steps
        ring = inset(outline, edge * (1 - math.sin(a)))
        rings.append([(x, y, low + edge * (1 - math.cos(a))) for x, y in ring])
    top = [[(x, y, low + high - z) for x, y, z in ring] for ring in reversed(rings)]
    return loft(rings + top)


def box(length, width, height, edge=0.0, corner=None, steps=3):
    """A box about the origin with rounded edges; `corner` rounds the four upright ones further."""
    corner = edge if corner is None else corner
    outline = rounded_rectangle(length, width, corner, max(steps, 3)) if corner > 0 else [
        (length / 2, -width / 2), (length / 2, width / 2), (-length / 2, width / 2), (-length / 2, -width / 2)]
    return extrude(outline, -height / 2, height / 2, min(edge, corner), steps)


def tube(path, radius, segments=16):
    """A round bar along a path of points; `radius` is one value or a list of one per point. Bends should be gentle."""
    radii = radius if isinstance(radius, (list, tuple)) else [radius] * len(path)
    rings, side = [], None
    for i, p in enumerate(path):
        a, b = path[max(i - 1, 0)], path[min(i + 1, len(path) - 1)]
        d = [y - x for x, y in zip(a, b)]
        length = math.sqrt(sum(x * x for x in d))
        d = [x / length for x in d]
        if side is None:
            side = (0.0, 0.0, 1.0) if abs(d[2]) < 0.9 else (1.0, 0.0, 0.0)
        along = sum(x * y for x, y in zip(side, d))
        side = [s - along * x for s, x in zip(side, d)]
        length = math.sqrt(sum(x * x for x in side))
        side = [x / length for x in side]
        up = (d[1] * side[2] - d[2] * side[1], d[2] * side[0] - d[0] * side[2], d[0] * side[1] - d[1] * side[0])
        turns = [2 * math.pi * k / segments for k in range(segments)]
        rings.append([tuple(c + radii[i] * (math.cos(t) * s + math.sin(t) * u) for c, s, u in zip(p, side, up)) for t in turns])
    return loft(rings)


def ball(radius, segments=32):
    """A sphere about the origin."""
    half = segments // 2
    angles = [math.pi * (i / half - 0.5) for i in range(half + 1)]
    return lathe([(max(radius * math.cos(a), radius * 1e-3), radius * math.sin(a)) for a in angles], segments)


def revolve(loop, segments=40):
    """A ring of revolution about z from a closed loop of (radius, z), counter-clockwise with the radius to the right."""
    n, points, triangles = len(loop), [], []
    for i in range(segments):
        t = 2 * math.pi * i / segments
        points += [(r * math.cos(t), r * math.sin(t), z) for r, z in loop]
    for i in range(segments):
        for k in range(n):
            a, b = i * n + k, i * n + (k + 1) % n
            c, d = (i + 1) % segments * n + (k + 1) % n, (i + 1) % segments * n + k
            triangles += [(a, c, b), (a, d, c)]
    return points, triangles


def ring_of(inner, outer, low, high, segments=48):
    """A ring about z with a square section."""
    points, triangles = [], []
    for i in range(segments):
        c, s = math.cos(2 * math.pi * i / segments), math.sin(2 * math.pi * i / segments)
        points += [(r * c, r * s, z) for r, z in ((outer, low), (outer, high), (inner, high), (inner, low))]
    for i in range(segments):
        for k in range(4):
            a, b = 4 * i + k, 4 * i + (k + 1) % 4
            c, d = 4 * ((i + 1) % segments) + k, 4 * ((i + 1) % segments) + (k + 1) % 4
            triangles += [(a, c, d), (a, d, b)]
    return points, triangles


def disc(radius, low, high, segments=24, x=0.0, y=0.0):
    """A disc about an axis parallel to z."""
    return moved(lathe([(radius, low), (radius, high)], segments), x, y)


def block(length, width, height, x, y, z, heading=0.0):
    """A box, turned about z by `heading` degrees."""
    return moved(turned(box(length, width, height), "z", heading), x, y, z)


def write(name, mesh, beside):
    """Writes a mesh as `NAME.ply` beside a script (its `__file__`), rounded to 0.01 mm."""
    points, triangles = mesh
    lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
    lines += [f"property float {axis}" for axis in "xyz"]
    lines += [f"element face {len(triangles)}", "property list uchar uint vertex_indices", "end_header"]
    lines += [" ".join(f"{round(c, 5) + 0.0:g}" for c in p) for p in points]
    lines += [f"3 {a} {b} {c}" for a, b, c in triangles]
    (pathlib.Path(beside).parent / f"{name}.ply").write_text("\n".join(lines) + "\n", encoding="ascii")
