#!/usr/bin/env python3
"""Tests which glibc ELF files need: elf.py FILE_OR_DIR... [--glibc 2.28]

Reads all programs and libraries in the given folders, wheels, zip files and tarballs. Fails if one needs a symbol of a
later glibc, including weak symbols, and lists file, version and symbol.
"""

import argparse
import contextlib
import io
import os
import struct
import sys
import tarfile
import tempfile
import zipfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "packages"))
import elf_versions  # noqa: E402

MAGIC = elf_versions.MAGIC


def members(path):
    """Yields the name and bytes of each ELF file at a path."""
    if path.is_dir():
        for place, folders, files in os.walk(path):
            folders.sort()
            for name in sorted(files):
                file = Path(place) / name
                if file.is_file() and not file.is_symlink():
                    yield from members_of_file(file, whole=False)
    else:
        yield from members_of_file(path, whole=True)


def members_of_file(path, whole):
    with open(path, "rb") as file:
        start = file.read(4)
    if start == MAGIC:
        yield str(path), path.read_bytes()
    elif zipfile.is_zipfile(path):
        with zipfile.ZipFile(path) as archive:
            for name in sorted(archive.namelist()):
                data = archive.read(name)
                if data[:4] == MAGIC:
                    yield f"{path}: {name}", data
    elif path.name.endswith((".tar", ".tar.gz", ".tgz", ".tar.xz")):
        with tarfile.open(path) as archive:
            for member in archive:
                data = archive.extractfile(member).read() if member.isfile() else b""
                if data[:4] == MAGIC:
                    yield f"{path}: {member.name}", data
    elif whole:
        raise SystemExit(f"{path}: expected an ELF file, a wheel, a zip or a tarball")


def number(text):
    return tuple(int(part) for part in text.split("."))


def run(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("path", nargs="+", type=Path)
    parser.add_argument("--glibc", type=number, default=(2, 28), help="the latest release that may be needed")
    args = parser.parse_args(arguments)
    wrong, count, highest = [], 0, (0,)
    for path in args.path:
        if not path.exists():
            raise SystemExit(f"{path}: there is no such file or folder")
        for name, data in members(path):
            count += 1
            try:
                elf = elf_versions.Elf(data)
            except ValueError as error:
                wrong.append(f"{name}: {error}")
                continue
            highest = max(highest, elf_versions.highest_glibc([elf]))
            for (_, version), symbols in sorted(elf.versions.items()):
                if (elf_versions.glibc(version) or (0,)) > args.glibc:
                    wrong += [f"{name}: {version}: {symbol}" for symbol in symbols or ["(no particular symbol)"]]
    limit = ".".join(map(str, args.glibc))
    if count == 0:
        wrong.append("the given paths contain no ELF file")
    for line in wrong:
        print(f"FAIL  {line}")
    if not wrong:
        print(f"{count} ELF files need glibc {'.'.join(map(str, highest))}, at most {limit} is allowed")
    return 1 if wrong else 0


def made_up(version, order="<"):
    """Returns a minimal library that imports one symbol `f` with a version of libc.so.6."""
    strings = b"\0libc.so.6\0f\0" + version.encode() + b"\0"
    libc, symbol, name = 1, 11, 13

    def pack(form, *values):
        return struct.pack(order + form, *values)

    headers = 64 + 2 * 56
    parts, at = {}, headers
    for key, data in [
        ("strings", strings + b"\0" * (-len(strings) % 8)),
        ("symbols", b"\0" * 24 + pack("IBBHQQ", symbol, 0x12, 0, 0, 0, 0)),
        ("indices", pack("HH4x", 0, 2)),
        ("needs", pack("HHIII", 1, 1, libc, 16, 0) + pack("IHHII", 0, 0, 2, name, 0)),
        # The hash table has one empty bucket, because all symbols are imported; the first hashed symbol would have
        # index 2.
        ("hashes", pack("IIII", 1, 2, 1, 0) + pack("QI4x", 0, 0)),
    ]:
        parts[key] = (at, data)
        at += len(data)
    place = {key: start for key, (start, _) in parts.items()}
    tags = [(elf_versions.DT_NEEDED, libc), (elf_versions.DT_STRTAB, place["strings"]),
            (elf_versions.DT_SYMTAB, place["symbols"]), (elf_versions.DT_VERSYM, place["indices"]),
            (elf_versions.DT_VERNEED, place["needs"]), (elf_versions.DT_VERNEEDNUM, 1),
            (elf_versions.DT_GNU_HASH, place["hashes"]), (0, 0)]
    dynamic = b"".join(pack("qQ", *tag) for tag in tags)
    size = at + len(dynamic)
    ident = MAGIC + bytes([2, 1 if order == "<" else 2, 1]) + b"\0" * 9
    header = ident + pack("HHIQQQIHHHHHH", 3, elf_versions.EM_X86_64, 1, 0, 64, 0, 0, 64, 56, 2, 0, 0, 0)
    load = pack("IIQQQQQQ", elf_versions.PT_LOAD, 4, 0, 0, 0, size, size, 4096)
    segment = pack("IIQQQQQQ", elf_versions.PT_DYNAMIC, 4, at, at, at, len(dynamic), len(dynamic), 8)
    return header + load + segment + b"".join(data for _, data in parts.values()) + dynamic


def test():
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "libmade_up.so"
        wheel = Path(folder) / "made_up-1-py3-none-any.whl"

        def tried(version, *options, order="<", cut=None, inside=None):
            data = made_up(version, order)[:cut]
            place.write_bytes(data)
            with zipfile.ZipFile(wheel, "w") as archive:
                archive.writestr("made_up/lib.so", data)
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                code = run([str(inside or place), *options])
            return code, out.getvalue()

        assert tried("GLIBC_2.28")[0] == 0
        assert tried("GLIBC_2.2.5")[0] == 0
        assert tried("GCC_3.0")[0] == 0
        assert tried("GLIBC_2.34", "--glibc", "2.34")[0] == 0
        for version in ["GLIBC_2.29", "GLIBC_2.34", "GLIBC_2.100", "GLIBC_3.0", "GLIBC_ABI_DT_RELR", "GLIBC_PRIVATE"]:
            for order in "<>":
                code, said = tried(version, order=order)
                assert code == 1 and f"{place}: {version}: f\n" in said, said
        assert tried("GLIBC_2.29", inside=wheel) == (1, f"FAIL  {wheel}: made_up/lib.so: GLIBC_2.29: f\n")
        assert tried("GLIBC_2.29", inside=folder)[1].count("FAIL") == 2
        for cut in range(4, len(made_up("GLIBC_2.28")), 7):
            assert tried("GLIBC_2.28", cut=cut)[0] == 1, f"cut after {cut} bytes"


if __name__ == "__main__":
    test()
    sys.exit(run(sys.argv[1:]))
