"""Generates THIRD-PARTY.txt: a list of the third-party software in the program, with the terms of each.

The list contains crates that are linked into the program or its plugins, Rust's standard library, Lua, fonts, and the
libraries of the page. Each licence text appears once, with a list of the packages to which it applies.
"""

import html.parser
import json
import os
import re
import subprocess
import tempfile
from pathlib import Path

import spdx

PAGE = "plugins/views/web/page"
# Names of files with terms, and folders whose files are not linked into the program.
TERMS = re.compile(r"^((un)?licen[cs]es?([-_.].*)?|copying.*|copyright.*|notice.*)$", re.IGNORECASE)
NO_TERMS = re.compile(r"\.(rs|js|ts|toml|json|html)$", re.IGNORECASE)
NO_PART = {"tests", "test", "testing", "benches", "examples", "node_modules", "target"}
# Terms in files with other names: those of fonts, and the notice at the end of Lua's header.
MORE_TERMS = {"epaint_default_fonts": ["fonts/*.txt"]}
# Licence texts that are data of a crate, not the crate's terms.
NO_OWN_TERMS = {"spdx": "src/text"}
LUA = ("lua-src", "lua-5.4.*/lua.h")


class Package:
    """A package; `texts` are pairs of a file's name and its text."""

    def __init__(self, name, version, licence, by, where, texts):
        self.name, self.version, self.licence, self.by, self.where = name, version, licence, by, where
        self.texts = sorted(texts)

    def title(self):
        return f"{self.name} {self.version}"


def tidy(text):
    """Normalizes the white space of a text, for comparison."""
    lines = [line.rstrip() for line in text.replace("\r\n", "\n").replace("\f", "").expandtabs().split("\n")]
    return "\n".join(lines).strip("\n")


def read(path):
    return tidy(path.read_bytes().decode("utf-8", "replace"))


def texts_in(folder, more=(), without=None):
    """Returns the files with terms in the folder of a package, as pairs of name and text."""
    found = {path for pattern in more for path in folder.glob(pattern)}
    for place, folders, files in os.walk(folder):
        folders[:] = [f for f in folders if f not in NO_PART]
        found |= {Path(place) / f for f in files if TERMS.match(f) and not NO_TERMS.search(f)}
    relative = {path.relative_to(folder).as_posix(): path for path in found}
    return [(name, read(path)) for name, path in relative.items() if not (without and name.startswith(without))]


def is_macro(package):
    return any("proc-macro" in target["kind"] for target in package["targets"])


def linked(metadata, names):
    """Returns the third-party packages that are linked into the root package and into the named packages.

    These are the normal dependencies, except for procedural macros, which only the compiler runs.
    """
    packages = {p["id"]: p for p in metadata["packages"]}
    nodes = {n["id"]: n for n in metadata["resolve"]["nodes"]}
    seen, left = set(), [metadata["resolve"]["root"]]
    for name in names:
        found = [p["id"] for p in metadata["packages"] if p["name"] == name and not p["source"]]
        if not found:
            raise SystemExit(f"there is no package `{name}` in this repository")
        left += found
    while left:
        one = left.pop()
        if one in seen:
            continue
        seen.add(one)
        for dep in nodes[one]["deps"]:
            if any(kind["kind"] is None for kind in dep["dep_kinds"]) and not is_macro(packages[dep["pkg"]]):
                left.append(dep["pkg"])
    return [packages[one] for one in seen if packages[one]["source"]]


def crates(metadata, names):
    result = []
    for crate in linked(metadata, names):
        name, version = crate["name"], crate["version"]
        folder = Path(crate["manifest_path"]).parent
        texts = texts_in(folder, MORE_TERMS.get(name, ()), NO_OWN_TERMS.get(name))
        if crate["license_file"] and not texts:
            texts = [(crate["license_file"], read(folder / crate["license_file"]))]
        where = crate["repository"] or crate["homepage"] or f"https://crates.io/crates/{name}/{version}"
        result.append(Package(name, version, crate["license"], people(crate["authors"]), where, texts))
    return result


