"""Writes the meshes of a half-litre bottle: body, neck, cap and label. It stands on z = 0."""
import math, pathlib, sys
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

RADIUS, SHOULDER, NECK_FROM, HEIGHT = 0.0325, 0.135, 0.190, 0.220

# A flat bottom with a round edge, a cylinder, and a shoulder that is a quarter of an ellipse cut off at the neck: convex,
# so that the collision shape matches the visible one.
body = [(RADIUS - 0.006, 0.0)]
body += [(RADIUS - 0.006 + 0.006 * math.sin(a), 0.006 - 0.006 * math.cos(a)) for a in (0.5, 1.0, math.pi / 2)]
rise = NECK_FROM - SHOULDER
for k in range(9):
    s = k / 8 * 0.92
    body.append((RADIUS * math.sqrt(1 - s * s), SHOULDER + s / 0.92 * rise))
shapes.write("body", shapes.lathe(body, 40), __file__)
shapes.write("neck", shapes.lathe([(0.0135, NECK_FROM - 0.006), (0.0135, 0.197), (0.0165, 0.198), (0.0165, 0.200), (0.0135, 0.201),
                                   (0.0135, 0.206)], 40), __file__)
# The cap is knurled: its radius alternates.
rings = []
for radius, z in ((0.0150, 0.203), (0.0155, 0.204), (0.0155, HEIGHT - 0.002), (0.0135, HEIGHT)):
    rings.append([((radius - 0.0005 * (i % 2)) * math.cos(2 * math.pi * i / 48),
                   (radius - 0.0005 * (i % 2)) * math.sin(2 * math.pi * i / 48), z) for i in range(48)])
shapes.write("cap", shapes.loft(rings), __file__)
shapes.write("label", shapes.lathe([(RADIUS, 0.060), (RADIUS + 0.0004, 0.0605), (RADIUS + 0.0004, 0.1145), (RADIUS, 0.115)], 40), __file__)
shapes.write("stripe", shapes.lathe([(RADIUS, 0.078), (RADIUS + 0.0007, 0.0785), (RADIUS + 0.0007, 0.0965), (RADIUS, 0.097)], 40), __file__)
