"""Formats changes to a scene for the command line's `--set`, and checks seeds and other integers."""

import json
import operator
from typing import Any, List, Mapping, Optional


def toml(value: Any) -> str:
    """Format a value as TOML."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{json.dumps(str(k))} = {toml(v)}" for k, v in value.items()) + "}"
    if hasattr(value, "tolist"):
        return toml(value.tolist())
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml(v) for v in value) + "]"
    if isinstance(value, int):
        return str(int(value))
    if isinstance(value, float):
        # `repr` preserves the exact value; infinities and NaN have the same spelling in TOML.
        return repr(float(value))
    raise TypeError(f"a {type(value).__name__} cannot be written as TOML; expected a number, str, bool, list or dict")


def whole(name: str, value: Any, least: int = 0) -> int:
    """Convert a value to an integer that fits into the native part's unsigned 64-bit type."""
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"`{name}` is {value!r}; expected an integer") from None
    if not least <= number < 2**64:
        raise ValueError(f"`{name}` is {number}; expected an integer from {least} to 2**64 - 1")
    return number


def settings(changes: Optional[Mapping[str, Any]]) -> List[str]:
    """Convert a dict of changes, such as `{"/Robot.mass_kg": 2.0}`, to strings `KEY=VALUE`, as for `--set`."""
    return [f"{key}={toml(value)}" for key, value in (changes or {}).items()]
