#!/usr/bin/env python3
"""Tests licences and sources of all dependencies, as `cargo deny check licenses bans sources` does:
licences.py [--metadata FILE] [--lock FILE]

Tests the packages in the output of `cargo metadata` (or in a file that contains it) and in the page's
package-lock.json. Needs no build. The allowed licences are in packages/licences.toml and must equal those of deny.toml.
Crates must come from crates.io or from this repository. Crates that occur in several versions are listed but allowed,
because the crates that depend on them choose the versions.
"""

import argparse
import contextlib
import io
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "packages"))
import spdx  # noqa: E402

LOCK = ROOT / "plugins/views/web/page/package-lock.json"
DENY = ROOT / "deny.toml"
TARGET = "x86_64-unknown-linux-gnu"
CRATES_IO = "registry+https://github.com/rust-lang/crates.io-index"


def cargo_metadata():
    command = ["cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", TARGET]
    ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if ran.returncode != 0:
        raise SystemExit(f"`{' '.join(command)}` has failed:\n{ran.stderr}")
    return json.loads(ran.stdout)


def refusal(expression, allowed):
    """Returns the reason why a licence expression is refused, or None if it is allowed."""
    try:
        tree = spdx.parse(expression)
    except spdx.NotAnExpression as error:
        return str(error)
    if spdx.is_satisfied(tree, allowed):
        return None
    missing = [one for one in spdx.licences(tree) if not spdx.is_satisfied(("id", one), allowed)]
    return f"`{expression}`: not allowed: {', '.join(missing)}"


def refused(metadata, lock, lists):
    """Returns a line for each package with a licence that is not allowed, and the number of packages tested."""
    wrong, count = [], 0
    for crate in metadata["packages"]:
        count += 1
        why = refusal(crate["license"], lists["allow"])
        if why:
            wrong.append(f"crate {crate['name']} {crate['version']}: {why}")
    for place, package in lock["packages"].items():
        if not place:
            continue
        count += 1
        allowed = {**lists["allow"], **(lists.get("tools", {}) if package.get("dev") else {})}
        why = refusal(package.get("license"), allowed)
        if why:
            name = place.rpartition("node_modules/")[2]
            wrong.append(f"npm package {name} {package.get('version')}: {why}")
    return sorted(wrong), count


def foreign(metadata):
    """Returns a line for each crate that comes neither from crates.io nor from the workspace."""
    return [
        f"crate {crate['name']} {crate['version']}: from {crate['source']}; expected crates.io or a path"
        for crate in metadata["packages"]
        if crate.get("source") not in (None, CRATES_IO)
    ]


def duplicates(metadata):
    """Returns a line with the versions of each crate that occurs in more than one."""
    versions = {}
    for crate in metadata["packages"]:
        versions.setdefault(crate["name"], []).append(crate["version"])
    return {name: sorted(found) for name, found in sorted(versions.items()) if len(found) > 1}


def differences(lists):
    """Returns a line for each licence that only one of the two files allows."""
    match = re.search(r"^allow = \[(.*?)^\]", DENY.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    if not match:
        return [f"{DENY.name}: expected a list `allow = [`"]
    lines = [line.split("#")[0] for line in match.group(1).splitlines()]
    other = set(re.findall(r'"([^"]+)"', "\n".join(lines)))
    own = set(lists["allow"])
    return [f"`{one}` is in {DENY.name} only" for one in sorted(other - own)] + \
           [f"`{one}` is in packages/{spdx.LIST.name} only" for one in sorted(own - other)]


def run(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--metadata", type=Path, help="a file with the output of `cargo metadata`")
    parser.add_argument("--lock", type=Path, default=LOCK, help="a package-lock.json")
    args = parser.parse_args(arguments)
    metadata = json.loads(args.metadata.read_text(encoding="utf-8")) if args.metadata else cargo_metadata()
    lists = spdx.read_list()
    wrong, count = refused(metadata, json.loads(args.lock.read_text(encoding="utf-8")), lists)
    wrong += foreign(metadata) + differences(lists)
    for line in wrong:
        print(f"FAIL  {line}")
    for name, versions in duplicates(metadata).items():
        print(f"note  crate {name} in {len(versions)} versions: {', '.join(versions)}")
    if wrong:
        print("help: use another package, or add the licence to packages/licences.toml and deny.toml, with its reason")
    else:
        print(f"the terms of {count} packages can be met")
    return 1 if wrong else 0


def test_expressions():
    allowed = ["MIT", "Apache-2.0 WITH LLVM-exception", "Zlib"]
    for expression, is_allowed in [
        ("MIT", True),
        ("mit", True),
        ("MIT+", True),
        ("GPL-3.0 OR MIT", True),
        ("GPL-3.0/MIT", True),
        ("GPL-3.0 / MIT", True),
        ("GPL-3.0 AND MIT", False),
        ("GPL-3.0 OR MIT AND Zlib", True),
        ("(GPL-3.0 OR MIT) AND Zlib", True),
        ("(GPL-3.0 OR MIT) AND GPL-2.0", False),
        ("((MIT))", True),
        ("Apache-2.0 WITH LLVM-exception OR GPL-3.0", True),
        ("Apache-2.0 WITH Classpath-exception-2.0", False),
        ("Apache-2.0", False),
        ("MITX", False),
    ]:
        assert (refusal(expression, allowed) is None) == is_allowed, expression
    for text in ["", None, "MIT OR", "OR MIT", "(MIT", "MIT)", "MIT MIT", "MIT WITH", "SEE LICENSE IN terms", "MIT,"]:
        assert refusal(text, allowed), f"{text!r} must be refused"


def test_refusals():
    """Checks with generated files that a package with a forbidden licence is reported, and makes the exit code 1."""
    crate = {"name": "good", "version": "1.0.0", "license": "MIT OR GPL-3.0"}
    good = {"name": "", "packages": {"": {}, "node_modules/a": {"version": "1.0.0", "license": "MIT"}}}
    cases = [
        ({"packages": [crate]}, good, 0, ""),
        ({"packages": [crate, {**crate, "name": "bad", "license": "GPL-3.0-only"}]}, good, 1, "crate bad 1.0.0"),
        ({"packages": [{**crate, "license": None}]}, good, 1, "there is no licence expression"),
        ({"packages": [crate]}, {"packages": {"node_modules/@b/c": {"version": "2.0.0", "license": "AGPL-3.0"}}}, 1,
         "npm package @b/c 2.0.0"),
        ({"packages": [crate]}, {"packages": {"node_modules/d": {"version": "2.0.0", "license": "BSD-3-Clause"}}}, 1,
         "npm package d 2.0.0"),
    ]
    git = {**crate, "name": "other", "source": "git+https://example.org/other#1234"}
    cases += [
        ({"packages": [git]}, good, 1, "crate other 1.0.0: from git+"),
        ({"packages": [{**crate, "source": CRATES_IO}, {**crate, "version": "2.0.0"}]}, good, 0,
         "crate good in 2 versions: 1.0.0, 2.0.0"),
    ]
    with tempfile.TemporaryDirectory() as folder:
        metadata, lock = Path(folder) / "metadata.json", Path(folder) / "package-lock.json"
        for crates, packages, code, said in cases:
            metadata.write_text(json.dumps(crates), encoding="utf-8")
            lock.write_text(json.dumps(packages), encoding="utf-8")
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                got = run(["--metadata", str(metadata), "--lock", str(lock)])
            assert got == code and said in out.getvalue(), out.getvalue()


if __name__ == "__main__":
    test_expressions()
    test_refusals()
    sys.exit(run(sys.argv[1:]))
