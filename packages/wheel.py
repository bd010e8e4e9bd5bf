#!/usr/bin/env python3
"""Makes the wheel of the Python package, for Linux with glibc 2.28 or later and Python 3.9 or later.

    packages/wheel.py [--out DIR] [--target DIR] [--local]

Program and plugins are built by zig for glibc 2.28, then maturin builds the module and puts everything into one file.
With `--local`, the compiler of this machine builds for this machine only. The tools (maturin, cargo-zigbuild, zig) are
installed from PyPI into a virtual environment in the target folder.
"""

import argparse
import os
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TRIPLE = "x86_64-unknown-linux-gnu"
GLIBC = "2.28"
# Versions of the tools that were tested together.
TOOLS = ["maturin==1.16.0", "cargo-zigbuild==0.24.1", "ziglang==0.17.1"]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=ROOT / "target/packages", help="folder of the wheel")
    parser.add_argument("--target", type=Path, default=None, help="cargo's target folder")
    parser.add_argument("--local", action="store_true", help="build for this machine only, without zig")
    args = parser.parse_args()
    target = (args.target or Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))).resolve()
    args.out.mkdir(parents=True, exist_ok=True)
    tools = environment(target / "wheel-tools", TOOLS[:1] if args.local else TOOLS)
    env = {**os.environ, "CARGO_TARGET_DIR": str(target), "PATH": f"{tools}{os.pathsep}{os.environ['PATH']}"}
    wheel = ["maturin", "build", "--release", "--locked", "--manifest-path", "hosts/python/Cargo.toml", "--out", str(args.out)]
    if not args.local:
        packages = ["-p", "tatu", "-p", "libtatu"]
        run(["cargo", "zigbuild", "--release", "--locked", "--target", f"{TRIPLE}.{GLIBC}", *packages], env)
        env["TATU_WHEEL_PLUGINS"] = str(target / TRIPLE / "release")
        wheel += ["--zig", "--target", TRIPLE, "--compatibility", f"manylinux_{GLIBC.replace('.', '_')}"]
    notices(env)
    run(wheel, env)
    made = max(args.out.glob("tatu_sim-*.whl"), key=lambda file: file.stat().st_mtime)
    print(f"{made}: {made.stat().st_size / 1e6:.1f} MB")
    return 0


def environment(folder: Path, packages) -> Path:
    """Creates a virtual environment with these packages; returns its folder of programs."""
    if not (folder / "bin/python").exists():
        venv.create(folder, with_pip=True)
    run([str(folder / "bin/python"), "-m", "pip", "install", "-q", *packages], dict(os.environ))
    return folder / "bin"


def notices(env) -> None:
    """Writes third-party notices into the package."""
    command = [sys.executable, "packages/make.py", "notices", "--also", "tatu-python", "--out", "hosts/python/tatu_sim"]
    run(command, env)


def run(command, env) -> None:
    print("==", " ".join(map(str, command)), flush=True)
    if subprocess.run(command, cwd=ROOT, env=env).returncode != 0:
        sys.exit(f"packages/wheel.py: failed: {' '.join(map(str, command))}")


if __name__ == "__main__":
    sys.exit(main())
