#!/usr/bin/env python3
"""Tests a tarball of the program in isolation: tarball.py TARBALL [--root DIR] [--hash HASH]

Unpacks the tarball below a read-only folder of a root file system with only glibc (created here, or given as DIR), and
tests it without any network except for the loopback interface. Prints the tests; the exit code is 1 if one fails. Needs
Linux, and `unshare` as root or with user namespaces.
"""

import argparse
import json
import os
import re
import select
import subprocess
import sys
import tarfile
import tempfile
import time
from pathlib import Path

import bare_root
import page_check

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "packages"))
import documents  # noqa: E402

SCENE = "first/pioneer_avoids_walls.toml"
STEPS = "200"
# A writable folder in the root file system.
TEMPORARY = "/tmp"
# The page that tells users which hash to expect.
GUIDE = Path(__file__).resolve().parents[2] / "docs/guide/install.md"
# Minimum number of files: the program, plugins, models, scenes and headers.
FEWEST_FILES = 500


class Failed(Exception):
    """A test failed."""


def expect(holds, text):
    if not holds:
        raise Failed(text)


class Trial:
    """A tarball that is unpacked in a root file system."""

    def __init__(self, archive, root):
        self.root = root
        with tarfile.open(archive) as tar:
            self.members = tar.getmembers()
            self.names = [m.name for m in self.members]
            self.top = self.names[0].split("/")[0]
            safe = all(m.name.split("/")[0] == self.top and ".." not in m.name.split("/") for m in self.members)
            if not safe or not all(m.isfile() or m.isdir() for m in self.members):
                raise SystemExit(f"{archive}: expected files and folders below one folder only")
            tar.extractall(root / "opt")
        subprocess.run(["mount", "-o", "remount,bind,ro", str(root / "opt")], check=True)
        self.home = f"/opt/{self.top}"

    def inside(self):
        os.chroot(self.root)
        os.chdir(TEMPORARY)

    def start(self, *args):
        command = [f"{self.home}/bin/tatu", *args]
        environment = {"PATH": "/usr/bin:/bin", "HOME": TEMPORARY}
        return subprocess.Popen(command, preexec_fn=self.inside, env=environment, stdin=subprocess.DEVNULL,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def tatu(self, *args):
        """Runs the program and returns its output. The test fails if the program prints a warning."""
        process = self.start(*args)
        out, err = process.communicate(timeout=300)
        expect(process.returncode == 0, f"`tatu {' '.join(args)}` ended with {process.returncode}: {err.strip()}")
        expect("warning" not in err and "error" not in err, f"`tatu {' '.join(args)}` warned: {err.strip()}")
        return out

    def files(self, folder, suffix):
        start = f"{self.top}/{folder}/"
        return [n[len(start):] for n in self.names if n.startswith(start) and n.endswith(suffix)]


def archive_is_neutral(trial, _):
    """names are sorted, owners are 0, there is one time, and everyone may read"""
    files = [m.name for m in trial.members if m.isfile()]
    expect(files == sorted(files), "the names are not sorted")
    expect({(m.uid, m.gid) for m in trial.members} == {(0, 0)}, "a file belongs to a user or group other than 0")
    expect(len({m.mtime for m in trial.members}) == 1, "the files do not all have the same time")
    odd = [m.name for m in trial.members if m.mode not in ((0o755,) if m.isdir() else (0o644, 0o755))]
    expect(not odd, f"not readable by all users: {odd[:3]}")
    expect(len(files) >= FEWEST_FILES, f"only {len(files)} files")
    return f"{len(files)} files"


def version(trial, _):
    """`tatu --version` is that of the tarball's name"""
    said = trial.tatu("--version").strip()
    expect(said == "tatu " + trial.top.split("-")[1], f"said `{said}`")
    return said


def plugins(trial, _):
    """`tatu list plugins` has all libraries"""
    listed = json.loads(trial.tatu("list", "plugins", "--json"))
    files = trial.files("lib/tatu/plugins", ".so")
    own = {os.path.basename(p["path"]) for p in listed if p["path"].startswith(trial.home)}
    expect(own == set(files) and files, f"not loaded: {sorted(set(files) - own)}")
    odd = [f for f in files if re.search("test|template|knock|tally|misbehaves|libtatu_compass", f)]
    expect(not odd, f"plugins of tests are included: {odd}")
    return f"{len(files)} plugins"


def models(trial, _):
    """`tatu list models` has all folders"""
    listed = trial.tatu("list", "models")
    names = [m.split("/")[0] for m in trial.files("share/tatu/models", "/model.toml") if m.count("/") == 1]
    missing = [n for n in names if not re.search(rf"^{n}\s", listed, re.MULTILINE)]
    expect(names and not missing, f"not listed: {missing}")
    return f"{len(names)} models"


def addons(trial, _):
    """`tatu list addons` has all scripts"""
    listed = trial.tatu("list", "addons")
    names = [a[:-len(".lua")] for a in trial.files("share/tatu/addons", ".lua") if "/" not in a]
    missing = [n for n in names if not re.search(rf"^{n}\s", listed, re.MULTILINE)]
    expect(names and not missing, f"not listed: {', '.join(missing)}")
    return f"{len(names)} add-ons"


def documentation(trial, _):
    """links in all pages lead to files of the package"""
    start = f"{trial.top}/"
    names = [n[len(start):] for n in trial.names if n.startswith(start)]
    folder = trial.root / trial.home.lstrip("/")
    pages = {n: (folder / n).read_text(encoding="utf-8") for n in names if n.endswith(".md")}
    broken = documents.broken_links({**dict.fromkeys(names, ""), **pages})
    expect(f"{documents.PLACE}/docs/README.md" in pages and not broken, f"broken links: {broken[:3]}")
    return f"{len(pages)} pages"


def run(trial, scene, *args):
    return json.loads(trial.tatu("run", scene, "--steps", STEPS, "--json", *args))["hash"]


def expected_hash():
    """Returns the hash stated in the guide."""
    told = re.findall(rf"^{STEPS} steps,.* hash ([0-9a-f]+)$", GUIDE.read_text(encoding="utf-8"), re.MULTILINE)
    expect(len(told) == 1, f"{GUIDE}: expected one line `{STEPS} steps, ... hash HASH`")
    return told[0]


def scene(trial, args):
    """`tatu run FILE` has the hash of the guide, with one thread and with two"""
    path = f"{trial.home}/share/tatu/scenes/{SCENE}"
    first, second = run(trial, path), run(trial, path, "--threads", "2")
    expect(first == second, f"the hash is {first} with one thread and {second} with two")
    wanted = args.hash or expected_hash()
    expect(first == wanted, f"the hash is {first}, expected {wanted}")
    return first


def name(trial, _):
    """`tatu run NAME` finds a scene of the program from any folder"""
    by_name, path = os.path.basename(SCENE), f"{trial.home}/share/tatu/scenes/{SCENE}"
    got, wanted = run(trial, by_name), run(trial, path)
    expect(got == wanted, f"the hash is {got} by name, but {wanted} by path")
    return by_name


def picture(trial, _):
    """`tatu look` writes a picture"""
    trial.tatu("look", f"{trial.home}/share/tatu/scenes/{SCENE}", "--size", "160x120", "-o", f"{TEMPORARY}/scene.png")
    data = (trial.root / "tmp/scene.png").read_bytes()
    expect(data.startswith(b"\x89PNG"), "the picture is not a PNG file")
    return f"{len(data)} bytes"


def page(trial, _):
    """`tatu open --no-browser` serves the page with its libraries, and names no other server"""
    process = trial.start("open", "--no-browser", f"{trial.home}/share/tatu/scenes/{SCENE}")
    try:
        ready, _, _ = select.select([process.stdout], [], [], 60)
        address = process.stdout.readline().strip() if ready else ""
        if not address.startswith("http://127.0.0.1:"):
            process.kill()
            raise Failed(f"expected an address, found `{address}`: {process.communicate()[1].strip()}")
        wrong, count, size = page_check.check(address)
        expect(not wrong, "; ".join(wrong[:5]))
    finally:
        process.terminate()
        try:
            process.communicate(timeout=20)
        except subprocess.TimeoutExpired:
            process.kill()
    return f"{count} files, {size / 1e6:.1f} MB"


CHECKS = [archive_is_neutral, version, plugins, models, addons, documentation, scene, name, picture, page]


def try_all(args):
    """Runs the tests in new namespaces, so that all mounts and processes disappear when the tests end."""
    root, wrong = args.inside, 0
    if args.root:
        subprocess.run(["mount", "--bind", str(args.root), str(root)], check=True)
    else:
        subprocess.run(["mount", "-t", "tmpfs", "tmpfs", str(root)], check=True)
        bare_root.make(root)
    bare_root.mount(root)
    bare_root.switch_loopback_on()
    trial = Trial(args.tarball, root)
    found = bare_root.tools_in(root)
    print(f"{args.root or 'glibc alone'}: " + (f"FAIL: has {', '.join(found)}" if found else "no compiler, no Node"))
    wrong += bool(found)
    for check in CHECKS:
        name, what = check.__name__, check.__doc__
        if name in args.without:
            print(f"skip  {name}: {what}")
            continue
        began = time.monotonic()
        try:
            outcome, text = "pass", check(trial, args)
        except (Failed, OSError, ValueError, KeyError, subprocess.TimeoutExpired) as error:
            outcome, text, wrong = "FAIL", error, wrong + 1
        print(f"{outcome}  {name}: {what}: {text} ({time.monotonic() - began:.1f} s)", flush=True)
    return 1 if wrong else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tarball", type=Path)
    parser.add_argument("--root", type=Path, help="a root file system without compiler, such as one of debootstrap")
    parser.add_argument("--hash", help="the hash that the scene must have; default: that of the guide")
    parser.add_argument("--without", action="append", default=[], choices=[c.__name__ for c in CHECKS])
    parser.add_argument("--inside", type=Path, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.inside:
        sys.exit(try_all(args))
    page_check.test()
    command = ["unshare", "--net", "--mount", "--pid", "--fork", "--mount-proc"]
    if os.geteuid() != 0:
        command.append("--map-root-user")
    folder = tempfile.mkdtemp(prefix="tatu-root-")
    try:
        ran = subprocess.run([*command, sys.executable, __file__, "--inside", folder, *sys.argv[1:]], check=False)
    except OSError as error:
        raise SystemExit(f"unshare: {error}\n  expected: Linux with util-linux") from None
    finally:
        # The mounts have vanished with the namespace. If one remained, this would fail without deleting anything.
        os.rmdir(folder)
    sys.exit(ran.returncode)


if __name__ == "__main__":
    main()
