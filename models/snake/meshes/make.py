"""Visible meshes of the snake, in the frames of its modules: x ahead, z up, metres; the joints are at x +-0.032."""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

RADIUS = 0.026


def write(name, *meshes):
    shapes.write(name, shapes.merge(*meshes), __file__)


def along(profile, segments=28):
    """A body of revolution about x: (radius, x), from the tail."""
    return shapes.turned(shapes.lathe(profile, segments), "y", 90)


write("cover", along([(0.017, -0.0245), (0.0225, -0.0235), (0.0255, -0.020), (0.026, -0.015), (0.0245, -0.006), (0.0245, 0.006),
                      (0.026, 0.015), (0.0255, 0.020), (0.0225, 0.0235), (0.017, 0.0245)]))
tail = along([(0.0015, -0.078), (0.006, -0.074), (0.011, -0.060), (0.017, -0.038), (0.0225, -0.014), (0.0255, 0.008),
              (0.026, 0.016), (0.0225, 0.0235), (0.017, 0.0245)])
write("tail", tail)
# A joint: a hinge with an upright axle behind each module, and the yoke ahead of it.
hinge = shapes.moved(shapes.lathe(shapes.rounded_profile(0.0135, -0.019, 0.019, 0.003, 2), 20), -0.03195)
neck = along([(0.013, -0.034), (0.015, -0.024), (0.015, 0.024), (0.013, 0.034)], 16)
write("dark", hinge, neck)
# The head: broad and flat at the nose.
rings = []
for x, a, up, low in ((-0.024, 0.017, 0.017, 0.017), (-0.021, 0.024, 0.024, 0.024), (-0.010, 0.026, 0.026, 0.026),
                      (0.012, 0.029, 0.0255, 0.0245), (0.034, 0.031, 0.022, 0.021), (0.052, 0.027, 0.016, 0.017),
                      (0.064, 0.019, 0.010, 0.012), (0.070, 0.010, 0.005, 0.007)):
    rings.append([(x, a * math.cos(t), (up if math.sin(t) > 0 else low) * math.sin(t) - 0.0)
                  for t in (2 * math.pi * i / 28 for i in range(28))])
write("head", shapes.loft(rings))
write("eyes", *[shapes.moved(shapes.ball(0.0062, 14), 0.044, s * 0.0215, 0.0125) for s in (1, -1)])
# Passive wheels below each module; their rims touch the floor.
wheel = shapes.turned(shapes.lathe(shapes.rounded_profile(0.0085, -0.003, 0.003, 0.001, 1), 20), "x", 90)
write("wheels", *[shapes.moved(wheel, 0, s * 0.0165, 0.0085 - RADIUS) for s in (1, -1)])
