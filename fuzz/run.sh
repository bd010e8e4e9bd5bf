#!/usr/bin/env bash
# Fuzzes a reader on the stable compiler:
#
#   fuzz/run.sh TARGET SECONDS [FOLDER WITH SEED FILES]
#
# Targets: vrep_scene (whole files), vrep_sections (uncompressed sections), sdf (text of SDF files). Inputs that make a
# target fail are stored in fuzz/found/.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
target=$1 seconds=$2 seeds=${3:-}
export RUSTFLAGS="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
-Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
-Cllvm-args=-sanitizer-coverage-trace-compares --cfg fuzzing"
# If a target triple is given, build scripts and macros are not instrumented.
triple=$(rustc -vV | sed -n 's/^host: //p')
cargo build --release --target "$triple"
mkdir -p "corpus/$target" found
# A file may decompress to 1 GiB, and its contents may occupy five times that in memory. The limit here is lower.
exec "${CARGO_TARGET_DIR:-target}/$triple/release/$target" "corpus/$target" $seeds \
  -artifact_prefix=found/ -max_total_time="$seconds" -rss_limit_mb=4096 -timeout=25 -max_len=200000 -print_final_stats=1
