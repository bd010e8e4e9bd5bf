#!/usr/bin/env bash
# Freezes the ABI under a name, in its current state or that of a commit: the headers, a plugin in C and the record of
# layouts. From then on, the tests build this copy and load it with every later host.
#
#   plugin-api/freeze.sh NAME [COMMIT]
#
# Run it before plugins outside this repository may depend on a revision: at each release. A frozen copy is never
# changed; one that nobody has used yet may be removed and created again. Plugins in Rust belong in tests/museum, as
# binaries.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

name="${1:?usage: plugin-api/freeze.sh NAME [COMMIT]}"
commit="${2:-}"
[[ "$name" =~ ^[a-z][a-z0-9]*$ ]] || { echo "the name must consist of lower-case letters and digits, such as draft2" >&2; exit 2; }
to="tests/compat/$name"
[ ! -e "$to" ] || { echo "$to exists already, and a frozen copy must not change" >&2; exit 2; }

# tatu.h and its parts in tatu/, which drafts before the division lack.
include=plugin-api/include
mkdir -p "$to"
if [ -n "$commit" ]; then git archive "$commit:$include" | tar -x -C "$to"; else cp -r "$include/." "$to"; fi
cp tests/compat/plugin.c "$to/plugin.c"

# The record of layouts, as the compiler computes them.
TATU_BLESS="$name" cargo test --quiet --test program -- layout::
cargo test --quiet --test program -- compat:: layout::
echo "frozen: $to and plugin-api/layout/$name.txt; commit both"
