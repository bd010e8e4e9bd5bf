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

graphs=$(mktemp -d)
tatu run scenes/first/pioneer_draws_its_path.toml --seconds 60 --graphs "$graphs" >/dev/null
mv "$graphs/Drive.png" $images/drive.png
rm -r "$graphs"
