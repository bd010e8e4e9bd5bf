"""The files of a package: the path of each relative to the package's root, and its contents."""

import gzip
import io
import os
import subprocess
from pathlib import Path

import documents
import elf_versions
import third_party

# Folders of the repository that the program reads at run time, and their paths in the package.
DATA = {"models": "share/tatu/models", "scenes": "share/tatu/scenes", "addons": "share/tatu/addons"}
HEADERS = "plugin-api/include"
# The simulator as a library for C.
LIBRARY = "libtatu.so"
WORLD_HEADER = "hosts/libtatu/include/tatu_world.h"
LICENCES = ["LICENSE-APACHE", "LICENSE-MIT"]
# Files that `tatu generate NAME` prints, by path in the package.
GENERATED = {
    "man": "share/man/man1/tatu.1.gz",
    "bash": "share/bash-completion/completions/tatu",
    "zsh": "share/zsh/site-functions/_tatu",
    "fish": "share/fish/vendor_completions.d/tatu.fish",
}
# Bytes that the page's plugin contains if the JavaScript libraries of the page are embedded in it.
WHOLE_PAGE = b"/lib/three/build/three.module.min.js"
PAGE = "libtatu_views_web.so"
HOST = "libtatuhost.so"


class Entry:
    """A file: its contents, and whether it is executable."""

    def __init__(self, data, executable=False):
        self.data = data
        self.mode = 0o755 if executable else 0o644


def zipped(data):
    """Returns bytes compressed by gzip, without a file name and a timestamp."""
    out = io.BytesIO()
    with gzip.GzipFile(filename="", mode="wb", compresslevel=9, fileobj=out, mtime=0) as file:
        file.write(data)
    return out.getvalue()


def plugins(metadata):
    """Returns the file names of the program's own plugins, as the root manifest lists them."""
    packages = {p["id"]: p for p in metadata["packages"]}
    root = packages[metadata["resolve"]["root"]]
    folder = Path(root["manifest_path"]).parent / "plugins"
    places = [Path(d["path"]) for d in root["dependencies"] if d.get("path") and d["kind"] is None]
    own = {place for place in places if folder in place.parents}
    names = []
    for package in packages.values():
        if Path(package["manifest_path"]).parent in own:
            names += [f"lib{t['name'].replace('-', '_')}.so" for t in package["targets"] if "cdylib" in t["kind"]]
    if len(names) != len(own):
        raise SystemExit(f"Cargo.toml lists {len(own)} plugins, of which {len(names)} are libraries")
    return sorted(names)


def built_file(built, name):
    """Returns the path of a library built by cargo, in the folder `deps` or next to the program."""
    places = [built / "deps" / name, built / name]
    found = next((p for p in places if p.is_file()), None)
    if found is None:
        raise SystemExit(f"{built}: there is no {name}, neither here nor in deps\n  expected: the folder of a finished "
                         "`cargo build --release`, such as target/release")
    return found.read_bytes()


def tracked(root, folder):
    """Returns the files of a folder that are tracked by git, as pairs of path and whether the file is executable."""
    command = ["git", "-C", str(root), "ls-files", "-s", "-z", "--", folder]
    try:
        told = subprocess.run(command, check=True, capture_output=True).stdout.decode("utf-8")
    except (OSError, subprocess.CalledProcessError) as error:
        raise SystemExit(f"{root}: git cannot list the files of the repository: {error}\n  expected: a git "
                         "checkout, because files left by runs and builds must not be packaged") from None
    files = []
    for line in filter(None, told.split("\0")):
        mode, path = line.split(" ", 1)[0], line.split("\t", 1)[1]
        if mode in ("100644", "100755") and os.path.basename(path) != ".gitignore":
            files.append((path, mode == "100755"))
    if not files:
        raise SystemExit(f"{root / folder}: git does not track any file in this folder")
    return sorted(files)


