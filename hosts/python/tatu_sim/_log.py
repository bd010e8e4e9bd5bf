"""Prints and logs the output of worlds."""

import logging
import sys

logger = logging.getLogger("tatu_sim")

_LEVELS = {"error": logging.ERROR, "warning": logging.WARNING, "debug": logging.DEBUG}


def write_line(level, code, text, prefix=""):
    """Write a line: output of scripts to `sys.stdout`, warnings and errors to the logger `tatu_sim`."""
    if level == "print":
        # `sys.stdout` is looked up each time, because notebooks and tests replace it.
        print(prefix + text, file=sys.stdout)
    else:
        logger.log(_LEVELS[level], "%s%s%s", prefix, f"[{code}] " if code else "", text)
