"""Messages between this process and the simulator: a length of 4 bytes, a kind of 1 byte, and the contents.

One side asks, and serves the questions of the other side until its own is answered. `src/message.rs` is the other side.
"""

import os
import struct
import threading

from tatu_runtime import wire

# Messages from the simulator.
LOAD, FIND, CALL, CALL_FUNCTION, RESUME, SAVE, RESTORE, PLACE, KEEP, DROP, REFRESH = range(1, 12)
RESULT, ERROR, WAIT = 20, 21, 22
# Messages to the simulator.
COMMAND, FUNCTION, LOOKUP, MODULE, NEAREST, DESCRIBE = range(1, 7)
LOG, DONE, FAILED, WAITING = 10, 20, 21, 22

MAX_BYTES = 256 << 20
CHUNK = 1 << 16

pack_frame = struct.Struct("<IB").pack
unpack_length = struct.Struct("<I").unpack_from


class SimError(Exception):
    """An error of a command. `code` is one of TATU_ERR_*, `help` says what to do instead."""

    def __init__(self, text, code=-1, help=""):
        super().__init__(text)
        self.code, self.help = code, help


class Link:
    """The pipes to and from the simulator. Only the thread `owner` may use them."""

    def __init__(self, fd, out):
        self.fd, self.out = fd, out
        self.received = b""
        self.owner = threading.get_ident()
        # Set by `main`: serves a question, waits for the end of a wait, takes the lines to log.
        self.serve = self.wait = self.lines = None
        # Lines to log, if any.
        self.pending = ()

    def send(self, kind, *parts):
        body = b"".join(parts)
        if len(body) >= MAX_BYTES:
            raise wire.Unsendable("the values have %d MB, more than can be passed at once" % (len(body) >> 20))
        data = pack_frame(len(body) + 1, kind) + body
        if self.pending:
            lines = self.lines()
            data = b"".join([pack_frame(len(line) + 1, LOG) + line for line in lines] + [data])
        write = os.write
        sent = write(self.out, data)
        if sent < len(data):
            rest = memoryview(data)
            while sent < len(data):
                sent += write(self.out, rest[sent:])

    def receive(self):
        """Returns kind and contents of the next message. Raises `EOFError` when the simulator has closed the pipe."""
        data = self.received
        while len(data) < 4:
            part = os.read(self.fd, CHUNK)
            if not part:
                raise EOFError
            data += part
        end = 4 + unpack_length(data)[0]
        if len(data) < end:
            parts, n = [data], len(data)
            while n < end:
                part = os.read(self.fd, max(CHUNK, min(end - n, 1 << 20)))
                if not part:
                    raise EOFError
                parts.append(part)
                n += len(part)
            data = b"".join(parts)
        self.received = data[end:]
        return data[4], data[5:end]

    def ask(self, kind, *parts):
        """Sends a question, serves the simulator's questions, and returns the contents of the answer."""
        if threading.get_ident() != self.owner:
            raise RuntimeError("commands can be called only by the script's own functions while the simulator calls "
                               "them, not by other threads of Python")
        self.send(kind, *parts)
        answer, body = self.answer()
        if answer == RESULT:
            return body
        if answer == WAIT:
            return self.wait(wire.unpack_u64(body)[0])
        raise error(wire.Reader(body))

    def answer(self):
        """Serves the simulator's questions until it answers."""
        try:
            while True:
                answer, body = self.receive()
                if RESULT <= answer <= WAIT:
                    return answer, body
                self.serve(answer, body)
        except EOFError:
            os._exit(0)
        except BaseException as problem:
            # The answer would be taken for that to a later question.
            os.write(2, ("%s within a command\n" % type(problem).__name__).encode())
            os._exit(70)


def error(reader):
    """Reads an error of a command."""
    code, text, help = reader.i32(), reader.text(), reader.text()
    return SimError(text, code, help)
