#!/usr/bin/env bash
# Fuzzes a reader of files on the stable compiler:
#
#   fuzz/run.sh TARGET SECONDS [FOLDER WITH SEED FILES]
#
# Targets: vrep_scene (whole files) and vrep_sections (uncompressed sections) call the reader of V-REP's files; the
# suffix of any other file that an importer reads, such as urdf, xacro, mjcf, sdf, stl, obj, dae, gltf, glb and ply, runs
# its plugin in the host. Inputs that make a target fail are stored in fuzz/found/. Without a folder, the examples of the
# repository with that suffix are the seeds.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
target=$1 seconds=$2 seeds=${3:-}
# The libraries of plugins count in the program's tables, so the program exports libFuzzer's functions.
export RUSTFLAGS="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
-Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
-Cllvm-args=-sanitizer-coverage-trace-compares -Clink-arg=-Wl,--export-dynamic --cfg fuzzing"
# If a target triple is given, build scripts and macros are not instrumented.
triple=$(rustc -vV | sed -n 's/^host: //p')
cargo build --release --target "$triple"
built="${CARGO_TARGET_DIR:-target}/$triple/release"
suffix=$target
case $target in
  vrep_scene | vrep_sections) binary=$target plugin= ;;
  urdf | xacro) binary=importer plugin=urdf ;;
  mjcf) binary=importer plugin=mjcf suffix=xml ;;
  sdf) binary=importer plugin=sdf ;;
  *) binary=importer plugin=mesh ;;
esac
mkdir -p "corpus/$target" found
if [ -z "$seeds" ]; then
  seeds=found/seeds/$target
  mkdir -p "$seeds"
  git ls-files .. | grep "\.$suffix\$" | while read -r file; do cp "$file" "$seeds/$(basename "$file")"; done
fi
export TATU_FUZZ_PLUGIN="$built/deps/libtatu_importers_$plugin.so"
# In a folder of its own, so that no file beside it can be opened. Nothing is written there.
TATU_FUZZ_FILE="$(mktemp -d)/file.$target"
export TATU_FUZZ_FILE
# A file may decompress to 1 GiB, and its contents may occupy five times that in memory. The limit here is lower.
exec "$built/$binary" "corpus/$target" "$seeds" \
  -artifact_prefix=found/ -max_total_time="$seconds" -rss_limit_mb=4096 -timeout=25 -max_len=200000 -print_final_stats=1
