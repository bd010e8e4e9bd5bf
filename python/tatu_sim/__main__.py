"""The command line: `python -m tatu_sim run scene.toml`, or `tatu run scene.toml`."""

import signal
import sys

from . import _native


def main() -> int:
    if sys.argv[1:2] == ["doctor"]:
        from ._doctor import doctor

        return doctor(sys.argv[2:])
    # Python's own handler would only run after the end of the command line. Until that has installed its own, Ctrl-C ends
    # the process.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.main(["tatu", *sys.argv[1:]], [sys.executable, "-m", "tatu_sim"])


if __name__ == "__main__":
    sys.exit(main())
