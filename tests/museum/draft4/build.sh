#!/usr/bin/env bash
# How the libraries of this room were built: from the sources beside them, the frozen header in tests/compat/draft4, and
# the crate of draft 4, which only the history still has (git checkout REVISION~ -- tests/compat/draft4/api, REVISION being
# that of `git log -1 --format=%h -- tests/compat/draft4/api`), on x86-64 Linux. It stands here as a record. What it makes is kept, and never built again: run it into
# another folder to look at differences.
#
#   tests/museum/draft4/build.sh TO
#
# gcc 12.2.0 (Debian 12), clang 22.1.8 (PyPI: ziglang 0.17.1), rustc 1.95.0
set -euo pipefail
to="$(realpath -m "${1:?usage: build.sh TO}")"
cd "$(dirname "${BASH_SOURCE[0]}")"
include="$PWD/../../compat/draft4" api="$PWD/../../compat/draft4/api" root="$PWD/../../.."
flags=(-O2 -shared -fPIC -fvisibility=hidden -s -I "$include")
mkdir -p "$to"
for name in cart counter dots fan fleet lamp; do
  gcc -std=c11 "${flags[@]}" -o "$to/libtatu_museum_$name.so" "$name/$name.c" -lm
done
gcc -std=c11 "${flags[@]}" -o "$to/libtatu_museum_c_gcc.so" c_gcc/c_command.c -lm
python3 -m ziglang cc -target x86_64-linux-gnu.2.31 -std=c11 "${flags[@]}" -o "$to/libtatu_museum_c_clang.so" c_gcc/c_command.c -lm
g++ -std=c++17 "${flags[@]}" -o "$to/libtatu_museum_guard.so" guard/guard.cpp
for name in range tally; do
  crate="$(mktemp -d)"
  mkdir "$crate/src"
  cp "$name/lib.rs" "$crate/src/lib.rs"
  cat > "$crate/Cargo.toml" <<TOML
[package]
name = "tatu-museum-$name"
version = "1.0.0"
edition = "2024"

[lib]
crate-type = ["cdylib"]

[dependencies]
tatu-plugin-api = { package = "tatu-plugin-api-draft4", path = "$crate/api" }

[workspace]

[profile.release]
opt-level = "z"
lto = true
codegen-units = 1
strip = true
TOML
  # The frozen crate takes a dependency from the workspace; here it stands by itself.
  cp -r "$api" "$crate/api"
  sed -i 's/abi_stable = { workspace = true, optional = true }/abi_stable = { version = "=0.11.3", default-features = false, optional = true }/' "$crate/api/Cargo.toml"
  cp "$root/Cargo.lock" "$crate/Cargo.lock"
  (cd "$crate" && cargo build --release --quiet --config 'build.rustflags=["--remap-path-prefix='"$crate"'=.", "--remap-path-prefix='"$HOME"'=."]')
  cp "$crate/target/release/libtatu_museum_$name.so" "$to/"
  rm -r "$crate"
done

# `tally_debian`: the same with the name `tatu-museum-tally-debian`, the source of `tally`, and the compiler of Debian's
# package rustc-web (1.96.0): RUSTC=/usr/bin/rustc cargo build --release ...
