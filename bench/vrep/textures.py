"""Renders V-REP scenes with textured shapes on one sheet, with the names of the files.

    python bench/vrep/textures.py FOLDER [--program target/release/tatu] [--out docs/images/vrep_textures.png]

FOLDER contains the scenes. Requires the package pillow.
"""
import argparse
import os
import subprocess
import tempfile
from pathlib import Path

from PIL import Image, ImageDraw

ROOT = Path(__file__).resolve().parents[2]
#: Each file, and a view (from, to) in which its textured floor, walls or parts are visible.
VIEWS = {
    "v40700_pioneer_p3dx": None,
    "v40000_GPS-Compass": None,
    "v30200_LineFollower1": None,
    "v30203_Lab2_Environment": None,
    "v30301_Pioneer_p3dx_traj_DEMO": None,
    "v30602_challenge_scenario": None,
    "v40000_ur10-rg2-rack-bottles-box": None,
    "v40000_simplus_e-puck": ("0.12,-0.15,0.14", "0,0,0.02"),
    "v40100_scene_youbot_navigation": None,
    "v40600_pioneer_p3dx_wall": None,
}
WIDTH, HEIGHT, LINE, COLUMNS = 232, 145, 16, 2


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--program", default=str(ROOT / "target/release/tatu"))
    parser.add_argument("--out", type=Path, default=ROOT / "docs/images/vrep_textures.png")
    args = parser.parse_args()
    rows = -(-len(VIEWS) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * WIDTH, rows * (HEIGHT + LINE)), "white")
    draw = ImageDraw.Draw(sheet)
    with tempfile.TemporaryDirectory() as work:
        for at, (name, view) in enumerate(VIEWS.items()):
            file = next(args.folder.rglob(f"{name}.tt[tm]"))
            picture = os.path.join(work, "picture.png")
            where = ["--from", view[0], "--to", view[1]] if view else []
            call = [args.program, "look", str(file), "--size", f"{2 * WIDTH}x{2 * HEIGHT}", "-o", picture, *where]
            subprocess.run(call, check=True, capture_output=True, cwd=work)
            x, y = at % COLUMNS * WIDTH, at // COLUMNS * (HEIGHT + LINE)
            sheet.paste(Image.open(picture).convert("RGB").resize((WIDTH, HEIGHT), Image.LANCZOS), (x, y + LINE))
            draw.text((x + 4, y + 2), name, fill="black")
    # Five bits per channel keep the file small.
    sheet.point(lambda x: x & 0xF8 | x >> 5).save(args.out, optimize=True)
    print(f"{args.out}: {args.out.stat().st_size // 1024} KiB")


if __name__ == "__main__":
    main()
