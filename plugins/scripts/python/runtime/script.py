"""A script: its text, its callbacks and functions."""

import builtins
import re
import sys
import types

from tatu_runtime import link as links, repeat, source as sources

CALLBACK, FUNCTION = 0, 1
INIT, INFO, THREAD = "init", "info", "thread"
VERSION_SUFFIX = re.compile(r"-\d+$")


class Info:
    """What a prelude of a plugin learns about the script, and what it may change."""

    def __init__(self, script, kind, dialect, words):
        self.kind, self.dialect = kind, dialect
        self._script, self._words = script, words

    def has(self, *names):
        """Returns whether the text contains one of the names."""
        return any(name in self._words for name in names)

    def define(self, name, value):
        """Defines a name such as `gripper.open`, in place of a command."""
        space, _, key = name.rpartition(".")
        if not space:
            self._script.builtins[key] = self._script.defined[key] = value
            return
        space = self._script.api.space(space)
        space._own[key] = space.__dict__[key] = value

    def hold(self, level=None):
        """Sets, if a level is given, how many times the running thread has asked not to be switched; returns the level
        before."""
        return self._script.threads.hold(level)

    def command(self, name):
        """Returns a command."""
        return self._script.api.lookup(name)[1]


class Script:
    def __init__(self, api, threads):
        self.api, self.threads = api, threads
        self.rules = {"functions": [], "also": {}, "arguments": {}, "results": {}}
        self.module = types.ModuleType("__main__")
        self.builtins = dict(builtins.__dict__)
        # Names that preludes have defined.
        self.defined = {}
        self.code = None
        self.has_run = False
        self.time = None

    def load(self, source, dialect, kind, preludes):
        """Compiles the text and runs the preludes. Returns the dialect."""
        self.code = source.compile()
        words = sources.names(self.code)
        for number, text in enumerate(preludes):
            scope = {"script": Info(self, kind, dialect, words), "rules": {}}
            exec(compile(text, "<tatu>/prelude%d.py" % number, "exec"), scope)
            self.add_rules(scope["rules"])
        self.rules["functions"] = self.rules["functions"] or ["%s"]
        self.api.single, self.api.exact = bool(self.rules.get("single")), tuple(self.rules.get("exact", ()))
        if self.rules.get("switch"):
            self.threads.switch = self.switch
        if self.rules.get("time") and self.rules.get("wait"):
            self.time = repeat.clock(self.api, self.threads, self.rules["time"], self.rules["wait"])
        self.prepare(source, words)
        return self.rules.get("dialect", dialect)

    def add_rules(self, rules):
        for key, value in rules.items():
            if key == "functions":
                self.rules["functions"].append(value)
            elif isinstance(value, dict):
                self.rules.setdefault(key, {}).update(value)
            else:
                self.rules.setdefault(key, value)

    def switch(self):
        found, command = self.api.lookup(self.rules["switch"])
        if found:
            command()

    def prepare(self, source, words):
        """Fills the global name space."""
        scope = self.module.__dict__
        scope.update(__file__=source.file, __builtins__=self.builtins, self=types.SimpleNamespace())
        self.builtins.update(__import__=self.import_module, require=self.require, help=self.help)
        builtins.require = self.require
        sys.modules["__main__"] = self.module
        sys.path.extend(path for path in source.paths if path not in sys.path)
        # Commands, constants and their name spaces that the text uses without `require`.
        for name in sorted(words):
            if name not in self.builtins and not name.startswith("__"):
                found, value = self.api.lookup(name)
                if found:
                    self.builtins[name] = value
                    setattr(builtins, name, value)

    def import_module(self, name, *args, **named):
        if name == "time" and self.time is not None:
            return self.time
        return builtins.__import__(name, *args, **named)

    def require(self, name):
        """Returns commands that begin with a name, or a module; also sets a global variable of that name."""
        plain = VERSION_SUFFIX.sub("", name)
        found, value = self.api.lookup(plain)
        if not found:
            text = self.api.module(name)
            if text is not None:
                value = types.ModuleType(plain)
                exec(compile(text, "<tatu>/module/%s.py" % name, "exec"), value.__dict__)
            else:
                try:
                    value = builtins.__import__(plain)
                except ModuleNotFoundError as error:
                    if error.name != plain:
                        raise
                    raise ModuleNotFoundError("there is no plugin or module `%s`" % name, name=plain) from None
        if plain.isidentifier():
            self.module.__dict__[plain] = value
            if found:
                setattr(builtins, plain, value)
        return value

    def help(self, thing=None):
        """Prints the declaration of a command, or what Python's `help` prints."""
        text = self.api.describe(getattr(thing, "__qualname__", "")) if callable(thing) else ""
        if text:
            print(text)
        elif thing is None:
            print("help(sim.getObject) describes a command")
        else:
            import pydoc
            print(pydoc.plain(pydoc.render_doc(thing)))

    def callback(self, name):
        """Returns the function of a callback, or None."""
        scope = self.module.__dict__
        names = [pattern % name for pattern in self.rules["functions"]]
        if name in self.rules["also"]:
            names.append(self.rules["also"][name])
        for one in names:
            function = scope.get(one, self.defined.get(one))
            if callable(function):
                return function
        return None

    def function(self, name):
        """Returns the function with a qualified name, or None."""
        # `@` and a language, as in CoppeliaSim, where a script has functions in two languages.
        plain, _, language = name.partition("@")
        if language not in ("", "python"):
            return None
        first, *rest = plain.split(".")
        value = self.module.__dict__.get(first)
        for key in rest:
            value = value.get(key) if isinstance(value, dict) else getattr(value, key, None)
        return value if callable(value) else None

    def defines(self, how, name):
        if how == FUNCTION:
            return self.function(name) is not None
        if not self.has_run:
            return name in (INIT, INFO)
        return name == INIT or self.callback(name) is not None

    def run(self):
        """Runs the text, once."""
        if not self.has_run:
            self.has_run = True
            exec(self.code, self.module.__dict__)

    def call(self, how, name, args):
        """Calls a callback or function. Returns False and None if it waits, otherwise True and its result."""
        if how == FUNCTION:
            function = self.function(name)
            if function is None:
                raise links.SimError("the script has no function `%s`" % name, -3)
            return True, function(*args)
        if not self.has_run:
            self.run()
            info = self.callback(INFO)
            if name != INFO and info is not None:
                info()
        function = self.callback(name)
        if function is None:
            return True, None
        if name == THREAD:
            return self.threads.start(function, args)
        renamed = self.rules["arguments"].get(name)
        if renamed and args and isinstance(args[0], dict):
            args[0] = rename(args[0], renamed)
        result = function(*args)
        renamed = self.rules["results"].get(name)
        if renamed and isinstance(result, dict):
            result = rename(result, renamed)
        return True, result

    def save(self):
        """Returns what the script saves of its state."""
        function = self.callback("savestate")
        if function is None:
            raise links.SimError("the state of a script in Python", -5,
                                 "define `sysCall_savestate`, which returns what is to be saved, and "
                                 "`sysCall_loadstate`, which gets it")
        return function()

    def restore(self, same, state):
        """Passes saved state to the script. Before the script has run, its text must be the one that saved it."""
        if not self.has_run:
            if not same:
                raise links.SimError("the text of the script has changed", -5)
            self.run()
        function = self.callback("loadstate")
        if function is None:
            raise links.SimError("the script does not define `sysCall_loadstate`", -5)
        function(state)


def rename(entries, names):
    """Renames keys of a dict; a name may also be a list of names."""
    out = {}
    for key, value in entries.items():
        new = names.get(key, key)
        for one in new if isinstance(new, (list, tuple)) else [new]:
            out[one] = value
    return out
