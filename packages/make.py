#!/usr/bin/env python3
"""Makes packages of the program: make.py [--target DIR | --built DIR] [--out DIR] [tarball|deb|docker|all|notices]

    tarball    tatu-VERSION-linux-x86_64.tar.gz, which runs wherever it is unpacked (the default)
    deb        tatu_VERSION_amd64.deb, the same files below /usr
    docker     an image `tatu:VERSION`, built from the tarball with packages/Dockerfile
    all        these three
    notices    only THIRD-PARTY.txt, for packages that are built by other means; requires no build

The program is built first, by `cargo build --release`, unless `--built` names the folder of an existing
build. Packages of the same files are identical. The time of the files is SOURCE_DATE_EPOCH or that of the last commit.
"""

import argparse
import gzip
import io
import json
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

import debian
import elf_versions
import layout
import third_party

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
TARGET = "x86_64-unknown-linux-gnu"
SYSTEM = "linux-x86_64"
MAINTAINER = "The Tatu authors <maintainers@tatu.invalid>"


def read_metadata():
    """Returns cargo's metadata about all packages; missing packages are downloaded."""
    command = ["cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", TARGET]
    try:
        return json.loads(subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout)
    except (OSError, subprocess.CalledProcessError) as error:
        raise SystemExit(f"`{' '.join(command)}` has failed: {error}") from None


def build(target):
    """Builds the program and its plugins; returns the folder that contains them."""
    environment = {**os.environ, "CARGO_TARGET_DIR": str(target)}
    ran = subprocess.run(["cargo", "build", "--release", "--locked", "-p", "tatu", "-p", "libtatu"], cwd=ROOT, env=environment, check=False)
    if ran.returncode != 0:
        raise SystemExit("`cargo build --release --locked` has failed; see above")
    return target / "release"


def time_of_files():
    """Returns the modification time for all files in packages, in seconds since 1970."""
    given = os.environ.get("SOURCE_DATE_EPOCH")
    if given is None:
        command = ["git", "-C", str(ROOT), "log", "-1", "--format=%ct"]
        given = subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()
    if not given.isdigit():
        raise SystemExit(f"the modification time for the files is invalid: `{given}`\n  expected: "
                         "SOURCE_DATE_EPOCH in seconds since 1970, or a git commit")
    return int(given)


def tarball(entries, version, when, out):
    """Writes the tarball and returns its path."""
    name = f"tatu-{version}-{SYSTEM}"
    result = out / f"{name}.tar.gz"

    def about(place, mode, kind, size=0):
        info = tarfile.TarInfo(f"{name}/{place}".rstrip("/"))
        info.mode, info.type, info.size, info.mtime = mode, kind, size, when
        info.uname = info.gname = "root"
        return info

    # Level 9 takes three times as long, and reduces the size by only 1 %.
    options = {"filename": "", "mode": "wb", "compresslevel": 6, "mtime": when}
    with open(result, "wb") as file, gzip.GzipFile(fileobj=file, **options) as packed:
        with tarfile.open(fileobj=packed, mode="w", format=tarfile.GNU_FORMAT) as tar:
            for folder in ["", *layout.folders(entries)]:
                tar.addfile(about(folder, 0o755, tarfile.DIRTYPE))
            for place, entry in entries.items():
                tar.addfile(about(place, entry.mode, tarfile.REGTYPE, len(entry.data)), io.BytesIO(entry.data))
    return result


def docker(command, archive, version):
    """Builds the image; returns whether that succeeded."""
    with tempfile.TemporaryDirectory(prefix="tatu-docker-") as work:
        shutil.copy(archive, work)
        shutil.copy(HERE / "Dockerfile", work)
        call = [*command.split(), "build", "-t", f"tatu:{version}", "--build-arg", f"VERSION={version}", work]
        try:
            ran = subprocess.run(call, check=False)
        except OSError as error:
            print(f"the image was not built: {command}: {error}", file=sys.stderr)
            return False
    if ran.returncode != 0:
        print(f"the image was not built: `{' '.join(call[:2])}` has failed; see above", file=sys.stderr)
        return False
    print(f"image tatu:{version}")
    return True


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="?", default="tarball", choices=["tarball", "deb", "docker", "all", "notices"])
    parser.add_argument("--target", type=Path, help="cargo's target folder; default: CARGO_TARGET_DIR, or target")
    parser.add_argument("--built", type=Path, help="a folder that contains the program and its plugins; the plugins may be in its subfolder deps")
    parser.add_argument("--out", type=Path, default=ROOT / "target" / "packages", help="default: target/packages")
    parser.add_argument("--docker", default="docker", help="the command that builds images; default: docker")
    parser.add_argument("--maintainer", default=MAINTAINER, help="maintainer of the Debian package: NAME <ADDRESS>")
    parser.add_argument("--also", action="append", default=[], metavar="PACKAGE",
                        help="for notices: a further package of the workspace to include; may be given several times")
    args = parser.parse_args()
    target = args.target or Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target")
    metadata = read_metadata()
    root = next(p for p in metadata["packages"] if p["id"] == metadata["resolve"]["root"])
    version = root["version"]
    if args.what == "notices":
        text = third_party.write(metadata, ROOT, args.built or target / "release", args.also)
        args.out.mkdir(parents=True, exist_ok=True)
        (args.out / "THIRD-PARTY.txt").write_text(text, encoding="utf-8")
        print(args.out / "THIRD-PARTY.txt")
        return
    built = args.built.resolve() if args.built else build(target.resolve())
    when = time_of_files()
    entries = layout.collect(ROOT, built, metadata, version)
    elves = layout.elf_files(entries)
    strangers = [place for place, elf in elves.items() if elf.machine != elf_versions.EM_X86_64]
    if strangers:
        raise SystemExit(f"{built}: {strangers[0]} was not built for x86-64")
    args.out.mkdir(parents=True, exist_ok=True)
    release = ".".join(map(str, elf_versions.highest_glibc(elves.values())))
    print(f"{len(entries)} files, {sum(len(e.data) for e in entries.values()) / 1e6:.1f} MB; needs glibc {release}")

    done, archive = True, None
    if args.what in ("tarball", "docker", "all"):
        archive = tarball(entries, version, when, args.out)
        print(f"{archive} {archive.stat().st_size / 1e6:.1f} MB")
    if args.what in ("deb", "all"):
        package = debian.make(entries, version, args.maintainer, when, args.out)
        print(f"{package} {package.stat().st_size / 1e6:.1f} MB")
    if args.what in ("docker", "all"):
        done = docker(args.docker, archive, version)
    sys.exit(0 if done else 1)


if __name__ == "__main__":
    main()
