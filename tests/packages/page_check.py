"""Reads the page of a running program as a browser would: all files that it loads, and their origins."""

import html.parser
import http.client
import http.server
import json
import posixpath
import re
import threading
import urllib.parse

IMPORT = re.compile(r"""(?:\bfrom|\bimport)\s*\(?\s*["']((?:\.\.?/|https?:|//)[^"']*)["']""")
OUTSIDE = re.compile(r"^(https?:|wss?:|//)")
URL = re.compile(r"""https?://[^\s"'`)<>]+""")
# XML namespace names, which are not loaded.
NAMES = ("http://www.w3.org/",)
# Some names that must be in the import map of a page that contains its libraries.
LIBRARIES = ["three", "@codemirror/view", "@codemirror/state", "@lezer/common"]


class Links(html.parser.HTMLParser):
    """Collects the files that an HTML file loads, and its import map."""

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
    """Returns the errors of the page at an address, the number of its files, and their total size in bytes."""
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
            # Comments in libraries contain addresses; the page's own modules must not.
            wrong += [f"{target} names {url}" for url in URL.findall(text) if not url.startswith(NAMES)]
    return wrong, len(seen) + 1, total


def test():
    """Checks with generated pages that each kind of error is detected."""
    policy = "default-src 'none'; script-src 'self'"
    imports = {name: f"/lib/{i}.js" for i, name in enumerate(LIBRARIES)}

    def tried(head="", main="import { a } from './b.js';", policy=policy, imports=imports, gone=None):
        """Returns the errors of a generated page in which some parts are replaced."""
        files = {place: "export const a = 1;" for place in imports.values()}
        files["/page/main.js"], files["/page/b.js"] = main, "// http://www.w3.org/2000/svg"
        map_text = json.dumps({"imports": imports})
        files["/"] = f'<script type="importmap">{map_text}</script><script src="/page/main.js"></script>{head}'
        files.pop(gone, None)

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                data = files.get(self.path.split("?")[0])
                self.send_response(404 if data is None else 200)
                self.send_header("Content-Security-Policy", policy)
                self.end_headers()
                self.wfile.write((data or "").encode("utf-8"))

            def log_message(self, *_):
                pass

        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            wrong, count, _ = check(f"http://127.0.0.1:{server.server_address[1]}/?token=x")
            server.shutdown()
        return wrong if wrong else count

    assert tried() == len(LIBRARIES) + 3, tried()
    for said, parts in [
        ("loads https://example.org/x.js", {"head": '<script src="https://example.org/x.js"></script>'}),
        ("loads //example.org/x.css", {"head": '<link rel="stylesheet" href="//example.org/x.css">'}),
        ("loads https://example.org/y.js", {"main": 'import"https://example.org/y.js"'}),
        ("names https://example.org/z", {"main": "fetch('https://example.org/z')"}),
        ("lacks its library three", {"imports": {k: v for k, v in imports.items() if k != "three"}}),
        ("/page/b.js: status 404", {"gone": "/page/b.js"}),
        ("/lib/0.js: status 404", {"gone": "/lib/0.js"}),
        ("policy allows other servers", {"policy": "default-src 'none'; script-src https://example.org"}),
        ("policy allows other servers", {"policy": ""}),
        ("status 404", {"gone": "/"}),
    ]:
        wrong = tried(**parts)
        assert isinstance(wrong, list) and any(said in line for line in wrong), (said, wrong)


if __name__ == "__main__":
    test()
