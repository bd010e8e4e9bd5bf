#!/usr/bin/env bash
# Fuzzes a reader on the stable compiler:
#
#   fuzz/run.sh TARGET SECONDS [FOLDER WITH FILES TO BEGIN FROM]
#
# Targets: vrep_scene (whole files), vrep_sections (unpacked sections). What makes one fail is kept in fuzz/found/.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
target=$1 seconds=$2 seeds=${3:-}
export RUSTFLAGS="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
-Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
-Cllvm-args=-sanitizer-coverage-trace-compares --cfg fuzzing"
# With a target triple, build scripts and macros are not instrumented.
triple=$(rustc -vV | sed -n 's/^host: //p')
cargo build --release --target "$triple"
mkdir -p "corpus/$target" found
# A file may take 1 GiB unpacked; what is read may take five times that in the program, here less.
exec "${CARGO_TARGET_DIR:-target}/$triple/release/$target" "corpus/$target" $seeds \
  -artifact_prefix=found/ -max_total_time="$seconds" -rss_limit_mb=4096 -timeout=25 -max_len=200000 -print_final_stats=1
