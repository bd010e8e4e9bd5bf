"""The documentation in a package: the Markdown files of the repository, in the same folders below share/doc/tatu, with
links that lead to where the package has the files that they name."""

import os
import re

PLACE = "share/doc/tatu"
# Folders whose pages are about the repository itself, or are packaged with the other files of the folder.
LEFT_OUT = ("tests/", "bench/", "fuzz/", "packages/", "models/", "scenes/", "addons/")
# Folders of which all files belong to the documentation.
WHOLE = ("docs/images/", "plugin-api/schemas/")
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)\)")
# The folder of the headers, as pages name it in commands.
HEADERS = "plugin-api/include"


def is_document(path):
    """Returns whether a package has a file of the repository as documentation."""
    return path.endswith(".md") and not path.startswith(LEFT_OUT) or path.startswith(WHOLE)


def target(place, link):
    """Returns the path that a relative link in a file leads to; None for a link to elsewhere or within the file."""
    path = link.split("#")[0]
    if not path or re.match(r"[a-z]+:", link):
        return None
    return os.path.normpath(os.path.join(os.path.dirname(place), path))


def exists(place, entries):
    """Returns whether a package has this file or folder."""
    return place in entries or any(entry.startswith(f"{place}/") for entry in entries)


def relinked(text, source, moved, entries):
    """Returns the text of a page. `moved` maps paths of the repository to those in the package. Links to files that the
    package lacks become plain text."""
    here = os.path.dirname(moved(source))

    def link(found):
        mark, words, to = found.groups()
        path = target(source, to)
        if path is None:
            return found[0]
        place = moved(path)
        if place is None or not exists(place, entries):
            return words
        anchor = to[to.index("#"):] if "#" in to else ""
        return f"{mark}[{relinked(words, source, moved, entries)}]({os.path.relpath(place, here)}{anchor})"

    # Pages name the folder of the headers in commands, too, in which a link is no link.
    return LINK.sub(link, text).replace(f"-I {HEADERS}", "-I include").replace(f"`{HEADERS}`", "`include`")


def broken_links(pages):
    """Returns the relative links of pages, given as texts by path, that lead to no file or folder of `pages`."""
    found = []
    for place, text in pages.items():
        for _, _, to in LINK.findall(text) if place.endswith(".md") else []:
            path = target(place, to)
            if path is not None and not exists(path, pages):
                found.append(f"{place}: {to}")
    return found
