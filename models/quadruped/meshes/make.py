"""Visible meshes of the quadruped, in the frames of its links: x ahead, y left, z up, metres."""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

THIGH = 0.213
CALF = 0.213


def along_x(sections, corner=0.5, steps=5):
    """A body along x: sections (x, half width, bottom, top), their corners rounded by a fraction of the lesser half."""
    rings = []
    for x, half, low, high in sections:
        radius = corner * min(half, (high - low) / 2)
        outline = shapes.rounded_rectangle(2 * half, high - low, radius, steps)
        rings.append([(x, u, v + (low + high) / 2) for u, v in outline])
    return shapes.loft(rings)


def disc_y(radius, low, high, edge, segments=36):
    """A disc with rounded edges about y."""
    return shapes.turned(shapes.lathe(shapes.rounded_profile(radius, low, high, edge, 3), segments), "x", -90)


def plate(stations, steps=4):
    """A link along -z: stations (z, x of the middle, half length along x, y of the middle, half width along y)."""
    rings = []
    for z, x, a, y, b in stations:
        outline = shapes.rounded_rectangle(2 * a, 2 * b, 0.75 * min(a, b), steps)
        rings.append([(x + u, y + v, z) for u, v in outline])
    return shapes.loft(rings)


# The trunk: a long cover, narrow between the hips, and the neck that carries the head.
trunk = along_x([
    (-0.150, 0.040, -0.030, 0.040), (-0.146, 0.054, -0.046, 0.053), (-0.136, 0.061, -0.055, 0.060),
    (-0.060, 0.067, -0.058, 0.066), (0.040, 0.067, -0.058, 0.066), (0.126, 0.061, -0.055, 0.060),
    (0.142, 0.054, -0.046, 0.053), (0.148, 0.040, -0.030, 0.040)], 0.55)
# Covers of the hips' motors, in front and at the rear.
ends = [along_x([
    (s * 0.130, 0.040, -0.036, 0.044), (s * 0.140, 0.050, -0.046, 0.052), (s * 0.222, 0.047, -0.044, 0.048),
    (s * 0.232, 0.042, -0.038, 0.043), (s * 0.236, 0.030, -0.026, 0.032)][::s], 0.6) for s in (1, -1)]
shell = along_x([
    (0.222, 0.036, -0.030, 0.036), (0.228, 0.043, -0.036, 0.043), (0.250, 0.047, -0.040, 0.047),
    (0.268, 0.046, -0.040, 0.044), (0.276, 0.040, -0.036, 0.036)], 0.8)
shapes.write("trunk", shapes.merge(trunk, shell), __file__)

# Dark parts of the trunk: motor covers, a band along each side, the handle on the back, the battery below.
band = shapes.merge(*[shapes.moved(shapes.box(0.21, 0.006, 0.030, 0.0028, 0.0028), 0.0, s * 0.0662, 0.012) for s in (1, -1)])
handle = shapes.tube([(-0.07, 0, 0.060), (-0.066, 0, 0.074), (-0.055, 0, 0.081), (0.055, 0, 0.081), (0.066, 0, 0.074),
                      (0.07, 0, 0.060)], 0.006, 12)
battery = shapes.moved(shapes.box(0.15, 0.084, 0.012, 0.005, 0.012), 0, 0, -0.060)
shapes.write("dark", shapes.merge(*ends, band, handle, battery), __file__)

# The face: a dark visor with two lights, and the slots of cameras below.
visor = along_x([(0.262, 0.040, -0.034, 0.036), (0.274, 0.041, -0.034, 0.034), (0.281, 0.038, -0.031, 0.030),
                 (0.285, 0.029, -0.023, 0.021)], 0.8)
shapes.write("face", visor, __file__)
eyes = [shapes.moved(shapes.turned(shapes.lathe(shapes.rounded_profile(0.0075, 0, 0.003, 0.001, 1), 16), "y", 90),
                     0.2825, s * 0.022, 0.010) for s in (1, -1)]
stripe = [shapes.moved(shapes.box(0.05, 0.002, 0.003), 0.06, s * 0.0693, 0.012) for s in (1, -1)]
shapes.write("lights", shapes.merge(*eyes, *stripe), __file__)

# A left hip: the motor's housing between hip joint and thigh.
hip = shapes.merge(disc_y(0.044, 0.020, 0.064, 0.006, 32),
                   shapes.turned(shapes.lathe(shapes.rounded_profile(0.036, -0.045, 0.045, 0.006, 3), 24), "y", 90))
shapes.write("hip", hip, __file__)

# A thigh: a shell around motor and knee, tapering to the knee.
stations = [(0.046, 0, 0.012, 0, 0.010), (0.043, 0, 0.024, 0, 0.014), (0.034, 0, 0.037, 0, 0.017), (0.018, 0, 0.046, 0, 0.018),
            (0.0, 0, 0.049, 0, 0.018), (-0.02, 0, 0.046, 0, 0.018), (-0.05, 0.002, 0.036, 0, 0.017),
            (-0.09, 0.004, 0.026, 0, 0.015), (-0.15, 0.003, 0.020, 0, 0.013), (-0.195, 0.001, 0.0175, 0, 0.012),
            (-0.215, 0, 0.0165, 0, 0.012), (-0.226, 0, 0.012, 0, 0.010), (-0.230, 0, 0.006, 0, 0.006)]
thigh = plate(list(reversed(stations)))
shapes.write("thigh", thigh, __file__)
motor = shapes.merge(disc_y(0.041, 0.008, 0.026, 0.005, 30), disc_y(0.026, 0.020, 0.030, 0.003, 24),
                     shapes.moved(disc_y(0.0135, -0.018, 0.015, 0.003, 18), 0, 0, -THIGH))
shapes.write("motor", motor, __file__)

# The calf: a thin shell, wide at the knee and bent slightly forward, and the ball of the foot.
calf = plate([(-0.212, 0, 0.008, 0, 0.007), (-0.195, 0.001, 0.0085, 0, 0.0075), (-0.150, 0.004, 0.0095, 0, 0.008),
              (-0.090, 0.006, 0.0115, 0, 0.0085), (-0.040, 0.005, 0.0135, 0, 0.009), (-0.010, 0.001, 0.0145, 0, 0.0095),
              (0.006, -0.001, 0.012, 0, 0.009), (0.013, -0.001, 0.006, 0, 0.006)])
shapes.write("calf", calf, __file__)
foot = shapes.merge(shapes.moved(shapes.ball(0.02, 20), 0, 0, -CALF),
                    shapes.moved(shapes.lathe([(0.0165, -0.006), (0.0145, 0.008), (0.0105, 0.018)], 20), 0, 0, -CALF + 0.008))
shapes.write("foot", foot, __file__)
