"""Writes the meshes of a person 1.75 m tall. Torso and head are in the frame of the floor below them; a limb begins at its
joint and hangs down."""
import math, pathlib, sys
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

THIGH, SHIN, ANKLE, UPPER_ARM = 0.429, 0.4305, 0.068, 0.3255


def ovals(rows, segments=32):
    """A loft of ovals: z, half depth along x, half width along y, and forward offset of the middle."""
    turns = [2 * math.pi * i / segments for i in range(segments)]
    return shapes.loft([[(ahead + a * math.cos(t), b * math.sin(t), z) for t in turns] for z, a, b, ahead in rows])


def limb(rows, segments=24):
    """A loft from the top down: distance from the joint, radius, and forward offset."""
    return ovals([(-d, r, r, ahead) for d, r, ahead in reversed(rows)], segments)


shirt = ovals([(0.93, 0.09, 0.14, 0), (0.945, 0.112, 0.162, 0), (1.02, 0.108, 0.155, 0), (1.12, 0.112, 0.160, 0.004),
               (1.24, 0.122, 0.176, 0.008), (1.34, 0.118, 0.186, 0.004), (1.40, 0.105, 0.182, 0), (1.435, 0.085, 0.155, -0.004),
               (1.46, 0.068, 0.095, -0.006), (1.475, 0.055, 0.062, -0.006)])
shapes.write("shirt", shirt, __file__)
hips = ovals([(0.83, 0.07, 0.10, 0), (0.845, 0.098, 0.148, 0), (0.90, 0.112, 0.168, 0), (0.955, 0.106, 0.158, 0)])
shapes.write("hips", hips, __file__)
belt = ovals([(0.935, 0.110, 0.160, 0), (0.938, 0.1155, 0.1655, 0), (0.966, 0.1145, 0.1635, 0), (0.969, 0.10, 0.15, 0)])
shapes.write("belt", belt, __file__)

neck = ovals([(1.45, 0.052, 0.056, -0.008), (1.50, 0.050, 0.052, -0.004), (1.56, 0.050, 0.052, 0.0)], 24)
head = ovals([(1.522, 0.03, 0.03, 0.045), (1.53, 0.052, 0.045, 0.034), (1.555, 0.080, 0.060, 0.014), (1.59, 0.094, 0.070, 0.004),
              (1.63, 0.099, 0.076, 0.0), (1.67, 0.097, 0.077, -0.004), (1.705, 0.084, 0.069, -0.008), (1.73, 0.058, 0.050, -0.010),
              (1.743, 0.02, 0.02, -0.010)])
nose = shapes.moved(shapes.scaled(shapes.ball(0.02, 12), 1.0, 0.6, 1.3), 0.100, 0, 1.622)
ears = [shapes.moved(shapes.scaled(shapes.ball(0.03, 12), 0.6, 0.35, 1.0), -0.005, y, 1.625) for y in (0.076, -0.076)]
shapes.write("head", shapes.merge(neck, head, nose, *ears), __file__)
hair = ovals([(1.60, 0.058, 0.076, -0.046), (1.64, 0.070, 0.083, -0.036), (1.68, 0.094, 0.084, -0.012), (1.715, 0.088, 0.076, -0.010),
              (1.738, 0.062, 0.056, -0.012), (1.75, 0.02, 0.02, -0.012)])
shapes.write("hair", hair, __file__)
shapes.write("eyes", shapes.merge(*[shapes.moved(shapes.ball(0.009, 10), 0.090, y, 1.645) for y in (0.03, -0.03)]), __file__)

thigh = limb([(-0.055, 0.05, 0), (-0.03, 0.078, 0), (0.02, 0.086, 0), (0.15, 0.079, 0.004), (0.30, 0.066, 0.004), (0.40, 0.059, 0.002),
              (THIGH + 0.02, 0.057, 0), (THIGH + 0.04, 0.045, 0), (THIGH + 0.05, 0.02, 0)])
shapes.write("thigh", thigh, __file__)
shin = limb([(-0.045, 0.03, 0), (-0.03, 0.05, 0), (0.0, 0.057, 0), (0.10, 0.060, -0.008), (0.20, 0.056, -0.008), (0.32, 0.047, 0),
             (SHIN - 0.03, 0.048, 0.004), (SHIN + 0.005, 0.050, 0.006), (SHIN + 0.012, 0.035, 0.006)])
shapes.write("shin", shin, __file__)
# The shoe: heel 7 cm behind the ankle, toe 19 cm ahead; the sole is 6.8 cm below it.
outline = []
for i in range(40):
    t = 2 * math.pi * i / 40
    x = 0.06 + 0.13 * math.cos(t)
    outline.append((x, math.sin(t) * (0.046 if x > 0.06 else 0.038) * (1 + 0.12 * math.cos(t))))
sole = shapes.extrude(outline, -ANKLE, -ANKLE + 0.022, 0.006)
shapes.write("sole", sole, __file__)
rings = []
for z, low in ((-0.050, 1.0), (-0.030, 0.96), (-0.010, 0.72), (0.012, 0.50), (0.026, 0.42)):
    reach = {1.0: 0.19, 0.96: 0.18, 0.72: 0.125, 0.50: 0.070, 0.42: 0.055}[low]
    rings.append([(-0.065 + (x + 0.07) / 0.26 * (reach + 0.065), y * (0.75 + 0.25 * low), z) for x, y in outline])
shapes.write("shoe", shapes.loft(rings), __file__)

sleeve = limb([(-0.034, 0.022, 0), (-0.024, 0.040, 0), (0.0, 0.053, 0), (0.10, 0.052, 0), (0.22, 0.048, 0), (0.225, 0.03, 0)], 24)
shapes.write("sleeve", sleeve, __file__)
upper = limb([(0.20, 0.036, 0), (0.26, 0.038, 0), (UPPER_ARM, 0.037, 0), (UPPER_ARM + 0.02, 0.02, 0)], 20)
lower = limb([(-0.02, 0.02, 0), (0.0, 0.037, 0), (0.08, 0.037, 0), (0.20, 0.027, 0), (0.25, 0.024, 0), (0.26, 0.015, 0)], 20)
palm = shapes.moved(shapes.scaled(shapes.ball(0.05, 20), 0.85, 0.42, 1.15), 0, 0, -0.305)
fingers = shapes.moved(shapes.scaled(shapes.ball(0.05, 20), 0.65, 0.36, 1.1), 0.012, 0, -0.365)
thumb = shapes.turned(shapes.scaled(shapes.ball(0.02, 12), 0.6, 0.6, 1.8), "y", -30)
fore = shapes.merge(lower, palm, fingers, shapes.moved(thumb, 0.04, 0, -0.305))
# The elbow is bent by 15 degrees.
bent = shapes.moved(shapes.turned(fore, "y", -15), 0, 0, -UPPER_ARM)
shapes.write("arm", shapes.merge(upper, bent), __file__)
