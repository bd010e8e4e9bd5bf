"""Writes the room of `scenes.py` as raw 32-bit floats, nine per triangle, the input of `embree_limit.cpp`.

    python triangles.py [--mesh] OUT
"""
import argparse
import array
import itertools
import math

import scenes

CORNERS = list(itertools.product((-1, 1), repeat=3))
FACES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
         (1, 5, 7), (1, 7, 3)]


def triangles(with_mesh):
    """Returns the triangles of the room: 12 per box, 2 for the floor, and 100,000 for the mesh."""
    room = scenes.room()
    for b in room["boxes"] + room["walls"]:
        cos, sin = math.cos(b[6]), math.sin(b[6])
        half = [[s * h for s, h in zip(corner, b[3:6])] for corner in CORNERS]
        turned = [(b[0] + cos * x - sin * y, b[1] + sin * x + cos * y, b[2] + z) for x, y, z in half]
        for face in FACES:
            yield [turned[i] for i in face]
    floor = [(-20, -20, 0), (20, -20, 0), (20, 20, 0), (-20, 20, 0)]
    yield [floor[i] for i in (0, 1, 2)]
    yield [floor[i] for i in (0, 2, 3)]
    if with_mesh:
        vertices, faces = scenes.mesh()
        at = [[x + c for x, c in zip(v, scenes.MESH_CENTRE)] for v in vertices]
        for face in faces:
            yield [at[i] for i in face]


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument("--mesh", action="store_true")
    ap.add_argument("out")
    args = ap.parse_args()
    numbers = array.array("f")
    for triangle in triangles(args.mesh):
        for corner in triangle:
            numbers.extend(corner)
    with open(args.out, "wb") as f:
        numbers.tofile(f)


if __name__ == "__main__":
    main()
