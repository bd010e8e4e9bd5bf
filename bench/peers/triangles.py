"""The room of scenes.py as triangles, raw float32, for embree_limit.cpp.

    python triangles.py [--mesh] FILE

12 triangles a box, 2 for the floor, 100,000 for the mesh.
"""
import argparse
import array
import math

import scenes

FACES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
         (1, 5, 7), (1, 7, 3)]


def triangles(with_mesh):
    room = scenes.room()
    out = array.array("f")
    for x, y, z, hx, hy, hz, yaw in room["boxes"] + room["walls"]:
        c, s = math.cos(yaw), math.sin(yaw)
        corners = []
        for i in (-hx, hx):
            for j in (-hy, hy):
                for k in (-hz, hz):
                    corners.append((x + c * i - s * j, y + s * i + c * j, z + k))
        for face in FACES:
            for corner in face:
                out.extend(corners[corner])
    floor = [(-20, -20, 0), (20, -20, 0), (20, 20, 0), (-20, 20, 0)]
    for corner in (0, 1, 2, 0, 2, 3):
        out.extend(floor[corner])
    if with_mesh:
        vertices, faces = scenes.mesh()
        for face in faces:
            for corner in face:
                out.extend(a + b for a, b in zip(vertices[corner], scenes.MESH_CENTRE))
    return out


def main():
    ap = argparse.ArgumentParser()
    ap.add_argument("--mesh", action="store_true", help="add the 100k-triangle mesh")
    ap.add_argument("file")
    a = ap.parse_args()
    with open(a.file, "wb") as f:
        triangles(a.mesh).tofile(f)


if __name__ == "__main__":
    main()
