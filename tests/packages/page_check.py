"""Reads the page of a running program as a browser would: everything that it loads, and from where."""

import html.parser
import http.client
import json
import posixpath
import re
import urllib.parse

IMPORT = re.compile(r"""(?:\bfrom|\bimport)\s*\(?\s*["']((?:\.\.?/|https?:|//)[^"']*)["']""")
OUTSIDE = re.compile(r"^(https?:|wss?:|//)")
URL = re.compile(r"""https?://[^\s"'`)<>]+""")
# Names of XML vocabularies, from which nothing is loaded.
NAMES = ("http://www.w3.org/",)
# What a page without its libraries lacks.
LIBRARIES = ["three", "@codemirror/view", "@codemirror/state", "@lezer/common"]


class Links(html.parser.HTMLParser):
    """What an HTML file loads, and its import map."""

    def __init__(self):
        super().__init__()
        self.links, self.map, self.in_map = [], "", False

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.in_map = tag == "script" and attrs.get("type") == "importmap"
        loads = {"script": "src", "img": "src", "link": "href", "iframe": "src"}
        if attrs.get(loads.get(tag)):
            self.links.append(attrs[loads[tag]])

    def handle_endtag(self, tag):
        self.in_map = False

    def handle_data(self, data):
        if self.in_map:
            self.map += data


def check(address):
    """Returns lines about what is wrong with the page at an address, the number of its files and their bytes."""
    base = urllib.parse.urlsplit(address)
    wrong, total = [], 0

    def fetch(target):
        connection = http.client.HTTPConnection(base.hostname, base.port, timeout=20)
        connection.request("GET", target)
        answer = connection.getresponse()
        data = answer.read()
        connection.close()
        return answer, data

    answer, data = fetch(urllib.parse.urlunsplit(("", "", base.path or "/", base.query, "")))
    if answer.status != 200:
        return [f"{address}: status {answer.status}"], 0, 0
    policy = answer.getheader("Content-Security-Policy", "")
    if "default-src 'none'" not in policy or re.search(r"https?:|\*", policy):
        wrong.append(f"the page's policy allows other servers: `{policy}`")
    page = Links()
    page.feed(data.decode("utf-8"))
    imports = json.loads(page.map or "{}").get("imports", {})
    wrong += [f"the page lacks its library {name}" for name in LIBRARIES if name not in imports]
    left, seen = sorted({*page.links, *imports.values()}), set()
    total += len(data)
    wrong += [f"the page names {url}" for url in URL.findall(data.decode("utf-8")) if not url.startswith(NAMES)]
    while left:
        target = left.pop()
        if target in seen or target.startswith("data:"):
            continue
        seen.add(target)
        if OUTSIDE.match(target):
            wrong.append(f"the page loads {target}, which is on another server")
            continue
        answer, data = fetch(target)
        if answer.status != 200 or not data:
            wrong.append(f"{target}: status {answer.status}, {len(data)} bytes")
        total += len(data)
        text = data.decode("utf-8", "replace")
        for name in IMPORT.findall(text):
            left.append(name if OUTSIDE.match(name) else posixpath.join(posixpath.dirname(target), name))
            left[-1] = left[-1] if OUTSIDE.match(left[-1]) else posixpath.normpath(left[-1])
        if target.startswith("/page/"):
            # The comments of libraries name pages; our own modules name none.
            wrong += [f"{target} names {url}" for url in URL.findall(text) if not url.startswith(NAMES)]
    return wrong, len(seen) + 1, total