def check_version(program, version):
    """Exits with an error unless the program has the same version as the sources."""
    try:
        said = subprocess.run([str(program), "--version"], capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError) as error:
        raise SystemExit(f"{program}: `--version` has failed: {error}") from None
    if said != f"tatu {version}":
        raise SystemExit(f"{program} is `{said}`, but the sources have version {version}\n  help: build it again")


def generated(program, entries):
    """Adds the files that the program generates. Prints a note for each file that the program cannot generate."""
    for name, place in GENERATED.items():
        ran = subprocess.run([str(program), "generate", name], capture_output=True, check=False)
        if ran.returncode != 0 or not ran.stdout:
            print(f"note: {place} is omitted: the program does not support `tatu generate {name}`")
            continue
        entries[place] = Entry(zipped(ran.stdout) if place.endswith(".gz") else ran.stdout)


def moved(path):
    """Returns the path in the package of a file or folder of the repository, if the package has it."""
    if path == WORLD_HEADER:
        return f"include/{os.path.basename(path)}"
    for folder, place in {**DATA, HEADERS: "include"}.items():
        if path == folder or path.startswith(f"{folder}/"):
            return place + path[len(folder):]
    return f"{documents.PLACE}/{path}"


def add_documents(root, entries):
    """Adds the documentation. Links in all pages lead to files of the package."""
    paths = [path for path, _ in tracked(root, ".")]
    entries.update({moved(p): Entry((root / p).read_bytes()) for p in paths if documents.is_document(p)})
    for path in paths:
        if path.endswith(".md") and (entry := entries.get(moved(path))):
            text = documents.relinked(entry.data.decode("utf-8"), path, moved, entries)
            entry.data = text.encode("utf-8")


def collect(root, built, metadata, version):
    """Returns all files of a package by their paths, sorted."""
    program = built / "tatu"
    if not program.is_file():
        raise SystemExit(f"{built}: there is no program `tatu`\n  expected: the folder of a finished `cargo build "
                         "--release`, such as target/release")
    check_version(program, version)
    entries = {"bin/tatu": Entry(program.read_bytes(), True)}
    for name in plugins(metadata):
        entries[f"lib/tatu/plugins/{name}"] = Entry(built_file(built, name))
    entries[f"lib/tatu/{HOST}"] = Entry(built_file(built, HOST))
    if WHOLE_PAGE not in entries[f"lib/tatu/plugins/{PAGE}"].data:
        raise SystemExit(f"{PAGE} is built without the libraries of the page\n  help: install npm, and build again")
    for folder, place in DATA.items():
        for path, executable in tracked(root, folder):
            entries[place + path[len(folder):]] = Entry((root / path).read_bytes(), executable)
    for path, _ in tracked(root, HEADERS):
        entries["include" + path[len(HEADERS):]] = Entry((root / path).read_bytes())
    # Built by `cargo build -p libtatu`; packages can be built without it.
    if any((folder / LIBRARY).is_file() for folder in (built, built / "deps")):
        entries[f"lib/{LIBRARY}"] = Entry(built_file(built, LIBRARY))
        entries["include/tatu_world.h"] = Entry((root / WORLD_HEADER).read_bytes())
    else:
        print(f"note: lib/{LIBRARY} is omitted: build it with `cargo build --release -p libtatu`")
    for name in LICENCES:
        entries[f"{documents.PLACE}/{name}"] = Entry((root / name).read_bytes())
    add_documents(root, entries)
    terms = third_party.write(metadata, root, built)
    entries["share/doc/tatu/THIRD-PARTY.txt"] = Entry(terms.encode("utf-8"))
    generated(program, entries)
    return dict(sorted(entries.items()))


def elf_files(entries):
    """Returns the parsed programs and libraries of a package, by their paths."""
    return {p: elf_versions.Elf(e.data) for p, e in entries.items() if e.data[:4] == elf_versions.MAGIC}


def folders(places):
    """Returns all folders that contain files at these paths, sorted."""
    found = set()
    for place in places:
        found |= {p.as_posix() for p in Path(place).parents if p.as_posix() != "."}
    return sorted(found)
