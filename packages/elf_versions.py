"""Determines the libraries that an ELF file needs, and the versions of their symbols.

All data is located through the dynamic segment, as in the loader, so stripped section headers do not matter.
"""

import re
import struct

MAGIC = b"\x7fELF"
PT_LOAD, PT_DYNAMIC = 1, 2
DT_NEEDED, DT_HASH, DT_STRTAB, DT_SYMTAB, DT_SONAME = 1, 4, 5, 6, 14
DT_GNU_HASH, DT_VERSYM, DT_VERNEED, DT_VERNEEDNUM = 0x6FFFFEF5, 0x6FFFFFF0, 0x6FFFFFFE, 0x6FFFFFFF
EM_X86_64 = 62
# The symbol version that requests packed relative relocations from the loader, and the first glibc release with it.
RELR, RELR_GLIBC = "GLIBC_ABI_DT_RELR", (2, 36)


class BadElf(ValueError):
    """The file has an ELF header, but its contents are invalid."""


class Elf:
    """An ELF file. `needed`: names of libraries; `versions`: {(library, version): [symbol, ...]}, symbols sorted."""

    def __init__(self, data):
        if data[:4] != MAGIC:
            raise BadElf("not an ELF file")
        if data[4:6] not in (b"\x02\x01", b"\x02\x02"):
            raise BadElf("expected a 64-bit file")
        self.data = data
        self.order = "<" if data[5] == 1 else ">"
        try:
            self._read()
        except (struct.error, IndexError) as error:
            raise BadElf(f"damaged: {error}") from None

    def _get(self, form, at):
        if at < 0:
            raise BadElf("damaged: a negative file offset")
        return struct.unpack_from(self.order + form, self.data, at)

    def _read(self):
        (self.machine,) = self._get("H", 18)
        (headers,) = self._get("Q", 32)
        size, count = self._get("HH", 54)
        self.loads, dynamic = [], None
        for i in range(count):
            kind, _, offset, address, _, in_file = self._get("IIQQQQ", headers + i * size)
            if kind == PT_LOAD:
                self.loads.append((address, offset, in_file))
            elif kind == PT_DYNAMIC:
                dynamic = (offset, in_file)
        self.needed, self.versions, self.soname = [], {}, None
        if dynamic is None:
            return
        tags, names, soname = {}, [], None
        for at in range(dynamic[0], dynamic[0] + dynamic[1], 16):
            tag, value = self._get("qQ", at)
            if tag == 0:
                break
            if tag == DT_NEEDED:
                names.append(value)
            elif tag == DT_SONAME:
                soname = value
            else:
                tags[tag] = value
        if DT_STRTAB not in tags:
            return
        self.strings = self._place(tags[DT_STRTAB])
        self.needed = [self._text(name) for name in names]
        self.soname = None if soname is None else self._text(soname)
        if DT_VERNEED in tags:
            self._read_versions(tags)

    def _read_versions(self, tags):
        by_index, at = {}, self._place(tags[DT_VERNEED])
        for _ in range(tags.get(DT_VERNEEDNUM, 0)):
            _, count, library, first, following = self._get("HHIII", at)
            part = at + first
            for _ in range(count):
                _, _, index, name, after = self._get("IHHII", part)
                key = (self._text(library), self._text(name))
                by_index[index & 0x7FFF] = key
                self.versions[key] = []
                part += after
            at += following
        if DT_VERSYM in tags and DT_SYMTAB in tags:
            indices, symbols = self._place(tags[DT_VERSYM]), self._place(tags[DT_SYMTAB])
            for i in range(self._symbols(tags)):
                (index,) = self._get("H", indices + 2 * i)
                key = by_index.get(index & 0x7FFF)
                if key:
                    self.versions[key].append(self._text(self._get("I", symbols + 24 * i)[0]))
        for names in self.versions.values():
            names.sort()

    def _symbols(self, tags):
        """Returns the number of dynamic symbols, which is derived from the hash tables."""
        if DT_HASH in tags:
            return self._get("II", self._place(tags[DT_HASH]))[1]
        if DT_GNU_HASH not in tags:
            return 0
        at = self._place(tags[DT_GNU_HASH])
        buckets, first, words, _ = self._get("IIII", at)
        table = at + 16 + 8 * words
        last = max(self._get(f"{buckets}I", table), default=0)
        # Symbols that are only imported precede the hashed symbols.
        if last < first:
            return first
        chains = table + 4 * buckets
        while not self._get("I", chains + 4 * (last - first))[0] & 1:
            last += 1
        return last + 1

    def _place(self, address):
        for start, offset, size in self.loads:
            if start <= address < start + size:
                return offset + address - start
        raise BadElf(f"damaged: no segment contains the address {address:#x}")

    def _text(self, offset):
        start = self.strings + offset
        return self.data[start : self.data.index(b"\0", start)].decode("utf-8", "replace")


def glibc(version):
    """Returns the glibc release that introduced a symbol version, as numbers; None if it is not a version of glibc.

    Versions that no release promises, such as GLIBC_PRIVATE, come after all others.
    """
    if version == RELR:
        return RELR_GLIBC
    numbers = re.fullmatch(r"GLIBC_(\d+(?:\.\d+)*)", version)
    if numbers:
        return tuple(int(n) for n in numbers.group(1).split("."))
    return (999,) if version.startswith("GLIBC_") else None


def highest_glibc(files):
    """Returns the glibc release that a set of files needs; (0,) if no file needs glibc."""
    return max((glibc(v) or (0,) for elf in files for _, v in elf.versions), default=(0,))