def people(names):
    """Returns authors' names without e-mail addresses."""
    return ", ".join(re.sub(r"\s*<[^>]*>", "", name).strip() for name in names if name.strip())


def lua(metadata):
    """Returns the entry for Lua, which is compiled by the build script of its plugin."""
    crate = next(p for p in metadata["packages"] if p["name"] == LUA[0])
    headers = sorted(Path(crate["manifest_path"]).parent.glob(LUA[1]))
    if not headers:
        raise SystemExit(f"{crate['manifest_path']}: expected {LUA[1]} next to it, with Lua's copyright notice")
    text = headers[0].read_text(encoding="utf-8")
    notice = re.search(r"/\*+\n(\* Copyright \(C\).*?)\n\*+/", text, re.DOTALL)
    if not notice:
        raise SystemExit(f"{headers[0]}: expected a notice that begins with `* Copyright (C)`")
    lines = [re.sub(r"^\* ?", "", line) for line in notice.group(1).split("\n")]
    version = headers[0].parent.name.split("-")[1]
    texts = [("lua.h", tidy("\n".join(lines)))]
    return Package("Lua", version, "MIT", "Lua.org, PUC-Rio", "https://www.lua.org", texts)


class Plain(html.parser.HTMLParser):
    """Extracts the text of an HTML page."""

    BLOCKS = {"p", "pre", "h1", "h2", "h3", "h4", "li", "ul", "table", "tr", "div", "details", "summary", "br"}

    def __init__(self):
        super().__init__()
        self.parts, self.hidden, self.pre = [], 0, 0

    def handle_starttag(self, tag, attrs):
        self.hidden += tag in ("style", "script", "title")
        self.pre += tag == "pre"
        self.parts.append("\n" if tag in self.BLOCKS else "")

    def handle_endtag(self, tag):
        self.hidden -= tag in ("style", "script", "title")
        self.pre -= tag == "pre"
        self.parts.append("\n" if tag in self.BLOCKS else "")

    def handle_data(self, data):
        if not self.hidden:
            self.parts.append(data if self.pre else re.sub(r"\s+", " ", data))


def standard_library(root):
    """Returns the entry for Rust's standard library, which is linked into every Rust program."""
    def ask(*args):
        return subprocess.run(["rustc", *args], cwd=root, check=True, capture_output=True, text=True).stdout.strip()

    version = ask("--version").split()[1]
    docs = Path(ask("--print", "sysroot")) / "share/doc/rust"
    notices = docs / "COPYRIGHT-library.html"
    texts = []
    if notices.is_file():
        plain = Plain()
        plain.feed(notices.read_text(encoding="utf-8"))
        texts = [("COPYRIGHT-library", re.sub(r"\n\s*\n\s*\n+", "\n\n", tidy("".join(plain.parts))))]
    else:
        print(f"note: THIRD-PARTY.txt lacks the notices of Rust's standard library: there is no {notices}; install "
              "them with `rustup component add rust-docs`")
    where = "https://github.com/rust-lang/rust"
    by = "The Rust project contributors"
    return Package("Rust standard library", version, "MIT OR Apache-2.0", by, where, texts)


def page_folder(root, built, lock, work):
    """Returns a folder `node_modules` with the locked versions: that of the build or the page, or a new one."""
    wanted = {name: p["version"] for name, p in lock["packages"].items() if name and not p.get("dev")}

    def has_all(folder):
        try:
            about = {name: (folder.parent / name / "package.json").read_text(encoding="utf-8") for name in wanted}
            return all(json.loads(about[name])["version"] == version for name, version in wanted.items())
        except (OSError, ValueError, KeyError):
            return False

    places = sorted(built.glob("build/tatu-views-web-*/out/page/node_modules")) + [root / PAGE / "node_modules"]
    found = next((place for place in places if has_all(place)), None)
    if found:
        return found
    work.mkdir(parents=True)
    for name in ("package.json", "package-lock.json"):
        (work / name).write_bytes((root / PAGE / name).read_bytes())
    command = ["npm", "ci", "--omit=dev", "--ignore-scripts", "--no-audit", "--no-fund"]
    try:
        subprocess.run(command, cwd=work, check=True, stdout=subprocess.DEVNULL)
    except (OSError, subprocess.CalledProcessError) as error:
        raise SystemExit(f"the licences of the page's libraries are missing: no folder node_modules of the build or in "
                         f"{PAGE} has the locked versions, and `{' '.join(command)}` has failed: {error}") from None
    return work / "node_modules"


