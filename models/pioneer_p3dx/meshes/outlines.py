#!/usr/bin/env python3
"""Writes the meshes of the body from the dimensions in model.toml: outlines seen from above, extruded.

    models/pioneer_p3dx/meshes/outlines.py
"""

import math
import pathlib

HEIGHT = 0.1388
AXLE = 0.0445
# A quarter of an outline, from the end to the side, as fractions of length and of half width.
CURVE = [(1.0, 0.36), (0.96, 0.57), (0.87, 0.76), (0.73, 0.91), (0.52, 1.0)]
# Radius and thickness of a sonar's disc, and distance of its face behind the sensor's origin.
DISC = (0.019, 0.006, 0.0005)
VREP = [
    (0.1064, 0.1382, 90), (0.1554, 0.1250, 50), (0.1906, 0.0831, 30), (0.2092, 0.0273, 10),
    (0.2092, -0.0273, -10), (0.1905, -0.0785, -30), (0.1555, -0.1202, -50), (0.1064, -0.1381, -90),
    (-0.1103, -0.1382, -90), (-0.1596, -0.1202, -130), (-0.1946, -0.0785, -150), (-0.2132, -0.0273, -170),
    (-0.2132, 0.0273, 170), (-0.1946, 0.0785, 150), (-0.1596, 0.1203, 130), (-0.1103, 0.1382, 90),
]
ARIA = [
    (69, 136, 90), (114, 119, 50), (148, 78, 30), (166, 27, 10),
    (166, -27, -10), (148, -78, -30), (114, -119, -50), (69, -136, -90),
    (-157, -136, -90), (-203, -119, -130), (-237, -78, -150), (-255, -27, -170),
    (-255, 27, 170), (-237, 78, 150), (-203, 119, 130), (-157, 136, 90),
]


def outline(front, back, half):
    """The corners of an outline, counter-clockwise from the front left."""
    def quarter(length, side):
        return [(length * along, side * half * across) for along, across in CURVE]
    return quarter(front, 1.0) + quarter(-back, 1.0)[::-1] + quarter(-back, -1.0) + quarter(front, -1.0)[::-1]


def hull(points):
    """The convex hull, counter-clockwise: the lower chain, then the upper one."""
    def chain(points):
        out = []
        for p in points:
            while len(out) > 1:
                a, b = out[-2:]
                if (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 1e-12:
                    break
                out.pop()
            out.append(p)
        return out[:-1]
    points = sorted(points)
    return chain(points) + chain(points[::-1])


def ring(sonars):
    """The corners of the sonar ring, which is flat behind each disc."""
    radius, thickness, behind = DISC
    back = behind + thickness / 2
    corners = []
    for x, y, heading in sonars:
        s, c = math.sin(math.radians(heading)), math.cos(math.radians(heading))
        corners += [(x - back * c - t * s, y - back * s + t * c) for t in (-radius, radius)]
    return hull(corners)


def loft(corners, levels):
    """Extrudes an outline through levels of height and inset, closed at the bottom and the top."""
    n = len(corners)
    far = max(math.hypot(x, y) for x, y in corners)
    points = []
    for z, inset in levels:
        # Scaling towards the middle approximates a bevel for a rounded outline.
        share = 1.0 - inset / far
        points += [(x * share, y * share, z) for x, y in corners]
    triangles = []
    for level in range(len(levels) - 1):
        for i in range(n):
            a, b = level * n + i, level * n + (i + 1) % n
            triangles += [(a, b, b + n), (a, b + n, a + n)]
    top = len(points) - n
    for i in range(1, n - 1):
        triangles += [(0, i + 1, i), (top, top + i, top + i + 1)]
    return points, triangles


def write(name, mesh):
    points, triangles = mesh
    lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
    lines += [f"property double {axis}" for axis in "xyz"]
    lines += [f"element face {len(triangles)}", "property list uchar uint vertex_indices", "end_header"]
    lines += [" ".join(repr(x) for x in p) for p in points]
    lines += [" ".join(map(str, (3, *t))) for t in triangles]
    (pathlib.Path(__file__).parent / f"{name}.ply").write_text("\n".join(lines) + "\n")


def main():
    low, mid, deck, top = (z - HEIGHT for z in (0.06, 0.187, 0.2293, 0.237))
    shell = outline(0.222, 0.222, 0.1365)
    write("shell", loft(shell, [(low, 0.018), (low + 0.022, 0.0), (mid - 0.006, 0.0), (mid, 0.006)]))
    aria = [(x / 1000 + AXLE, y / 1000, heading) for x, y, heading in ARIA]
    decks = {"vrep": (0.2595, 0.2595, 0.2075), "sheet": (AXLE + 0.210, -AXLE + 0.301, 0.1905)}
    for preset, sonars in (("vrep", VREP), ("sheet", aria)):
        write(f"ring_{preset}", loft(ring(sonars), [(mid, 0.0), (deck, 0.0)]))
        write(f"deck_{preset}", loft(outline(*decks[preset]), [(deck, 0.0), (top - 0.002, 0.0), (top, 0.002)]))


if __name__ == "__main__":
    main()
