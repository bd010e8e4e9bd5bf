#!/usr/bin/env python3
"""Compares the hashes of scenes between compilers, C libraries and processors: platforms.py [OPTIONS] [FILE...]

    --only NAME,...    platforms to compare with the first; default: all in ORDER
    --steps N          steps of each run; default: 20
    --target DIR       folder for builds and downloads; default: target/platforms
    --tarball FILE     the package to test in root file systems; built by zig unless given
    --out FILE         the Markdown file for the table; default: hashes.md in the target folder

Each FILE is a scene to run in addition to those in scenes/. Each platform is built, fetched or emulated if this machine
can do so; otherwise the table shows what is missing. Two platforms agree on a scene if the hashes of its run are equal.
All are compared with the first platform, this machine's own compiler. The exit code is 1 if any scene differs.
"""

import argparse
import concurrent.futures
import json
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

import debian_mirror

# packages/ must precede this folder in the search path, because both contain a wheel.py.
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "packages"))

import wheel  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
ARM = "aarch64-unknown-linux-gnu"
# The platforms, by the names of their methods. All others are compared with the first.
ORDER = ["own", "simd_off", "old_processor", "clang", "zig", "bullseye", "bookworm", "aarch64"]
TIMEOUT_S = 600
# A model of processor, as qemu names it, with neither AVX nor fused multiply-add.
OLD_PROCESSOR = "Westmere"
# Placeholder in a command, replaced by the options that bind the folders of the scene and of the run into the sandbox.
FOLDERS = "--folders-of-the-run"


class Lacking(Exception):
    """Raised if this machine lacks something that is needed to test a platform."""


def cargo(target, triple=None, command=("cargo", "build"), **environment):
    """Builds the program with its plugins; returns its path."""
    call = [*command, "--release", "--locked", "-p", "tatu", "-p", "libtatu", *(["--target", triple] if triple else [])]
    told = subprocess.run(call, cwd=ROOT, env={**os.environ, "CARGO_TARGET_DIR": str(target), **environment}, check=False)
    if told.returncode != 0:
        raise Lacking(f"`{' '.join(call)}` has failed; see above")
    return target / (triple.rsplit(".", 2)[0] if triple else "") / "release/tatu"


def need(*programs):
    for program in programs:
        if shutil.which(program) is None:
            raise Lacking(f"there is no `{program}`")


