#!/usr/bin/env bash
# How the libraries of this room were built: from the sources beside them, and the headers and the crate in `plugin-api` of the
# commit that added this room (minor version 8), on x86-64 Linux. It stands here as a record. What it makes is kept, and
# never built again: run it into another folder to look at differences.
#
#   tests/museum/draft4minor8/build.sh TO API TATU
#
# gcc 12.2.0 (Debian 12), rustc 1.95.0
set -euo pipefail
to="$(realpath -m "${1:?usage: build.sh TO API TATU}")" api="$(realpath "${2:?usage: build.sh TO API TATU}")" tatu="$(realpath "${3:?usage: build.sh TO API TATU}")"
cd "$(dirname "${BASH_SOURCE[0]}")"
flags=(-O2 -shared -fPIC -fvisibility=hidden -s -I "$api/include")
mkdir -p "$to"
for name in arm magnet radar surfaces tether uwb; do
  gcc -std=c11 "${flags[@]}" -o "$to/libtatu_museum_$name.so" "$name/$name.c" -lm
done
g++ -std=c++17 "${flags[@]}" -o "$to/libtatu_museum_speedometer.so" speedometer/speedometer.cpp
crate="$(mktemp -d)"
(cd "$crate" && "$tatu" new plugin holder --lang rust --kind part)
cp holder/lib.rs "$crate/holder/src/lib.rs"
cat >> "$crate/holder/Cargo.toml" <<TOML

[profile.release]
opt-level = "z"
lto = true
codegen-units = 1
strip = true
TOML
(cd "$crate/holder" && cargo build --release --quiet --target-dir target --config 'build.rustflags=["--remap-path-prefix='"$crate"'=.", "--remap-path-prefix='"$HOME"'=."]')
cp "$crate"/holder/target/release/libtatu_holder.so "$to/libtatu_museum_holder.so"
rm -r "$crate"
