"""Writes the meshes of the UR5 and UR5e: foot, caps and necks of the joints, tool flange. Metres."""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

LARGE, ELBOW, SMALL = 0.0585, 0.055, 0.039    # radii of the housings
UPPER_TUBE, FORE_TUBE = 0.045, 0.0375         # radii of the tubes


def cap(radius, height):
    """A lid that closes a housing: a groove, a band, and a slightly domed top. It begins at z = 0."""
    round_ = 0.45 * height
    profile = [(radius - 0.0025, -0.001), (radius, 0.0015), (radius, height - round_)]
    for i in range(1, 4):
        a = math.pi / 2 * i / 3
        profile.append((radius - round_ * (1 - math.cos(a)), height - round_ * (1 - math.sin(a))))
    profile.append((0.5 * radius, height + 0.0012))
    return shapes.lathe(profile)


def neck(housing, tube, length):
    """The transition from the middle of a housing (z = 0) to its tube, with a collar at the end."""
    wide = 0.94 * housing
    profile = [(wide, 0.0), (wide, 0.62 * housing)]
    for i in range(1, 4):
        s = i / 3
        smooth = s * s * (3 - 2 * s)
        profile.append((wide + (tube + 0.002 - wide) * smooth, 0.62 * housing + s * (length - 0.62 * housing)))
    profile += [(tube + 0.002, length + 0.012), (tube - 0.002, length + 0.0135)]
    return shapes.lathe(profile)


def foot():
    """The mounting plate with four lugs for M8 screws, and the beginning of the column."""
    plate = shapes.lathe(shapes.rounded_profile(0.0745, 0.0, 0.012, 0.002, 2))
    collar = shapes.lathe([(0.066, 0.011), (0.064, 0.0135), (0.0585, 0.02)])
    screw = shapes.lathe(shapes.rounded_profile(0.0065, 0.011, 0.0165, 0.001, 1), 16)
    screws = []
    for i in range(4):
        a = math.pi / 4 + i * math.pi / 2
        screws.append(shapes.moved(screw, 0.066 * math.cos(a), 0.066 * math.sin(a)))
    return shapes.merge(plate, collar, *screws)


def flange():
    """The last joint, from its seam at z = -0.038 to the mounting face at z = 0."""
    body = [(SMALL - 0.001, -0.038), (SMALL, -0.037), (SMALL, -0.013), (SMALL - 0.0025, -0.0105)]
    disc = [(0.0315, -0.0085), (0.0315, -0.0006), (0.0308, 0.0)]
    return shapes.lathe(body + disc)


for name, mesh in {
    "foot": foot(),
    "cap_large": cap(LARGE, 0.016),
    "cap_elbow": cap(ELBOW, 0.016),
    "cap_small": cap(SMALL, 0.012),
    "neck_large": neck(LARGE, UPPER_TUBE, 0.088),
    "neck_elbow": neck(ELBOW, FORE_TUBE, 0.085),
    "neck_small": neck(SMALL, FORE_TUBE, 0.046),
    "flange": flange(),
}.items():
    shapes.write(name, mesh, __file__)