class Platforms:
    """Prepares the platforms. Each method returns the command that runs the program, and its extra environment."""

    def __init__(self, target, tarball):
        self.target, self.given, self.native = target, tarball, None

    def own(self):
        """this machine's compiler"""
        self.native = self.native or cargo(Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")))
        return [str(self.native)], {}

    def simd_off(self):
        """`TATU_SIMD=off`"""
        return self.own()[0], {"TATU_SIMD": "off"}

    def old_processor(self):
        """a processor without AVX and FMA (qemu)"""
        need("qemu-x86_64-static")
        return ["qemu-x86_64-static", "-cpu", OLD_PROCESSOR, *self.own()[0]], {}

    def clang(self):
        """C by clang, linked by lld"""
        need("clang", "clang++", "ld.lld")
        flags = {"CC": "clang", "CXX": "clang++", "RUSTFLAGS": "-C linker=clang -C link-arg=-fuse-ld=lld"}
        return [str(cargo(self.target / "clang", **flags))], {}

    def zig(self):
        """C by zig, glibc 2.28"""
        return [str(self.unpacked() / "bin/tatu")], {}

    def bullseye(self):
        """that in Debian 11, glibc 2.31"""
        return self.within("bullseye")

    def bookworm(self):
        """that in Debian 12, glibc 2.36"""
        return self.within("bookworm")

    def aarch64(self):
        """AArch64 (qemu)"""
        need("aarch64-linux-gnu-gcc", "aarch64-linux-gnu-g++", "qemu-aarch64-static")
        upper = ARM.upper().replace("-", "_")
        tools = {"CC": "aarch64-linux-gnu-gcc", "CXX": "aarch64-linux-gnu-g++"}
        environment = {f"{name}_{ARM.replace('-', '_')}": program for name, program in tools.items()}
        environment[f"CARGO_TARGET_{upper}_LINKER"] = tools["CC"]
        libraries = subprocess.run(["rustc", "--print", "target-libdir", "--target", ARM], capture_output=True, text=True,
                                   cwd=ROOT, check=True).stdout.strip()
        if not Path(libraries).exists():
            environment["RUSTC"] = str(self.debian_rustc())
        program = cargo(self.target / "aarch64", ARM, **environment)
        return ["qemu-aarch64-static", "-L", "/usr/aarch64-linux-gnu", str(program)], {}

    def unpacked(self):
        """Returns the unpacked package, which is built by zig unless it was given."""
        archive = self.given
        if archive is None:
            tools = wheel.environment(self.target / "tools", wheel.TOOLS)
            path = {"PATH": f"{tools}{os.pathsep}{os.environ['PATH']}"}
            built = cargo(self.target / "zig", f"{wheel.TRIPLE}.{wheel.GLIBC}", ("cargo", "zigbuild"), **path).parent
            make = [sys.executable, "packages/make.py", "--built", str(built), "--out", str(self.target), "tarball"]
            subprocess.run(make, cwd=ROOT, check=True)
            archive = self.given = next(self.target.glob("tatu-*-linux-x86_64.tar.gz"))
        with tarfile.open(archive) as tar:
            top = self.target / tar.next().name.split("/")[0]
            if not top.exists() or top.stat().st_mtime < archive.stat().st_mtime:
                shutil.rmtree(top, ignore_errors=True)
                tar.extractall(self.target)
                os.utime(top)
        return top

    def within(self, release):
        """Sets up the package in a root file system that contains only the C library of a Debian release."""
        need("bwrap")
        home = self.unpacked()
        root = debian_mirror.unpack(release, "amd64", ["libc6", "libgcc-s1"], self.target / release)
        binds = [arg for place in ("usr", "lib", "lib64") if (root / place).exists()
                 for arg in ("--ro-bind", str(root / place), f"/{place}")]
        binds += ["--ro-bind", str(home), "/opt/tatu", "--dev", "/dev", "--proc", "/proc", "--unshare-net"]
        return ["bwrap", *binds, FOLDERS, "/opt/tatu/bin/tatu"], {}

    def debian_rustc(self):
        """Fetches Debian's Rust compiler with its standard library for AArch64."""
        root, suite = self.target / "rustc", "bookworm-security"
        names = debian_mirror.index(suite, "amd64")[1]
        version = next(name for name in names if name.startswith("libstd-rust-web-1."))
        llvm = max(name for name in names if name.startswith("libllvm") and name[7:].isdigit())
        debian_mirror.unpack(suite, "amd64", ["rustc-web", version, "libstd-rust-web-dev", llvm], root)
        debian_mirror.unpack(suite, "arm64", ["libstd-rust-web-dev"], root)
        wrapper = root / "rustc"
        wrapper.write_text(f'#!/bin/sh\nLD_LIBRARY_PATH="{root}/usr/lib/x86_64-linux-gnu" exec "{root}/usr/bin/rustc" "$@"\n')
        wrapper.chmod(0o755)
        return wrapper


def hash_of(command, environment, scene, steps):
    """Returns the hash of a run, or the error."""
    with tempfile.TemporaryDirectory() as work:
        # Scripts read files in the scene's folder and write files to the working folder; both are bound.
        shipped = ROOT / "scenes"
        seen = str(shipped if scene.is_relative_to(shipped) else scene.parent)
        folders = ["--ro-bind", seen, seen, "--bind", work, work, "--chdir", work]
        call = [part for word in command for part in (folders if word == FOLDERS else [word])]
        call += ["run", str(scene), "--steps", str(steps), "--json", "--no-addons"]
        # A program outside the source tree does not find the models by itself.
        environment = {**os.environ, "TATU_MODEL_PATH": str(ROOT / "models"), **environment}
        try:
            told = subprocess.run(call, cwd=work, capture_output=True, text=True, timeout=TIMEOUT_S, check=False,
                                  env=environment)
            summary = json.loads(told.stdout)
            return summary["hash"] + (f" with {len(summary['errors'])} errors" if summary["errors"] else "")
        except subprocess.TimeoutExpired:
            return f"none in {TIMEOUT_S} s"
        except (ValueError, KeyError, TypeError):
            lines = (told.stderr or told.stdout).strip().splitlines()
            return f"none: {lines[0] if lines else f'ended with {told.returncode}'}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE")
    parser.add_argument("--only", default=",".join(ORDER[1:]), metavar="NAME,...")
    parser.add_argument("--steps", type=int, default=20)
    parser.add_argument("--target", type=Path, default=ROOT / "target/platforms")
    parser.add_argument("--tarball", type=Path)
    parser.add_argument("--out", type=Path)
    args = parser.parse_args()
    wanted = args.only.split(",")
    if unknown := [name for name in wanted if name not in ORDER]:
        parser.error(f"no such platform: {', '.join(unknown)}; there are {', '.join(ORDER)}")
    target = args.target.resolve()
    target.mkdir(parents=True, exist_ok=True)
    scenes = sorted((ROOT / "scenes").rglob("*.toml")) + [file.resolve() for file in args.files]
    platforms = Platforms(target, args.tarball and args.tarball.resolve())
    table, lacking, differ = {}, {}, 0
    for name in ["own", *wanted]:
        print(f"== {name}", flush=True)
        try:
            command, environment = getattr(platforms, name)()
        except (Lacking, debian_mirror.Missing, OSError, subprocess.CalledProcessError) as error:
            lacking[name] = str(error)
            print(f"not tried: {error}", flush=True)
            continue
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            hashes = list(pool.map(lambda scene: hash_of(command, environment, scene, args.steps), scenes))
        if name == "own":
            # Files that other scenes include cannot be run separately.
            for scene, got in zip(scenes, hashes):
                if got.startswith("none"):
                    print(f"left out: {scene.name}: {got}")
            scenes, hashes = zip(*(pair for pair in zip(scenes, hashes) if not pair[1].startswith("none")))
        table[name] = hashes
        for scene, own, got in zip(scenes, table["own"], hashes):
            if got != own:
                differ += 1
                print(f"{scene.name}: {got}, expected {own}", flush=True)
    out = args.out or target / "hashes.md"
    out.write_text(markdown(scenes, table, lacking, args.steps), encoding="utf-8")
    tried = len(table) - 1
    print(f"{out}: {len(scenes)} scenes on {tried} platforms beside this one, {differ} runs differ")
    sys.exit(1 if differ else 0)



def markdown(scenes, table, lacking, steps):
    """Returns the table, with a row for each scene and a column for each platform."""
    about = {name: getattr(Platforms, name).__doc__ for name in ORDER}
    lines = [f"Hashes after {steps} steps.", "", "| scene | " + " | ".join(about[n] for n in table) + " |"]
    lines.append("|---" * (1 + len(table)) + "|")
    for at, scene in enumerate(scenes):
        own = table["own"][at]
        cells = [f"`{own}`", *("equal" if h[at] == own else f"**`{h[at]}`**" for n, h in table.items() if n != "own")]
        place = scene.relative_to(ROOT / "scenes") if scene.is_relative_to(ROOT / "scenes") else scene.name
        lines.append(f"| {place} | " + " | ".join(cells) + " |")
    lines += ["", *(f"Not tried: {about[name]}, because {why}." for name, why in lacking.items())]
    return "\n".join(lines).rstrip() + "\n"


if __name__ == "__main__":
    main()
