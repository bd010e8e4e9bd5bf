"""Packages of any release and architecture of Debian, unpacked into a folder, beside and apart from this machine's own."""

import hashlib
import lzma
import subprocess
import urllib.request

MIRROR = "http://deb.debian.org"
# Releases that have left the mirror.
ARCHIVE = "http://archive.debian.org"


class Missing(Exception):
    """What could not be fetched."""


def fetch(url):
    try:
        with urllib.request.urlopen(url, timeout=60) as answer:
            return answer.read()
    except OSError as error:
        raise Missing(f"{url}: {error}") from None


def index(suite, architecture):
    """Packages of a suite by name: their path on the mirror and their SHA-256; and the mirror."""
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
                # The newest is last.
                found[fields["Package"]] = (fields["Filename"], fields["SHA256"])
        return mirror, found
    raise why


def unpack(suite, architecture, packages, folder):
    """Unpacks packages, without those that they depend on, into a folder, unless they are there."""
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
            raise Missing(f"{mirror}/{path}: is not what the index tells")
        file = folder / "package.deb"
        file.write_bytes(data)
        subprocess.run(["dpkg-deb", "-x", str(file), str(folder)], check=True)
        file.unlink()
    done.write_text(" ".join(packages))
    return folder
