"""The standard output and error of the script, whose lines become lines of the log."""

import collections
import io
import threading

INFO, WARNING = b"\3", b"\2"
# More lines than the simulator stores in one step.
MAX_LINES = 10_001
MAX_BYTES = 1 << 20


class Output:
    """Lines to log, which any thread may add."""

    def __init__(self, link):
        self.link = link
        self.pending = collections.deque()
        self.begin()

    def begin(self):
        """A new call of the simulator."""
        self.left, self.bytes_left = MAX_LINES, MAX_BYTES

    def add(self, level, line):
        data = line.encode("utf-8", "replace")
        if self.left <= 0 or self.bytes_left <= 0:
            return
        if len(data) > self.bytes_left:
            data = data[:self.bytes_left] + b" ..."
        self.left -= 1
        self.bytes_left -= len(data)
        self.pending.append(level + data)

    def take(self):
        """Returns the lines to send."""
        lines = []
        while self.pending:
            lines.append(self.pending.popleft())
        return lines


class Stream(io.TextIOBase):
    """`sys.stdout` or `sys.stderr`."""

    encoding = "utf-8"
    errors = "replace"

    def __init__(self, output, level):
        super().__init__()
        self.output, self.level = output, level
        self.partial = ""
        self.lock = threading.RLock()

    def writable(self):
        return True

    def isatty(self):
        return False

    def write(self, text):
        if not isinstance(text, str):
            raise TypeError("write() argument must be str, not %s" % type(text).__name__)
        with self.lock:
            lines = (self.partial + text).split("\n")
            self.partial = lines.pop()
            if len(self.partial) > MAX_BYTES:
                lines.append(self.partial)
                self.partial = ""
            for line in lines:
                self.output.add(self.level, line.rstrip("\r"))
        return len(text)

    def flush(self):
        pass

    def end(self):
        """Logs a line that has not been completed."""
        with self.lock:
            if self.partial:
                line, self.partial = self.partial, ""
                self.output.add(self.level, line)
