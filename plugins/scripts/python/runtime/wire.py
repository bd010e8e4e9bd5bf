"""Values on the wire, little-endian: a tag, then the payload. `src/wire.rs` is the other side."""

import struct

MAX_DEPTH = 32
INT_MIN, INT_MAX = -(1 << 63), (1 << 63) - 1

pack_int = struct.Struct("<Bq").pack
pack_float = struct.Struct("<Bd").pack
pack_head = struct.Struct("<BI").pack
pack_u32 = struct.Struct("<I").pack
unpack_u32 = struct.Struct("<I").unpack_from
unpack_int = struct.Struct("<q").unpack_from
unpack_float = struct.Struct("<d").unpack_from
unpack_u64 = struct.Struct("<Q").unpack_from

NIL, FALSE, TRUE = b"\0", b"\1", b"\2"
# Tags of values that follow.
INT, FLOAT, TEXT, BYTES, FLOATS, INTS, LIST, MAP, OWN_FUNCTION, FUNCTION = range(3, 13)


class Unsendable(TypeError):
    """A value that cannot be passed to the simulator."""


class Writer:
    """Writes values. `function` returns the number of a function of this script; `foreign` the id of another
    script's function, or None."""

    def __init__(self, function, foreign):
        self.function, self.foreign = function, foreign

    def value(self, out, value, depth=0):
        """Appends the parts of a value to `out`."""
        kind = type(value)
        if kind is float:
            out.append(pack_float(FLOAT, value))
        elif kind is int:
            if not INT_MIN <= value <= INT_MAX:
                raise Unsendable("the integer %s does not fit into 64 bits" % brief(value))
            out.append(pack_int(INT, value))
        elif kind is str:
            data = value.encode("utf-8", "surrogateescape")
            out.append(pack_head(TEXT, len(data)))
            out.append(data)
        elif value is None:
            out.append(NIL)
        elif kind is bool:
            out.append(TRUE if value else FALSE)
        elif kind is list or kind is tuple:
            self.sequence(out, value, depth)
        elif kind is dict:
            self.mapping(out, value, depth)
        elif kind is bytes or kind is bytearray or kind is memoryview:
            data = bytes(value)
            out.append(pack_head(BYTES, len(data)))
            out.append(data)
        else:
            self.other(out, value, depth)

    def sequence(self, out, items, depth):
        n = len(items)
        if n:
            kinds = set(map(type, items))
            if kinds == {int}:
                try:
                    out.append(struct.pack("<BI%dq" % n, INTS, n, *items))
                    return
                except struct.error:
                    raise Unsendable("an integer of the list does not fit into 64 bits") from None
            if kinds <= {int, float}:
                try:
                    out.append(struct.pack("<BI%dd" % n, FLOATS, n, *items))
                    return
                except (struct.error, OverflowError):
                    raise Unsendable("a number of the list is too large") from None
        if depth >= MAX_DEPTH:
            raise Unsendable("the list is nested more than %d levels deep, or contains itself" % MAX_DEPTH)
        out.append(pack_head(LIST, n))
        at = 0
        try:
            for item in items:
                self.value(out, item, depth + 1)
                at += 1
        except Unsendable as problem:
            raise Unsendable("[%d]: %s" % (at, problem) if depth < 4 else str(problem)) from None

    def mapping(self, out, entries, depth):
        if depth >= MAX_DEPTH:
            raise Unsendable("the dict is nested more than %d levels deep, or contains itself" % MAX_DEPTH)
        out.append(pack_head(MAP, len(entries)))
        for key, value in entries.items():
            if not isinstance(key, (str, int, float, bool)):
                raise Unsendable("the key %s of the dict is not a str, number or bool" % brief(key))
            self.value(out, key, depth + 1)
            try:
                self.value(out, value, depth + 1)
            except Unsendable as problem:
                raise Unsendable("[%r]: %s" % (key, problem) if depth < 4 else str(problem)) from None

    def other(self, out, value, depth):
        """Writes subclasses of the basic types, arrays and numbers of numpy, and functions."""
        for base in (bool, int, float, str, bytes, list, tuple, dict):
            if isinstance(value, base):
                if base is int:
                    return self.value(out, int.__index__(value), depth)
                return self.value(out, base(value), depth)
        number = self.foreign(value)
        if number is not None:
            out.append(struct.pack("<BQ", FUNCTION, number))
        elif hasattr(value, "tolist"):
            # Arrays and scalars of numpy and of the module `array`.
            plain = value.tolist()
            if type(plain) is type(value):
                raise Unsendable("a value of type %s cannot be passed" % type(value).__name__)
            self.value(out, plain, depth)
        elif isinstance(value, range):
            self.sequence(out, list(value) if len(value) < 1 << 24 else [1 << 64], depth)
        elif callable(value):
            out.append(pack_head(OWN_FUNCTION, self.function(value)))
        elif hasattr(type(value), "__index__"):
            self.value(out, value.__index__(), depth)
        elif hasattr(type(value), "__float__"):
            self.value(out, float(value), depth)
        else:
            raise Unsendable("a value of type %s cannot be passed" % type(value).__name__)


def brief(value):
    try:
        text = repr(value)
    except Exception:
        text = "of type " + type(value).__name__
    return text if len(text) < 60 else text[:57] + "..."


def text(data):
    return pack_u32(len(data)) + data


class Reader:
    """Reads the contents of a message. `function` makes a function of its number, `foreign` of another script's id."""

    def __init__(self, data, function=None, foreign=None, at=0):
        self.data, self.at = data, at
        self.function, self.foreign = function, foreign

    def byte(self):
        self.at += 1
        return self.data[self.at - 1]

    def u32(self):
        self.at += 4
        return unpack_u32(self.data, self.at - 4)[0]

    def u64(self):
        self.at += 8
        return unpack_u64(self.data, self.at - 8)[0]

    def i32(self):
        self.at += 4
        return int.from_bytes(self.data[self.at - 4:self.at], "little", signed=True)

    def bytes(self):
        n = self.u32()
        self.at += n
        return self.data[self.at - n:self.at]

    def text(self):
        return self.bytes().decode("utf-8", "replace")

    def values(self):
        return [self.value() for _ in range(self.u32())]

    def value(self):
        tag = self.data[self.at]
        self.at += 1
        if tag == FLOAT:
            self.at += 8
            return unpack_float(self.data, self.at - 8)[0]
        if tag == INT:
            self.at += 8
            return unpack_int(self.data, self.at - 8)[0]
        if tag <= 2:
            return (None, False, True)[tag]
        if tag == TEXT:
            data = self.bytes()
            try:
                return data.decode()
            except UnicodeDecodeError:
                return bytes(data)
        if tag == BYTES:
            return bytes(self.bytes())
        if tag == FLOATS or tag == INTS:
            n = self.u32()
            self.at += 8 * n
            return list(struct.unpack_from("<%d%s" % (n, "dq"[tag - FLOATS]), self.data, self.at - 8 * n))
        if tag == LIST:
            return [self.value() for _ in range(self.u32())]
        if tag == MAP:
            pairs = [(self.value(), self.value()) for _ in range(self.u32())]
            return {freeze(key): value for key, value in pairs}
        if tag == OWN_FUNCTION:
            return self.function(self.u32())
        if tag == FUNCTION:
            return self.foreign(self.u64())
        raise ValueError("unknown tag %d" % tag)


def freeze(key):
    return tuple(key) if isinstance(key, list) else key
