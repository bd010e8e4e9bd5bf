#!/usr/bin/env python3
"""Compiles the dependencies from the registry once per machine, instead of once per clone.

    .ci/dependencies.py restore     before a build: fills an empty target folder from the store
    .ci/dependencies.py save        after a build: adds to the store what was compiled
    .ci/dependencies.py remove      removes the store

The store is `$TATU_CI_STORE`, or `tatu-ci` in the user's cache folder. It has one folder for each compiler and
`Cargo.lock`, with what cargo compiled for packages from the registry, never for packages of this repository. Cargo
itself decides whether a file is up to date, so a store that does not match costs time but is never used wrongly.
"""

import hashlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
STORE = Path(os.environ.get("TATU_CI_STORE") or CACHE / "tatu-ci")
PROFILE = "debug"
# Folders in the store: two, so that two branches with different dependencies do not evict each other.
MAX_FOLDERS = 2
# A store that has grown beyond this is removed, and so is every store if the disk has less space than that.
MAX_BYTES = 4 << 30
LEAST_FREE_BYTES = 6 << 30


def key():
    """Returns the name of the folder for this compiler and these dependencies."""
    compiler = subprocess.run(["rustc", "-vV"], cwd=ROOT, capture_output=True, check=True).stdout
    return hashlib.sha256(compiler + (ROOT / "Cargo.lock").read_bytes()).hexdigest()[:16]


def own_names():
    """Returns the names of the packages and of the crates of this repository."""
    command = ["cargo", "metadata", "--no-deps", "--offline", "--format-version", "1"]
    packages = json.loads(subprocess.run(command, cwd=ROOT, capture_output=True, check=True).stdout)["packages"]
    crates = {target["name"].replace("-", "_") for package in packages for target in package["targets"]}
    return {package["name"] for package in packages}, crates


def compiled(profile, names):
    """Lists the files of packages from the registry. Fingerprints come last: with one, cargo expects the other files."""
    packages, crates = names
    for folder, own in (("deps", crates), ("build", packages), (".fingerprint", packages)):
        for entry in sorted((profile / folder).glob("*-*")):
            name = entry.name.split(".")[0].rsplit("-", 1)[0]
            if name not in own and name.removeprefix("lib") not in own:
                yield from (file for file in sorted(entry.rglob("*")) if file.is_file()) if entry.is_dir() else [entry]


def transfer(source, target, names):
    """Copies what is missing; returns the number of bytes. Libraries, which are never changed, become hard links."""
    total = 0
    for file in compiled(source, names):
        copy = target / file.relative_to(source)
        if copy.exists():
            continue
        copy.parent.mkdir(parents=True, exist_ok=True)
        total += file.stat().st_size
        partial = copy.with_name(copy.name + ".partial")
        if file.suffix in (".rlib", ".rmeta", ".so"):
            try:
                os.link(file, copy)
                continue
            except OSError:
                pass  # another file system
        shutil.copy2(file, partial)
        partial.rename(copy)
    return total


def size(folder):
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())


def prune():
    """Keeps the store small: removes the folders that were not used for longest."""
    folders = sorted((f for f in STORE.iterdir() if f.is_dir()), key=lambda f: f.stat().st_mtime, reverse=True)
    for folder in folders[MAX_FOLDERS:] + [f for f in folders[:MAX_FOLDERS] if size(f) > MAX_BYTES]:
        print(f"removes {folder}")
        shutil.rmtree(folder)


def main():
    action = sys.argv[1] if len(sys.argv) == 2 else ""
    if action not in ("restore", "save", "remove"):
        sys.exit(__doc__)
    STORE.mkdir(parents=True, exist_ok=True)
    if action == "remove" or shutil.disk_usage(STORE).free < LEAST_FREE_BYTES:
        print(f"removes {STORE}" + ("" if action == "remove" else ": the disk is nearly full"))
        shutil.rmtree(STORE)
        return
    folder = STORE / key()
    if action == "restore":
        if (TARGET / PROFILE / ".fingerprint").exists():
            print(f"{TARGET} has been built before: nothing is restored")
        elif not folder.exists():
            print(f"no dependencies in {STORE} for this compiler and Cargo.lock: they are compiled")
        else:
            os.utime(folder)
            print(f"{transfer(folder, TARGET / PROFILE, own_names()) >> 20} MB of dependencies from {folder}")
    else:
        folder.mkdir(exist_ok=True)
        print(f"{transfer(TARGET / PROFILE, folder, own_names()) >> 20} MB of dependencies to {folder}")
        prune()


if __name__ == "__main__":
    main()
