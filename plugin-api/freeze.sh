#!/usr/bin/env bash
# Freezes the contract under a name, as it is or as it was at a commit: header, Rust sources, one plugin in each
# language and the record of layouts. From then on the tests build and load these copies with every host to come.
#
#   plugin-api/freeze.sh NAME [COMMIT]
#
# Run it when plugins that others build may begin to depend on a revision: at each release. A frozen copy is never
# changed; one that nobody has used yet may be removed and made again.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

name="${1:?usage: plugin-api/freeze.sh NAME [COMMIT]}"
commit="${2:-}"
[[ "$name" =~ ^[a-z][a-z0-9]*$ ]] || { echo "the name is lower-case letters and digits, such as draft2" >&2; exit 2; }
to="tests/compat/$name"
[ ! -e "$to" ] || { echo "$to is there already, and a frozen copy does not change" >&2; exit 2; }

# The content of a file, now or then.
text() { if [ -n "$commit" ]; then git show "$commit:$1"; else cat "$1"; fi; }
# The Rust sources and the schemas that they include, now or then.
sources() {
  if [ -n "$commit" ]; then git ls-tree -r --name-only "$commit" plugin-api/src plugin-api/schemas
  else find plugin-api/src plugin-api/schemas -name '*.rs' -o -name '*.toml'; fi
}

mkdir -p "$to/plugin/src"
text plugin-api/include/tatu.h > "$to/tatu.h"
for file in $(sources); do
  mkdir -p "$to/api/$(dirname "${file#plugin-api/}")"
  text "$file" > "$to/api/${file#plugin-api/}"
done
cp tests/compat/plugin.c "$to/plugin.c"
cp tests/compat/plugin.rs "$to/plugin/src/lib.rs"

cat > "$to/api/Cargo.toml" <<END
[package]
name = "tatu-plugin-api-$name"
description = "plugin-api as it was: frozen, see tests/compat/README.md"
version = "0.0.0"
edition = "2024"
publish = false

[lib]
test = false
doctest = false
doc = false

[features]
default = ["layout-check"]
layout-check = ["dep:abi_stable"]

[dependencies]
abi_stable = { workspace = true, optional = true }
END
# Two packages of a workspace cannot have one name, but what is compiled has to call itself as it did.
cat > "$to/api/build.rs" <<END
//! The library was compiled under this name.

fn main() {
    println!("cargo::rustc-env=CARGO_PKG_NAME=tatu-plugin-api");
}
END
cat > "$to/plugin/Cargo.toml" <<END
[package]
name = "tatu-compat-$name"
description = "A plugin built with plugin-api as it was: frozen, see tests/compat/README.md"
version = "0.0.0"
edition = "2024"
publish = false

[lib]
crate-type = ["cdylib", "rlib"]
test = false
doctest = false
doc = false

[dependencies]
tatu-plugin-api = { package = "tatu-plugin-api-$name", path = "../api" }
END

# The tests load its library: cargo builds it for them.
line="tatu-compat-$name = { path = \"tests/compat/$name/plugin\" }"
grep -qF "$line" Cargo.toml || sed -i.old "s|^# the tests load libraries of frozen copies.*|&\n$line|" Cargo.toml
rm -f Cargo.toml.old

# The record of layouts, by the compiler's word.
TATU_BLESS="$name" cargo test --quiet --test program -- layout::
cargo test --quiet --test program -- compat:: layout::
echo "frozen: $to and plugin-api/layout/$name.txt; commit both, Cargo.toml and Cargo.lock"