def libraries(root, built):
    """Returns the npm packages that the page embeds."""
    lock = json.loads((root / PAGE / "package-lock.json").read_text(encoding="utf-8"))
    result = []
    with tempfile.TemporaryDirectory(prefix="tatu-page-") as work:
        modules = page_folder(root, built, lock, Path(work) / "page")
        for place, locked in sorted(lock["packages"].items()):
            if not place or locked.get("dev"):
                continue
            folder = modules.parent / place
            about = json.loads((folder / "package.json").read_text(encoding="utf-8"))
            author, source = about.get("author") or "", about.get("repository") or about.get("homepage") or ""
            author = author.get("name", "") if isinstance(author, dict) else author
            source = source.get("url", "") if isinstance(source, dict) else source
            name = place[len("node_modules/"):]
            texts = texts_in(folder)
            result.append(Package(name, locked["version"], locked.get("license"), people([author]), source, texts))
    return result


def standard_text(package, root, packages):
    """Returns a description and the usual text of the licence of a package without licence files."""
    tree = spdx.parse(package.licence)
    names = spdx.licences(tree)
    if spdx.is_satisfied(tree, ["Apache-2.0"]):
        return "Apache-2.0", read(root / "LICENSE-APACHE")
    if spdx.is_satisfied(tree, ["MIT"]):
        text = read(root / "LICENSE-MIT")
        return "MIT", re.sub(r"^Copyright .*$", f"Copyright (c) {package.by or package.name}", text, 1, re.MULTILINE)
    for other in packages:
        if other.licence in names and len(other.texts) == 1:
            return f"{other.licence}, as for {other.title()}", other.texts[0][1]
    raise SystemExit(f"{package.title()} has no licence file, and this script has no standard text for `{package.licence}`")


def write(metadata, root, built, names=()):
    """Returns the text of THIRD-PARTY.txt for the program, its plugins, and further packages of this repository."""
    groups = [
        ("Crates, Rust's standard library, and Lua", [*crates(metadata, names), standard_library(root), lua(metadata)]),
        ("Libraries of the page", libraries(root, built)),
    ]
    everything = sorted((p for _, group in groups for p in group), key=lambda p: (p.name.lower(), p.version))
    texts = {}
    for package in everything:
        usual = None if package.texts else standard_text(package, root, everything)
        for name, text in package.texts or [(f"no file; {usual[0]}", usual[1])]:
            texts.setdefault(text, []).append(f"{package.title()} ({name})")
    order = sorted(texts, key=lambda text: ([o.lower() for o in texts[text]], text))
    line = "=" * 100
    out = ["Third-party software in Tatu, and its terms", "",
           "Each package is listed with its licence as an SPDX expression, its authors, and the location of its source.",
           "The licence texts follow. If an expression offers several licences, the text of each may be included.", ""]
    for title, group in groups:
        out += [title, "-" * len(title), ""]
        for package in sorted(group, key=lambda p: (p.name.lower(), p.version)):
            out.append(f"{package.title()}: {package.licence}")
            out += [f"    {detail}" for detail in (package.by, package.where) if detail]
        out.append("")
    for text in order:
        out += [line, "Terms of", *(f"    {owner}" for owner in texts[text]), line, "", text, ""]
    return "\n".join(out)
