"""Visible meshes of the hexapod: body in its frame (x ahead), legs in the frames of their links (x outwards, z up)."""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

CORNERS = [(0.1248, 0.06164), (0.0, 0.1034), (-0.1248, 0.06164), (-0.1248, -0.06164), (0.0, -0.1034), (0.1248, -0.06164)]
TIBIA = 0.138


def write(name, *meshes):
    shapes.write(name, shapes.merge(*meshes), __file__)


def rounded(points, radius, steps=4):
    """A convex outline with rounded corners, counter-clockwise."""
    out, n = [], len(points)
    for i, (x, y) in enumerate(points):
        (ax, ay), (bx, by) = points[i - 1], points[(i + 1) % n]
        a0 = math.atan2(y - ay, x - ax) - math.pi / 2
        a1 = math.atan2(by - y, bx - x) - math.pi / 2
        while a1 < a0:
            a1 += 2 * math.pi
        for k in range(steps + 1):
            a = a0 + (a1 - a0) * k / steps
            out.append((x + radius * math.cos(a), y + radius * math.sin(a)))
    return out


def disc_y(radius, low, high, edge, segments=16):
    return shapes.turned(shapes.lathe(shapes.rounded_profile(radius, low, high, edge, 1), segments), "x", -90)


# Body: two plates with rounded ears at the coxa joints, servos and standoffs between, the board and the battery.
ears = rounded(CORNERS, 0.021, 5)
plates = [shapes.extrude(ears, z, z + 0.0035, 0.0008, 1) for z in (-0.0235, 0.0205)]
deck = shapes.extrude(rounded([(0.095, 0.036), (-0.095, 0.036), (-0.095, -0.036), (0.095, -0.036)], 0.012), 0.034, 0.037, 0.0008, 1)
write("plates", *plates, deck)
case = shapes.box(0.048, 0.032, 0.038, 0)
servos = []
for x, y in CORNERS:
    a = math.degrees(math.atan2(y, x * 0.55))
    servos.append(shapes.moved(shapes.turned(shapes.moved(case, -0.014, 0, 0), "z", a), x, y, 0.001))
battery = shapes.moved(shapes.box(0.11, 0.045, 0.030, 0.005, steps=2), -0.01, 0, 0)
write("servos", *servos, battery)
bolt = shapes.lathe(shapes.rounded_profile(0.0032, 0.024, 0.034, 0.0008, 1), 10)
horn = shapes.lathe(shapes.rounded_profile(0.011, 0.0235, 0.0265, 0.0008, 1), 14)
write("metal", *[shapes.moved(bolt, sx * 0.085, sy * 0.030) for sx in (1, -1) for sy in (1, -1)],
      *[shapes.moved(horn, x, y) for x, y in CORNERS],
      *[shapes.moved(horn, x, y, -0.0505) for x, y in CORNERS])
write("board", shapes.moved(shapes.box(0.075, 0.056, 0.002, 0), -0.005, 0, 0.039))
write("lights", *[shapes.moved(shapes.turned(shapes.lathe(shapes.rounded_profile(0.007, 0, 0.006, 0.002, 1), 16), "y", 90),
                               0.145, s * 0.024, 0.0) for s in (1, -1)],
      shapes.moved(shapes.box(0.018, 0.018, 0.006, 0.001, steps=1), -0.022, 0.008, 0.043))

# Coxa: the bracket on the body's servo and the femur's servo, which lies across the leg.
bracket = [shapes.moved(shapes.box(0.040, 0.026, 0.003, 0.001, steps=1), 0.012, 0, s * 0.0285) for s in (1, -1)]
back = shapes.moved(shapes.box(0.003, 0.028, 0.058, 0.001, steps=1), 0.031, 0, 0)
servo = shapes.moved(shapes.box(0.038, 0.034, 0.034, 0.003, steps=1), 0.048, 0, 0)
write("coxa", *bracket, back, servo)

# Femur: two plates from joint to joint, beside the servos, and a cross bar.
links = []
for s in (1, -1):
    plate = shapes.extrude(rounded([(0.0, 0.0), (0.0645, 0.0145), (0.0645, 0.0146), (0.0, 0.0002)], 0.0165, 3), 0, 0.003, 0.0007, 1)
    links.append(shapes.moved(shapes.turned(plate, "x", 90), 0, s * 0.0205 + 0.0015, 0))
bar = shapes.moved(shapes.turned(shapes.box(0.026, 0.038, 0.004, 0.001, steps=1), "y", -12.7), 0.033, 0, 0.0165)
write("femur", *links, bar)
write("femur_servo", shapes.moved(shapes.turned(shapes.box(0.040, 0.034, 0.026, 0.003, steps=1), "y", -12.7), 0.050, 0, 0.009))
write("horns", *[shapes.moved(disc_y(0.0095, -0.0012, 0.0012, 0.0004), x, s * 0.0232, z)
                 for s in (1, -1) for x, z in ((0, 0), (0.0645, 0.0145))])

# Tibia: two curved plates that taper to the foot, and the cap.
blade = []
stations = [(0.018, 0.000, 0.012), (0.008, 0.001, 0.017), (-0.010, 0.003, 0.018), (-0.035, 0.006, 0.016), (-0.065, 0.008, 0.013),
            (-0.095, 0.006, 0.010), (-0.118, 0.003, 0.008), (-0.128, 0.001, 0.006)]
for s in (1, -1):
    rings = []
    for z, x, a in reversed(stations):
        y = s * (0.0165 if z > -0.03 else 0.0165 - 0.0125 * min(1, (-0.03 - z) / 0.085))
        rings.append([(x + u, y + v, z) for u, v in shapes.rounded_rectangle(2 * a, 0.0034, 0.0015, 2)])
    blade.append(shapes.loft(rings))
write("tibia", *blade, shapes.moved(shapes.box(0.018, 0.030, 0.004, 0.001, steps=1), 0.006, 0, -0.045),
      shapes.moved(shapes.box(0.010, 0.014, 0.030, 0.003, steps=1), 0.0035, 0, -0.108))
write("cap", shapes.moved(shapes.lathe([(0.002, 0.0), (0.0045, 0.0009), (0.0063, 0.0036), (0.007, 0.007), (0.0074, 0.016),
                                        (0.0066, 0.020)], 20), 0, 0, -TIBIA))
