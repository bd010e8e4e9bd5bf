#!/usr/bin/env python3
"""Write the meshes of hull and cabin from their cross sections.

    models/manta/meshes/hulls.py
"""

import pathlib

# Cross sections: x, half of the width, lower and upper edge, m. Estimates, after the outline of a flat sports car between
# its wheels.
HULL = [
    (-0.175, 0.105, 0.020, 0.070),
    (-0.150, 0.125, -0.030, 0.088),
    (0.000, 0.135, -0.055, 0.092),
    (0.160, 0.138, -0.060, 0.086),
    (0.360, 0.138, -0.060, 0.072),
    (0.560, 0.132, -0.055, 0.052),
    (0.700, 0.118, -0.045, 0.030),
    (0.780, 0.095, -0.038, 0.006),
    (0.805, 0.060, -0.028, -0.010),
]
CABIN = [
    (-0.060, 0.070, 0.060, 0.090),
    (0.060, 0.088, 0.060, 0.136),
    (0.180, 0.092, 0.060, 0.142),
    (0.270, 0.088, 0.060, 0.122),
    (0.400, 0.074, 0.050, 0.068),
]
# One side of a section, from bottom to top: fractions of the half width and of the height.
SIDE = [(0.80, 0.0), (0.96, 0.12), (1.0, 0.45), (0.93, 0.75), (0.75, 0.93), (0.42, 1.0)]


def hull(sections):
    """Joins cross sections from back to front, with rounded upper edges and closed ends."""
    n = 2 * len(SIDE)
    points, triangles = [], []
    for x, half, low, high in sections:
        for side, corners in ((-1.0, SIDE), (1.0, SIDE[::-1])):
            points += [(x, side * half * w, low + (high - low) * h) for w, h in corners]
    for level in range(len(sections) - 1):
        for i in range(n):
            a, b = level * n + i, level * n + (i + 1) % n
            triangles += [(a, a + n, b + n), (a, b + n, b)]
    front = len(points) - n
    for i in range(1, n - 1):
        triangles += [(0, i, i + 1), (front, front + i + 1, front + i)]
    return points, triangles


def write(name, mesh):
    points, triangles = mesh
    lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
    lines += [f"property double {axis}" for axis in "xyz"]
    lines += [f"element face {len(triangles)}", "property list uchar uint vertex_indices", "end_header"]
    lines += [" ".join(repr(x) for x in p) for p in points]
    lines += [" ".join(map(str, (3, *t))) for t in triangles]
    (pathlib.Path(__file__).parent / f"{name}.ply").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    write("hull", hull(HULL))
    write("cabin", hull(CABIN))
