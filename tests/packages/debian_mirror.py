"""Unpacks packages of any Debian release and architecture into a folder, independently of this machine's packages."""

import hashlib
import lzma
import subprocess
import urllib.request

MIRROR = "http://deb.debian.org"
# The archive contains old releases, which the mirror no longer has.
ARCHIVE = "http://archive.debian.org"


class Missing(Exception):
    """Raised if a package or another file of the mirror is missing, damaged or cannot be fetched."""


def fetch(url):
    try:
        with urllib.request.urlopen(url, timeout=60) as answer:
            return answer.read()
    except OSError as error:
        raise Missing(f"{url}: {error}") from None


def index(suite, architecture):
    """Returns a dictionary from each package of a suite to its path on the mirror and SHA-256, and the mirror's URL."""
    tree = "debian-security" if suite.endswith("-security") else "debian"
    for mirror in (f"{MIRROR}/{tree}", f"{ARCHIVE}/{tree}"):
        try:
            packed = fetch(f"{mirror}/dists/{suite}/main/binary-{architecture}/Packages.xz")
        except Missing as error:
            why = error
            continue
        found = {}
        for entry in lzma.decompress(packed).decode().split("\n\n"):
            fields = dict(line.split(": ", 1) for line in entry.split("\n") if ": " in line and line[0] != " ")
            if "Package" in fields:
                # The newest version is the last entry.
                found[fields["Package"]] = (fields["Filename"], fields["SHA256"])
        return mirror, found
    raise why


def unpack(suite, architecture, packages, folder):
    """Unpacks packages, without their dependencies, into a folder, unless it already contains them."""
    done = folder / f".{suite}-{architecture}"
    if done.exists() and done.read_text() == " ".join(packages):
        return folder
    mirror, found = index(suite, architecture)
    folder.mkdir(parents=True, exist_ok=True)
    for name in packages:
        if name not in found:
            raise Missing(f"{suite} for {architecture} has no package {name}")
        path, digest = found[name]
        data = fetch(f"{mirror}/{path}")
        if hashlib.sha256(data).hexdigest() != digest:
            raise Missing(f"{mirror}/{path}: the SHA-256 differs from that in the index")
        file = folder / "package.deb"
        file.write_bytes(data)
        subprocess.run(["dpkg-deb", "-x", str(file), str(folder)], check=True)
        file.unlink()
    done.write_text(" ".join(packages))
    return folder
