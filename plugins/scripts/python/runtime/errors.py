"""Errors of the script, as the simulator reports them: message, position, traceback."""

import linecache
import os
import struct
import traceback

from tatu_runtime import link as links, wire

SCRIPT_ERROR, MEMORY_ERROR = -7, -13
MAX_TEXT = 4000
MAX_FRAMES = 40
# Folders with the modules of the interpreter.
LIBRARIES = (os.path.dirname(os.__file__) + os.sep, "<frozen ")


def failure(error):
    """Returns the parts of a message about an exception."""
    text = "%s: %s" % (type(error).__name__, message(error))
    code, help, frames = SCRIPT_ERROR, "", places(error.__traceback__)
    if isinstance(error, links.SimError):
        text, code, help = message(error), error.code, error.help
    elif isinstance(error, wire.Unsendable):
        text = str(error)
    elif isinstance(error, MemoryError):
        text, code = "the script has used up its memory", MEMORY_ERROR
        help = "allow it more with `--language python:memory_mb=4096`"
    elif isinstance(error, SyntaxError) and error.lineno and not frames:
        text = "%s: %s" % (type(error).__name__, error.msg)
        frames = [(error.filename or "", error.lineno, "", (error.text or "").strip())]
    elif isinstance(error, ModuleNotFoundError):
        help = "install it for the interpreter that runs scripts, or choose another one with `--language python:interpreter=PATH`"
    file, line = position(frames)
    lines = []
    for file_name, number, function, source in frames:
        lines.append("%s:%d: in %s" % (file_name, number, function or "the text"))
        if source:
            lines.append("    " + source)
    cause = error.__cause__ or (None if error.__suppress_context__ else error.__context__)
    if cause is not None and cause is not error:
        lines.append("caused by %s: %s" % (type(cause).__name__, message(cause)))
    return report(code, text, help, file, line, "\n".join(lines))


def position(frames):
    """Returns file and line of the innermost frame that does not belong to a library of the interpreter."""
    for file, line, _, _ in frames:
        if not file.startswith(LIBRARIES) and "site-packages" not in file:
            return file, line
    return (frames[0][0], frames[0][1]) if frames else ("", 0)


def report(code, text, help, file, line, trace):
    parts = [struct.pack("<i", code)]
    for one in (text[:MAX_TEXT], help, file):
        parts.append(wire.text(one.encode("utf-8", "replace")))
    parts.append(wire.pack_u32(line if 0 < line < 1 << 31 else 0))
    parts.append(wire.text(trace[:4 * MAX_TEXT].encode("utf-8", "replace")))
    return parts


def message(error):
    try:
        return str(error)
    except Exception:
        return "(its text cannot be shown)"


def places(trace):
    """Returns file, line, function and source of the frames outside of the runtime, innermost first."""
    frames = []
    for frame, line in traceback.walk_tb(trace):
        code = frame.f_code
        if not code.co_filename.startswith("<tatu>/") and code.co_filename != "<string>":
            function = "" if code.co_name == "<module>" else code.co_name
            frames.append((code.co_filename, line or 0, function, None))
            if len(frames) > 4 * MAX_FRAMES:
                del frames[:MAX_FRAMES]
    frames = frames[::-1][:MAX_FRAMES]
    return [(file, line, function, linecache.getline(file, line).strip()) for file, line, function, _ in frames]


def place(frame):
    """Returns the parts of a message with the position of running code."""
    while frame is not None:
        file = frame.f_code.co_filename
        if not file.startswith("<tatu>/") and file != "<string>":
            return report(SCRIPT_ERROR, "the script's position", "", file, frame.f_lineno or 0,
                          "%s:%d: in %s" % (file, frame.f_lineno or 0, frame.f_code.co_name))
        frame = frame.f_back
    return report(SCRIPT_ERROR, "no position", "", "", 0, "")
