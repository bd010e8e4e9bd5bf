#!/bin/sh
# Makes every picture of the README and of the documentation again: docs/pictures.sh
# TATU=target/release/tatu docs/pictures.sh takes a program that is built.
set -eu
cd "$(dirname "$0")/.."
images=docs/images
tatu() { ${TATU:-cargo run --release --quiet --} "$@"; }

first=scenes/first/pioneer_avoids_walls.toml
tatu look $first --from -3.3,-3.9,3.0 --to -0.2,0.05,0.1 --at 2 --size 880x495 -o $images/first_scene.png
tatu look $first --from -0.85,0.42,0.34 --to -1.52,1.19,0.12 --fov 34 --size 800x500 -o $images/pioneer.png
tatu look $first --sensor Pioneer_p3dx_ultrasonicSensor4 --at 4 -o $images/sonar.png

room=scenes/first/pioneer_looks_around.toml
tatu look $room --from -3.4,-4.0,3.2 --to 0,0.2,0 --at 1 --size 760x430 -o $images/room.png
tatu look $room --sensor scanner --at 1 -o $images/scan.png
tatu look $room --sensor eye --at 1 -o $images/depth.png

car=scenes/course/manta_keyboard_statusbar.toml
tatu look $car --from 1.5,-1.2,0.8 --to 0.3,0,0.05 --size 800x500 -o $images/manta.png

# Each model, for its page, and all of them in one sheet.
for page in models/*/README.md; do
    model=$(basename "$(dirname "$page")")
    if grep -q picture.png "$page"; then tatu describe "$model" --picture "models/$model/picture.png" >/dev/null; fi
done
tatu describe $(ls -d models/*/ | xargs -n1 basename) --picture $images/models.png >/dev/null

# Each scene as the page offers it, beside it: NAME.png for NAME.toml.
for scene in scenes/*/*.toml; do
    case $scene in
        *showcase*) view="--at 8" ;; # from the scene's own camera
        *manta*) view="--from 1.5,-1.2,0.8 --to 0.3,0,0.05 --at 2" ;;
        *) view="--from -2.9,-3.4,2.7 --to -0.1,0,0.1 --at 2" ;;
    esac
    tatu look "$scene" $view --size 240x150 --files "${TMPDIR:-/tmp}" -o "${scene%.toml}.png"
done

work=$(mktemp -d)
trap 'rm -r "$work"' EXIT

# A hundred Pioneers in an arena of 16 m: ten rows of ten, each heading another way.
awk 'BEGIN {
    print "format = 1\n[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true"
    for (i = 0; i < 4; i++) {
        x = (i < 2) ? 8 - 16 * i : 0; y = (i < 2) ? 0 : 8 - 16 * (i - 2)
        print "[[object]]\nkind = \"shape\"\nalias = \"wall" i "\"\nrespondable = true\ncolor = [0.85, 0.84, 0.80]"
        print "size_m = [" ((i < 2) ? "0.2, 16.2" : "16.2, 0.2") ", 0.6]\nposition_m = [" x ", " y ", 0.3]"
    }
    for (i = 0; i < 100; i++) {
        x = 1.4 * (i % 10) - 6.3; y = 1.4 * int(i / 10) - 6.3
        print "[[model]]\nmodel = \"pioneer_p3dx\"\nscript = \"avoid_walls.lua\"\nposition_m = [" x ", " y ", 0]"
        print "orientation_deg = [0, 0, " (i * 137) % 360 "]"
        if (i % 4 == 1) print "color = [0.10, 0.30, 0.62]"
        if (i % 4 == 2) print "color = [0.85, 0.62, 0.10]"
        if (i % 4 == 3) print "color = [0.16, 0.45, 0.22]"
    }
}' >"$work/arena.toml"
cp scenes/first/avoid_walls.lua "$work"
tatu look "$work/arena.toml" --from -9.5,-11.5,6.5 --to -0.9,-1.3,0 --at 3 --fov 46 --size 680x385 -o $images/arena.png

graphs=$work/graphs
tatu run scenes/first/pioneer_draws_its_path.toml --seconds 60 --graphs "$graphs" >/dev/null
mv "$graphs/Drive.png" $images/drive.png

# page.png, window.png, windows.png and exercise.png: the page as a browser shows it; page_looks.png: its scenes beside those of `tatu look`.
# Needs Chromium, and npm at the build.
cargo test --test program -- --ignored page::pictures page::looks

# V-REP scenes, which are not part of the repository: VREP_SCENES names their folder.
if [ -n "${VREP_SCENES:-}" ]; then
    python3 bench/vrep/textures.py "$VREP_SCENES" --program "${TATU:-target/release/tatu}" --out $images/vrep_textures.png
fi
