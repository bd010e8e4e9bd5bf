"""The text of a script: the lines `#python`, `#luaExec` and `include`, and the names that it uses."""

import linecache
import os
import re
import types

INCLUDE = re.compile(r"^include[ \t]+([\w./\\-]+)[ \t]*(#.*)?$")
LUA_LINE = re.compile(r"^#[ \t]*luaExec[ \t](.*)$", re.MULTILINE)
LUA_BLOCK = re.compile(r"^('''|\"\"\")[ \t]*luaExec\b(.*?)\1", re.MULTILINE | re.DOTALL)
SETTING = re.compile(r"^\s*(\w+)\s*=\s*(.+?)\s*;?\s*$")
# Settings of CoppeliaSim's wrapper that need no action here.
WITHOUT_EFFECT = {"wrapper", "initTimeout", "nakedErrors", "pythonFailWarnOnly"}
MAX_BYTES = 16 << 20


class Source:
    """The text of a script and the file that it comes from."""

    def __init__(self, text, chunk, folder):
        self.text, self.file, self.folder = text, chunk, folder
        self.settings, self.problems = {}, []
        self.paths = [folder] if folder else []
        self.add_folder_of_script()
        self.read_lua()
        self.read_include()

    def add_folder_of_script(self):
        """Adds the folder of the script's file, beside which its modules may be."""
        for file in (os.path.join(self.folder, self.file) if self.folder else self.file, self.file):
            folder = os.path.dirname(os.path.abspath(file))
            if os.path.isfile(file) and folder not in self.paths:
                self.paths.append(folder)

    def read_lua(self):
        """Reads settings from Lua code for CoppeliaSim's wrapper."""
        lua = [m.group(1) for m in LUA_LINE.finditer(self.text)]
        lua += [line for m in LUA_BLOCK.finditer(self.text) for line in m.group(2).splitlines()]
        unknown = []
        for line in (line.split("--")[0].strip() for line in lua):
            setting = SETTING.match(line)
            if setting and setting.group(1) != "local":
                self.settings[setting.group(1)] = setting.group(2)
            elif line:
                unknown.append(line)
        for name in ("additionalPaths", "additionalIncludePaths", "additionalPythonPath"):
            self.paths += re.findall(r"""["']([^"']+)["']""", self.settings.pop(name, ""))
        if "pythonExecutable" in self.settings:
            self.problems.append("`pythonExecutable` has no effect: use `--language python:interpreter=PATH`")
        if unknown:
            self.problems.append("the Lua code in `luaExec` is not run: " + unknown[0])

    def read_include(self):
        """Replaces the text by that of the file that the line `include NAME` names."""
        names = [m.group(1) for m in map(INCLUDE.match, self.text.splitlines()) if m]
        if not names:
            return
        file = self.find(names[0])
        with open(file, encoding="utf-8", errors="replace") as opened:
            self.text = opened.read(MAX_BYTES)
        self.file = file
        self.paths.append(os.path.dirname(os.path.abspath(file)))

    def find(self, name):
        names = [name, name + ".py"]
        for folder in self.paths + [os.path.join(p, "python") for p in self.paths] + [os.getcwd()]:
            for candidate in names:
                file = os.path.join(folder, candidate)
                if os.path.isfile(file):
                    return file
        raise FileNotFoundError("include file '%s' not found" % name)

    def compile(self):
        """Returns the code. Its lines can be shown in tracebacks."""
        linecache.cache[self.file] = (len(self.text), None, self.text.splitlines(True), self.file)
        return compile(self.text, self.file, "exec", dont_inherit=True)


def names(code):
    """Returns all names in the code: of variables, attributes and imports."""
    found, pending = set(), [code]
    while pending:
        one = pending.pop()
        found.update(one.co_names)
        pending += [c for c in one.co_consts if isinstance(c, types.CodeType)]
    return found
