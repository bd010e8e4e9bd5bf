"""Meshes of the Franka hand: the housing, from its flange to the guide of the fingers, and a finger.

The housing is in the frame of panda_hand: z away from the arm, y along the fingers' guide. Its sizes and
roundings are estimates by eye. The finger follows the boxes of franka_description, with rounded edges.
"""
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes


def section(half_x, half_y, power, count=44):
    """A rounded cross-section: an ellipse for a power of 2, nearly a rectangle for a high one."""
    out = []
    for i in range(count):
        a = 2 * math.pi * (i + 0.5) / count
        c, s = math.cos(a), math.sin(a)
        out.append((math.copysign(abs(c) ** (2 / power), c) * half_x, math.copysign(abs(s) ** (2 / power), s) * half_y))
    return out


def housing():
    rings = []
    for z, half_x, half_y, power in (
        (0.0000, 0.0310, 0.0330, 2.0), (0.0060, 0.0315, 0.0345, 2.0), (0.0075, 0.0316, 0.0480, 2.3),
        (0.0105, 0.0317, 0.0640, 2.7), (0.0150, 0.0318, 0.0780, 3.0), (0.0210, 0.0319, 0.0890, 3.4),
        (0.0290, 0.0320, 0.0970, 3.8), (0.0380, 0.0320, 0.1010, 4.2), (0.0480, 0.0320, 0.1022, 4.5),
        (0.0570, 0.0318, 0.1018, 4.5), (0.0625, 0.0308, 0.1005, 4.5), (0.0655, 0.0285, 0.0980, 4.5),
        (0.0660, 0.0265, 0.0960, 4.5),
    ):
        rings.append([(x, y, z) for x, y in section(half_x, half_y, power)])
    shapes.write("housing", shapes.loft(rings), __file__)


def finger():
    """A finger with its face at y = 0: the slide, the slanted neck, and the tip with its pad."""
    foot = shapes.moved(shapes.box(0.0216, 0.0150, 0.0196, 0.0022, steps=2), 0.0, 0.0185, 0.0110)
    plate = shapes.moved(shapes.box(0.0216, 0.0086, 0.0040, 0.0008, steps=2), 0.0, 0.0068, 0.0022)
    neck = shapes.turned(shapes.box(0.0175, 0.0072, 0.0270, 0.0018, steps=2), "x", 30)
    neck = shapes.moved(neck, 0.0, 0.0153, 0.0284)
    tip = shapes.moved(shapes.box(0.0175, 0.0125, 0.0185, 0.0022, steps=2), 0.0, 0.00895, 0.04525)
    shapes.write("finger", shapes.merge(foot, plate, neck, tip), __file__)


housing()
finger()
