"""Builds a Debian package with the files of a package, installed below /usr."""

import hashlib
import os
import subprocess
import tempfile
from pathlib import Path

import elf_versions
import layout

ARCHITECTURE = "amd64"
# Debian packages by library. All libraries of glibc are in one package.
GLIBC = {"libc.so.6", "libm.so.6", "libdl.so.2", "libpthread.so.0", "librt.so.1", "ld-linux-x86-64.so.2"}
OTHERS = {"libgcc_s.so.1": "libgcc-s1 (>= 4.2)", "libstdc++.so.6": "libstdc++6 (>= 11)"}
# Folders with different paths in Debian packages.
MOVED = {"share/zsh/site-functions/": "share/zsh/vendor-completions/"}

DESCRIPTION = """\
robot simulator made of a small core and plugins
 Tatu simulates robots with sensors and actuators, and runs Lua scripts written
 for V-REP and CoppeliaSim. Runs are reproducible, bit for bit. Scenes are shown
 and edited in a browser, or run without a display.
 .
 The package contains the program with its plugins, models, scenes and add-ons,
 and the headers for plugins in C and C++."""

COPYRIGHT = """\
Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: Tatu

Files: *
Copyright: The Tatu authors
License: MIT or Apache-2.0
Comment: The texts are in LICENSE-MIT and LICENSE-APACHE in this folder. The
 programs contain software of others, whose terms are in THIRD-PARTY.txt.

"""


def depends(elves):
    """Returns the packages that the ELF files need: glibc by the highest required symbol version, others by library."""
    needed = {name for elf in elves.values() for name in elf.needed}
    own = {os.path.basename(place) for place in elves}
    unknown = needed - GLIBC - set(OTHERS) - own
    if unknown:
        users = sorted(p for p, elf in elves.items() if unknown & set(elf.needed))
        raise SystemExit(f"{', '.join(sorted(unknown))}: the Debian package is unknown; needed by {users[0]}\n"
                         "  help: add it to OTHERS in packages/debian.py")
    release = ".".join(map(str, elf_versions.highest_glibc(elves.values())))
    return [f"libc6 (>= {release})"] + sorted(OTHERS[name] for name in needed & set(OTHERS))


def copyright_text(entries):
    """Returns the text of the file `copyright`: the terms of the package, with the full text of the MIT licence."""
    lines = entries["share/doc/tatu/LICENSE-MIT"].data.decode("utf-8").strip().split("\n")
    quoted = "".join(f" {line}\n" if line.strip() else " .\n" for line in lines)
    apache = " On Debian systems, the text is in /usr/share/common-licenses/Apache-2.0.\n"
    return f"{COPYRIGHT}License: MIT\n{quoted}\nLicense: Apache-2.0\n{apache}"


def make(entries, version, maintainer, when, out):
    """Writes the package and returns its path."""
    files = {}
    for place, entry in entries.items():
        for old, new in MOVED.items():
            if place.startswith(old):
                place = new + place[len(old):]
        files[f"usr/{place}"] = entry
    files["usr/share/doc/tatu/copyright"] = layout.Entry(copyright_text(entries).encode("utf-8"))
    files = dict(sorted(files.items()))
    size = sum((len(e.data) + 1023) // 1024 for e in files.values()) + len(layout.folders(files))
    control = "\n".join([
        "Package: tatu",
        f"Version: {version}",
        f"Architecture: {ARCHITECTURE}",
        f"Maintainer: {maintainer}",
        f"Installed-Size: {size}",
        f"Depends: {', '.join(depends(layout.elf_files(entries)))}",
        "Recommends: xdg-utils",
        "Suggests: gcc | c-compiler",
        "Section: science",
        "Priority: optional",
        f"Description: {DESCRIPTION}",
    ]) + "\n"
    sums = "".join(f"{hashlib.md5(e.data).hexdigest()}  {place}\n" for place, e in files.items())
    result = out / f"tatu_{version}_{ARCHITECTURE}.deb"
    with tempfile.TemporaryDirectory(prefix="tatu-deb-") as work:
        stage = Path(work) / "tatu"
        everything = dict(files)
        everything["DEBIAN/control"] = layout.Entry(control.encode("utf-8"))
        everything["DEBIAN/md5sums"] = layout.Entry(sums.encode("utf-8"))
        for place, entry in everything.items():
            path = stage / place
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(entry.data)
            path.chmod(entry.mode)
            os.utime(path, (when, when))
        for folder in reversed([".", *layout.folders(everything)]):
            (stage / folder).chmod(0o755)
            os.utime(stage / folder, (when, when))
        # One thread, because the output of xz depends on the number of threads. All versions of dpkg support xz.
        environment = {**os.environ, "SOURCE_DATE_EPOCH": str(when), "DPKG_DEB_THREADS_MAX": "1"}
        command = ["dpkg-deb", "--root-owner-group", "-Zxz", "-b", str(stage), str(result)]
        try:
            subprocess.run(command, check=True, env=environment, stdout=subprocess.DEVNULL)
        except (OSError, subprocess.CalledProcessError) as error:
            raise SystemExit(f"the Debian package was not built: {error}\n  expected: `dpkg-deb`, which is part of "
                             "Debian and Ubuntu") from None
    return result
