"""Commands and constants of the simulator as objects: `sim.getObject`, `sim.handle_all`.

Names are looked up when a script first uses them.
"""

import math
import struct

from tatu_runtime import link as links, wire

FLOAT32 = struct.Struct("<f")
NOTHING, COMMAND, CONSTANT, NAME_SPACE = range(4)


class Api:
    """Access to the commands of all plugins."""

    def __init__(self, link, threads, functions):
        self.link, self.threads, self.functions = link, threads, functions
        self.writer = wire.Writer(functions.borrow, functions.foreign_id)
        self.spaces = {}
        # Whether numbers are rounded to 32-bit floats when they are passed, and commands that are excepted.
        self.single, self.exact = False, ()

    def reader(self, data):
        return wire.Reader(data, self.functions.get, self.foreign)

    def foreign(self, number):
        return ForeignFunction(self, number)

    def write(self, values):
        """Returns the parts of a list of values."""
        parts = [wire.pack_u32(len(values))]
        at = 0
        try:
            for value in values:
                at += 1
                self.writer.value(parts, value)
        except wire.Unsendable as problem:
            raise wire.Unsendable("argument %d: %s" % (at, problem)) from None
        return parts

    def call(self, kind, target, args):
        """Calls a command or a function of another script. `target` is the packed number."""
        threads = self.threads
        if kind == links.COMMAND:
            if threads.running is not None:
                threads.count()
                target += b"\1"
            else:
                target += b"\0"
        functions = self.functions
        outer, functions.scope = functions.scope, []
        try:
            parts = self.write(args)
        finally:
            borrowed, functions.scope = functions.scope, outer
        try:
            body = self.link.ask(kind, target, *parts)
            n = wire.unpack_u32(body)[0]
            if n == 0:
                return None
            if n == 1 and body[4] == wire.FLOAT:
                return wire.unpack_float(body, 5)[0]
            reader = self.reader(body)
            reader.at = 4
            if n == 1:
                return reader.value()
            return tuple([reader.value() for _ in range(n)])
        finally:
            if borrowed:
                functions.release(borrowed)

    def lookup(self, name):
        """Returns what a name stands for: (True, value) or (False, None)."""
        reader = self.reader(self.link.ask(links.LOOKUP, wire.text(name.encode())))
        kind = reader.byte()
        if kind == COMMAND:
            return True, self.command(name, reader.u32())
        if kind == CONSTANT:
            return True, reader.value()
        if kind == NAME_SPACE:
            return True, self.space(name)
        return False, None

    def command(self, name, packed):
        api, target, short = self, wire.pack_u32(packed), name.rpartition(".")[2]

        def command(*args):
            return api.call(links.COMMAND, target, args)

        def single_command(*args):
            return single(api.call(links.COMMAND, target, single(args)))

        if self.single and name not in self.exact:
            command = single_command

        command.__name__, command.__qualname__ = short, name
        return command

    def space(self, name):
        if name not in self.spaces:
            self.spaces[name] = Space(self, name)
        return self.spaces[name]

    def nearest(self, name):
        return wire.Reader(self.link.ask(links.NEAREST, wire.text(name.encode()))).text()

    def describe(self, name):
        """Returns the declaration of a command, or an empty text."""
        reader = wire.Reader(self.link.ask(links.LOOKUP, wire.text(name.encode())))
        if reader.byte() != COMMAND:
            return ""
        return wire.Reader(self.link.ask(links.DESCRIBE, wire.pack_u32(reader.u32()))).text()

    def module(self, name):
        """Returns the text of a module that a plugin provides, or None."""
        reader = wire.Reader(self.link.ask(links.MODULE, wire.text(name.encode())))
        return reader.text() if reader.byte() else None

    def refresh(self):
        """Forgets what names stand for, because commands were added or removed."""
        for space in self.spaces.values():
            space.__dict__.clear()
            space.__dict__.update(space._own)


def single(value):
    """Rounds all floats in a value to 32 bits."""
    kind = type(value)
    if kind is float:
        try:
            return FLOAT32.unpack(FLOAT32.pack(value))[0]
        except OverflowError:
            return math.copysign(math.inf, value)
    if kind is list or kind is tuple:
        return kind([single(item) for item in value])
    if kind is dict:
        return {key: single(item) for key, item in value.items()}
    if hasattr(value, "tolist"):
        return single(value.tolist())
    return value


class Space:
    """A name space of commands and constants, such as `sim`."""

    __slots__ = ("__dict__", "_api", "_name", "_own")

    def __init__(self, api, name):
        self._api, self._name, self._own = api, name, {}

    def __getattr__(self, key):
        if key.startswith("__"):
            raise AttributeError(key)
        name = self._name + "." + key
        found, value = self._api.lookup(name)
        if not found:
            near = self._api.nearest(name)
            hint = "; did you mean `%s`?" % near if near else ""
            raise AttributeError("no plugin offers a command or constant `%s`%s" % (name, hint)) from None
        self.__dict__[key] = value
        return value

    def __repr__(self):
        return "<commands `%s.`>" % self._name


class ForeignFunction:
    """A function of another script."""

    __slots__ = ("api", "number")

    def __init__(self, api, number):
        self.api, self.number = api, number

    def __call__(self, *args):
        return self.api.call(links.FUNCTION, self.number.to_bytes(8, "little"), args)


class Functions:
    """Functions of the script that are passed to the simulator: borrowed for a call, or kept until it drops them."""

    FIRST_KEPT = 1 << 31

    def __init__(self):
        self.table = {}
        self.last = 0
        # Numbers of the functions that have been borrowed for the call that is being written.
        self.scope = []

    def borrow(self, function):
        self.last = self.last % (self.FIRST_KEPT - 1) + 1
        self.table[self.last] = function
        self.scope.append(self.last)
        return self.last

    def release(self, borrowed):
        for local in borrowed:
            self.table.pop(local, None)
        borrowed.clear()

    def keep(self, local, kept):
        if local in self.table:
            self.table[kept] = self.table[local]

    def drop(self, local):
        self.table.pop(local, None)

    def get(self, local):
        return self.table.get(local)

    @staticmethod
    def foreign_id(value):
        return value.number if isinstance(value, ForeignFunction) else None
