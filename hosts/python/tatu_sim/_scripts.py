"""Scripts that are objects of this program; the other part is native."""

import json
import traceback
from typing import Any, List, Tuple

from . import _native


class Commands:
    """Commands for scripts: `script.sim.getObject("/a")`, `script.tatu.read(...)`."""

    def __init__(self, name: str):
        self._name = name

    def __getattr__(self, name: str) -> "Commands":
        if name.startswith("__"):
            raise AttributeError(name)
        found = self.__dict__[name] = Commands(f"{self._name}.{name}" if self._name else name)
        return found

    def __call__(self, *args: Any) -> Any:
        results = _native.script_call(self._name, list(args))
        return None if not results else results[0] if len(results) == 1 else results

    def __repr__(self) -> str:
        return f"<commands `{self._name}`>"


#: What callbacks receive.
script = Commands("")


def describe(error: BaseException, trace: Any) -> Tuple[str, str, int, str]:
    """Return message, file, line and traceback, innermost first, of an exception."""
    text = str(error) if isinstance(error, _native.Error) else f"{type(error).__name__}: {error}"
    frames = [f for f in traceback.extract_tb(trace) if f.filename != __file__][::-1]
    if not frames:
        return text, "", 0, ""
    lines = [f"{f.filename}:{f.lineno}: in {f.name}\n    {f.line}" for f in frames[:40]]
    return text, frames[0].filename, frames[0].lineno or 0, "\n".join(lines)


def save(target: Any, found: List[str]) -> bytes:
    """Return what a snapshot stores: the names of callables that the simulator has found, and the object's own state."""
    state = target.sysCall_savestate(script) if hasattr(target, "sysCall_savestate") else None
    return json.dumps({"found": found, "state": state}).encode()


def restore(target: Any, saved: bytes) -> List[str]:
    """Pass saved state to the object, and return the names of callables."""
    both = json.loads(saved)
    if hasattr(target, "sysCall_loadstate"):
        target.sysCall_loadstate(script, both["state"])
    return both["found"]
