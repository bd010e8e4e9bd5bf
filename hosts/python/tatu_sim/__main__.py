"""The command line: `python -m tatu_sim run scene.toml`, or `tatu run scene.toml`."""

import os
import signal
import sys

from . import _native


def main() -> int:
    if sys.argv[1:2] == ["doctor"]:
        from ._doctor import doctor

        return doctor(sys.argv[2:])
    # Scripts in Python find the packages of this interpreter, unless the user has chosen another one.
    if sys.executable:
        os.environ.setdefault("TATU_PYTHON", sys.executable)
    # Python's handler would run only after the command line has returned. Until the command line installs its own
    # handler, Ctrl-C ends the process.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.main(["tatu", *sys.argv[1:]], [sys.executable, "-m", "tatu_sim"])


if __name__ == "__main__":
    sys.exit(main())
