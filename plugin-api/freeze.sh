#!/usr/bin/env bash
# Freezes the ABI under a name, in its current state or that of a commit: the headers, a plugin in C and the record of
# layouts. From then on, the tests build this copy and load it with every later host.
#
#   plugin-api/freeze.sh NAME [COMMIT]
#
# Run it at each release, before plugins outside this repository can depend on a revision. A frozen copy must never be
# changed; a copy that nobody has used yet may be removed and created again. Plugins in Rust are stored as binaries, in
# tests/museum.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

name="${1:?usage: plugin-api/freeze.sh NAME [COMMIT]}"
commit="${2:-}"
[[ "$name" =~ ^[a-z][a-z0-9]*$ ]] || { echo "the name must consist of lower-case letters and digits, such as draft2" >&2; exit 2; }
to="tests/compat/$name"
[ ! -e "$to" ] || { echo "$to exists already, and a frozen copy must not change" >&2; exit 2; }

# tatu.h and, since the header was divided, its parts in tatu/.
include=plugin-api/include
mkdir -p "$to"
if [ -n "$commit" ]; then git archive "$commit:$include" | tar -x -C "$to"; else cp -r "$include/." "$to"; fi
cp tests/compat/plugin.c "$to/plugin.c"

# The record of layouts, as the compiler computes them.
TATU_BLESS="$name" cargo test --quiet --test program -- layout::
cargo test --quiet --test program -- compat:: layout::
echo "frozen: $to and plugin-api/layout/$name.txt; commit both"
