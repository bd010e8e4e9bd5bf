"""Writes the meshes of the Heron beside this file, m, in its base frame; floats and ducts about their own centres."""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes  # noqa: E402


def section(x, half, low, high, full):
    """A closed cross-section of the float: a round bilge below, a flat deck above."""
    ring = []
    n = 14
    for k in range(n + 1):
        a = math.pi * k / n
        c, s = math.cos(a), math.sin(a)
        y = half * math.copysign(abs(c) ** full, c)
        z = high - (high - low) * abs(s) ** full
        ring.append((x, y, z))
    return ring


def floats():
    """One float: fine at the bow, which rises, and full at the stern."""
    rings = []
    for x, half, low, high in (
            (-0.640, 0.078, -0.120, -0.004), (-0.625, 0.092, -0.150, 0.002), (-0.58, 0.100, -0.166, 0.006),
            (-0.42, 0.106, -0.176, 0.008), (-0.20, 0.110, -0.180, 0.010), (0.05, 0.110, -0.180, 0.012),
            (0.18, 0.108, -0.180, 0.014), (0.29, 0.102, -0.177, 0.016), (0.38, 0.093, -0.171, 0.019),
            (0.46, 0.081, -0.162, 0.022), (0.53, 0.066, -0.149, 0.025), (0.59, 0.049, -0.129, 0.029),
            (0.635, 0.031, -0.100, 0.032), (0.662, 0.017, -0.068, 0.035), (0.675, 0.006, -0.040, 0.036)):
        rings.append(list(reversed(section(x, half, low, high, 0.75))))
    return shapes.loft(rings)


def panel():
    """The cover on a float's deck."""
    side = [(-0.53, 0.050), (-0.51, 0.060), (0.20, 0.062), (0.32, 0.057), (0.42, 0.047), (0.49, 0.034), (0.525, 0.020),
            (0.538, 0.006)]
    outline = [(x, -y) for x, y in side] + [(x, y) for x, y in reversed(side)]
    return shapes.extrude(outline, 0.002, 0.048, 0.014, 3)


def fan(hand):
    """Three blades about z."""
    rings = []
    for i in range(6):
        t = i / 5
        r = 0.010 + 0.022 * t
        chord, pitch = 0.018 * (0.6 + 1.1 * t - 1.2 * t * t), math.radians(50 - 22 * t) * hand
        ring = []
        for k in range(8):
            a = 2 * math.pi * k / 8
            y, z = chord / 2 * math.cos(a), 0.0012 * math.sin(a)
            ring.append((r, y * math.cos(pitch) - z * math.sin(pitch), y * math.sin(pitch) + z * math.cos(pitch)))
        rings.append(ring)
    blade = shapes.loft(rings)
    return shapes.merge(*[shapes.turned(blade, "z", 120 * k) for k in range(3)],
                        shapes.lathe(shapes.rounded_profile(0.011, -0.014, 0.016, 0.005, 3), 20))


def duct():
    """A ring about x, the motor in front of it and the strut to the float."""
    profile = [(0.036, -0.022), (0.0385, -0.024), (0.040, -0.018), (0.0405, 0.0), (0.040, 0.020), (0.0375, 0.024),
               (0.035, 0.018), (0.0345, 0.0)]
    points, triangles = [], []
    n, m = 32, len(profile)
    for i in range(n):
        a = 2 * math.pi * i / n
        points += [(z, r * math.cos(a), r * math.sin(a)) for r, z in profile]
    for i in range(n):
        j = (i + 1) % n
        for k in range(m):
            q = (k + 1) % m
            triangles += [(i * m + k, i * m + q, j * m + q), (i * m + k, j * m + q, j * m + k)]
    motor = shapes.turned(shapes.lathe(
        [(0.004, -0.060), (0.012, -0.055), (0.017, -0.040), (0.017, 0.020), (0.013, 0.030)], 24), "y", -90)
    strut = shapes.moved(shapes.box(0.050, 0.010, 0.060, 0.004, steps=2), 0.028, 0, 0.045)
    vane = shapes.moved(shapes.box(0.020, 0.0022, 0.024), 0.002, 0, 0.025)
    vanes = [shapes.turned(vane, "x", a) for a in (60, 180, 300)]
    return shapes.merge((points, triangles), shapes.moved(motor, 0.02), strut, *vanes)


def main():
    write = lambda name, mesh: shapes.write(name, mesh, __file__)  # noqa: E731
    write("float", floats())
    write("panel", panel())
    # Two bars carry the case between the floats.
    write("beams", shapes.merge(*[
        shapes.moved(shapes.turned(shapes.box(0.030, 0.040, 0.70, 0.010, steps=2), "x", 90), x, 0, -0.010)
        for x in (0.20, -0.25)]))
    write("case", shapes.merge(
        shapes.moved(shapes.box(0.56, 0.34, 0.10, 0.022, steps=2), -0.02, 0, -0.002),
        shapes.moved(shapes.box(0.20, 0.24, 0.045, 0.016, steps=2), 0.24, 0, -0.010)))
    write("lid", shapes.moved(shapes.box(0.50, 0.285, 0.022, 0.010, steps=2), -0.02, 0, 0.058))
    write("trim", shapes.merge(
        *[shapes.moved(shapes.box(0.030, 0.012, 0.030, 0.004, steps=1), x, s * 0.172, 0.040)
          for x in (-0.20, 0.0, 0.16) for s in (1, -1)],
        shapes.moved(shapes.box(0.030, 0.10, 0.014, 0.005, steps=2), 0.15, 0, 0.074),
        shapes.moved(shapes.box(0.014, 0.014, 0.016, 0.003, steps=1), 0.15, 0.048, 0.066),
        shapes.moved(shapes.box(0.014, 0.014, 0.016, 0.003, steps=1), 0.15, -0.048, 0.066)))
    write("mast", shapes.merge(
        shapes.tube([(-0.23, 0.12, 0.05), (-0.23, 0.12, 0.30), (-0.228, 0.105, 0.345), (-0.226, 0.06, 0.36),
                     (-0.226, -0.06, 0.36), (-0.228, -0.105, 0.345), (-0.23, -0.12, 0.30), (-0.23, -0.12, 0.05)],
                    0.009, 14),
        shapes.moved(shapes.lathe([(0.0045, 0.36), (0.0045, 0.50)], 12), -0.226, -0.06, 0),
        shapes.moved(shapes.lathe([(0.0025, 0.50), (0.0018, 0.72)], 10), -0.226, -0.06, 0)))
    write("antenna", shapes.merge(
        shapes.moved(shapes.lathe(
            [(0.030, 0.0), (0.036, 0.004), (0.037, 0.012), (0.033, 0.022), (0.022, 0.030), (0.008, 0.034)], 32),
            -0.226, 0.05, 0.366),
        shapes.moved(shapes.lathe([(0.016, 0.0), (0.018, 0.003), (0.016, 0.010), (0.006, 0.013)], 24),
                     0.015, 0.05, 0.066)))
    write("lamp", shapes.moved(
        shapes.lathe([(0.010, 0.0), (0.012, 0.004), (0.012, 0.018), (0.008, 0.024)], 20), -0.226, 0, 0.366))
    write("duct", duct())
    write("propeller_left", fan(1))
    write("propeller_right", fan(-1))


main()
