"""Writes the meshes of three traffic cones: foot, shell and reflecting bands. They stand on z = 0."""
import pathlib, sys
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import shapes

# Height and side of the foot, m, and the lower and upper edges of the bands, as fractions of the height.
CONES = {
    "450": (0.45, 0.27, [(0.52, 0.80)]),
    "700": (0.70, 0.36, [(0.38, 0.58), (0.70, 0.84)]),
    "900": (0.90, 0.38, [(0.38, 0.58), (0.70, 0.84)]),
}

for name, (height, side, bands) in CONES.items():
    foot_height = 0.05 * height
    bottom, top = 0.36 * side, 0.055 * height

    def radius(z):
        return bottom + (top - bottom) * (z - foot_height) / (height - foot_height)

    foot = shapes.extrude(shapes.rounded_rectangle(side, side, 0.22 * side, 8), 0, foot_height, 0.3 * foot_height)
    shapes.write(f"foot_{name}", foot, __file__)
    edge = 0.2 * top
    profile = [(bottom * 1.12, foot_height * 0.9), (bottom * 1.04, foot_height * 1.25), (radius(foot_height * 1.8), foot_height * 1.8)]
    profile += [(radius(height - edge), height - edge), (top - 0.35 * edge, height - 0.2 * edge), (top - edge, height)]
    shapes.write(f"shell_{name}", shapes.lathe(profile, 48), __file__)
    rings = []
    for low, high in bands:
        a, b = low * height, high * height
        rings.append(shapes.lathe([(radius(a), a), (radius(a) + 0.0015, a + 0.001), (radius(b) + 0.0015, b - 0.001), (radius(b), b)], 48))
    shapes.write(f"bands_{name}", shapes.merge(*rings), __file__)
