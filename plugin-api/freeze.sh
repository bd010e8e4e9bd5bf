#!/usr/bin/env bash
# Freezes the contract under a name, as it is or as it was at a commit: the headers, a plugin in C and the record of
# layouts. From then on the tests build and load this copy with every host to come.
#
#   plugin-api/freeze.sh NAME [COMMIT]
#
# Run it when plugins that others build may begin to depend on a revision: at each release. A frozen copy is never
# changed; one that nobody has used yet may be removed and made again. Plugins in Rust belong into tests/museum, as
# binaries.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

name="${1:?usage: plugin-api/freeze.sh NAME [COMMIT]}"
commit="${2:-}"
[[ "$name" =~ ^[a-z][a-z0-9]*$ ]] || { echo "the name is lower-case letters and digits, such as draft2" >&2; exit 2; }
to="tests/compat/$name"
[ ! -e "$to" ] || { echo "$to is there already, and a frozen copy does not change" >&2; exit 2; }

# tatu.h and, since it was divided, its parts in tatu/.
include=plugin-api/include
mkdir -p "$to"
if [ -n "$commit" ]; then git archive "$commit:$include" | tar -x -C "$to"; else cp -r "$include/." "$to"; fi
cp tests/compat/plugin.c "$to/plugin.c"

# The record of layouts, by the compiler's word.
TATU_BLESS="$name" cargo test --quiet --test program -- layout::
cargo test --quiet --test program -- compat:: layout::
echo "frozen: $to and plugin-api/layout/$name.txt; commit both"
