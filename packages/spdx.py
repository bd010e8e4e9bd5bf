"""Licence expressions of packages, and the list of licences that packages may have.

Besides SPDX expressions, the older form of crates is supported, in which `MIT/Apache-2.0` means either of the two.
"""

import re
from pathlib import Path

LIST = Path(__file__).resolve().parent / "licences.toml"
TOKEN = re.compile(r"\s*(\(|\)|/|[A-Za-z0-9.+:-]+)")


class NotAnExpression(ValueError):
    """The text is not a licence expression."""


def parse(text):
    """Returns an expression as nested tuples: ("id", text), ("and", [...]) or ("or", [...])."""
    tokens, at = [], 0
    text = (text or "").strip()
    while at < len(text):
        match = TOKEN.match(text, at)
        if not match:
            raise NotAnExpression(f"`{text}`: unexpected `{text[at:].strip()}`")
        tokens.append("OR" if match.group(1) == "/" else match.group(1))
        at = match.end()
    if not tokens:
        raise NotAnExpression("there is no licence expression")

    def take(*wanted):
        if tokens and tokens[0] in wanted:
            return tokens.pop(0)
        return None

    def several(word, kind, one):
        parts = [one()]
        while take(word):
            parts.append(one())
        return parts[0] if len(parts) == 1 else (kind, parts)

    def name():
        if not tokens or tokens[0] in ("(", ")", "AND", "OR", "WITH"):
            raise NotAnExpression(f"`{text}`: expected a licence, found `{tokens[0] if tokens else 'the end'}`")
        return tokens.pop(0)

    def simple():
        if take("("):
            inner = either()
            if not take(")"):
                raise NotAnExpression(f"`{text}`: expected `)`")
            return inner
        licence = name()
        return ("id", f"{licence} WITH {name()}" if take("WITH") else licence)

    def both():
        return several("AND", "and", simple)

    def either():
        return several("OR", "or", both)

    tree = either()
    if tokens:
        raise NotAnExpression(f"`{text}`: unexpected `{tokens[0]}`")
    return tree


def licences(tree):
    """Returns the licences in an expression, in order."""
    kind, value = tree
    return [value] if kind == "id" else [one for part in value for one in licences(part)]


def is_satisfied(tree, allowed):
    """Returns whether an expression can be satisfied by allowed licences only."""
    kind, value = tree
    if kind == "id":
        # SPDX compares identifiers without regard to case; `+` includes the version itself.
        known = {one.lower() for one in allowed}
        return value.lower() in known or value.lower().rstrip("+") in known
    parts = [is_satisfied(part, allowed) for part in value]
    return all(parts) if kind == "and" else any(parts)


def read_list(path=LIST):
    """Returns the tables of a list of licences: {table: {licence: reason}}.

    Only a subset of TOML is supported: tables, and lines `"key" = "text"`. Python has a TOML parser only since 3.11.
    """
    tables, table = {}, None
    for number, line in enumerate(Path(path).read_text(encoding="utf-8").splitlines(), 1):
        line = line.strip()
        head = re.fullmatch(r"\[([a-z-]+)\]", line)
        pair = re.fullmatch(r'"([^"]+)"\s*=\s*"([^"]*)"', line)
        if head:
            table = tables.setdefault(head.group(1), {})
        elif pair and table is not None:
            table[pair.group(1)] = pair.group(2)
        elif line and not line.startswith("#"):
            raise SystemExit(f"{path}:{number}: expected `[table]` or `\"licence\" = \"reason\"`, found `{line}`")
    return tables
