"""The description of an environment: the table `[env]` of a scene, or a dict with the same keys.

`describe` checks such a table and returns a `Description`. Errors start with the location: `[env] observe[2]: unknown`.
"""

import difflib
import math
from numbers import Integral, Real
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from ._settings import toml

#: Functions that reduce several numbers to one.
REDUCTIONS = ("first", "min", "max", "sum", "mean", "norm")

_SOURCE = ("object", "field", "index", "reduce", "nan", "zero")
_OBSERVE = (*_SOURCE, "low", "high", "offset", "scale")
_ACT = ("object", "field", "low", "high")
_TEST = ("above", "below")
_TERM = (*_SOURCE, "action", "constant", "weight", *_TEST)
_KEYS = ("steps", "settle", "seconds", "observe", "act", "reward", "end", "watch", "random")
_DRAWS = ("uniform", "log_uniform", "normal", "integers", "choice")


class Source(NamedTuple):
    """A property or field of one or several objects."""

    place: str
    objects: Tuple[str, ...]
    field: str
    index: Optional[Tuple[int, ...]]
    reduce: Optional[str]
    #: Replacement for NaN, which fills the rest of a reading that has become shorter.
    nan: float
    #: Replacement for 0, by which many sensors report that they detect nothing.
    zero: Optional[float]


class Observed(NamedTuple):
    """A part of an observation, clipped to `low` and `high`, then transformed to `(x + offset) * scale`."""

    source: Source
    low: float
    high: float
    offset: float
    scale: float


class Acted(NamedTuple):
    """A property that actions set, clipped to `low` and `high`."""

    place: str
    objects: Tuple[str, ...]
    field: str
    low: float
    high: float


class Term(NamedTuple):
    """A term of the reward, or a condition that ends an episode."""

    place: str
    #: None if the term is a constant or depends on the action.
    source: Optional[Source]
    action: Optional[str]
    index: Optional[Tuple[int, ...]]
    constant: float
    weight: float
    above: Optional[float]
    below: Optional[float]


class Draw(NamedTuple):
    """A change to the scene that is drawn at random at each reset."""

    place: str
    key: str
    kind: str
    #: The bounds, the mean and standard deviation, or the values to choose from.
    values: Sequence[Any]
    low: Optional[float]
    high: Optional[float]

    def draw(self, random: np.random.Generator) -> Any:
        """Draw a value: a number, an array, or one of the choices."""
        if self.kind == "choice":
            return self.values[int(random.integers(len(self.values)))]
        if self.kind == "integers":
            return int(random.integers(self.values[0], self.values[1], endpoint=True))
        first, second = self.values
        if self.kind == "normal":
            x = random.normal(first, second)
            if self.low is not None or self.high is not None:
                x = np.clip(x, self.low, self.high)
        elif self.kind == "log_uniform":
            # `math` is used because the last bit of NumPy's functions depends on the processor.
            log, exp = (np.vectorize(f, otypes=[float]) for f in (math.log, math.exp))
            x = exp(random.uniform(log(first), log(second)))
        else:
            x = random.uniform(first, second)
        return x if np.ndim(x) else float(x)


class Description(NamedTuple):
    """The checked description of an environment."""

    steps: int
    settle: int
    seconds: Optional[float]
    observe: List[Observed]
    act: List[Acted]
    reward: List[Term]
    end: List[Term]
    watch: Dict[str, Source]
    random: List[Draw]

    def limit(self, dt: float) -> Optional[int]:
        """Return the number of environment steps after which an episode is truncated, or None."""
        return None if self.seconds is None else max(1, round(self.seconds / (dt * self.steps)))


def describe(table: Mapping[str, Any]) -> Description:
    """Check a table `[env]`, and return its description.

    Raises:
        ValueError: The table is invalid. The message states the location, and what was expected.
    """
    place = "[env]"
    _known(place, table, _KEYS)
    seconds = None
    if table.get("seconds") is not None:
        seconds = _number(place, "seconds", table["seconds"])
        if seconds <= 0:
            raise ValueError(f"{place} seconds: {seconds:g} is not a duration; expected a number above 0, or no key")
    watch, where = table.get("watch") or {}, "[env.watch]"
    _mapping(where, watch, "names with their sources: `pose = { object = ..., field = ... }`")
    random, there = table.get("random") or {}, "[env.random]"
    _mapping(there, random, 'changes with distributions: `"/Robot.mass_kg" = { uniform = [8.0, 10.0] }`')
    description = Description(
        steps=_count(place, "steps", table.get("steps", 1), 1),
        settle=_count(place, "settle", table.get("settle", 1), 0),
        seconds=seconds,
        observe=[_observed(p, t) for p, t in _list(table, "observe")],
        act=[_acted(p, t) for p, t in _list(table, "act")],
        reward=[_term(p, t) for p, t in _list(table, "reward")],
        end=[_condition(p, t) for p, t in _list(table, "end")],
        watch={str(name): _watched(f"{where} {name}", t) for name, t in watch.items()},
        random=[_draw(f'{there} "{key}"', str(key), t) for key, t in random.items()],
    )
    for key in ("observe", "act"):
        if not getattr(description, key):
            expected = "expected a list of tables with `object` and `field`"
            raise ValueError(f"{place}: `{key}` is missing or empty; {expected}")
    return description


# ------------------------------------------------------------------------------------------------------------- entries


def _observed(place: str, table: Mapping[str, Any]) -> Observed:
    _known(place, table, _OBSERVE)
    low, high = _range(place, table, -math.inf, math.inf)
    scale = _number(place, "scale", table.get("scale", 1.0))
    if scale == 0:
        raise ValueError(f"{place} scale: a factor of 0 makes every value 0; use another factor, or omit the entry")
    return Observed(_source(place, table), low, high, _number(place, "offset", table.get("offset", 0.0)), scale)


def _acted(place: str, table: Mapping[str, Any]) -> Acted:
    _known(place, table, _ACT)
    for key in ("low", "high"):
        if key not in table:
            expected = "expected the bounds of the action, in the unit of the property"
            raise ValueError(f"{place}: `{key}` is missing; {expected}")
    low, high = _range(place, table, -math.inf, math.inf)
    if not (math.isfinite(low) and math.isfinite(high)):
        raise ValueError(f"{place}: the action is between {low:g} and {high:g}; expected finite bounds")
    return Acted(place, _objects(place, table), _text(place, table, "field"), low, high)


def _watched(place: str, table: Mapping[str, Any]) -> Source:
    _known(place, table, _SOURCE)
    return _source(place, table)


def _term(place: str, table: Mapping[str, Any]) -> Term:
    _known(place, table, _TERM)
    kinds = [key for key in ("object", "action", "constant") if key in table]
    if len(kinds) != 1:
        found = " and ".join(f"`{k}`" for k in kinds) or "none of these"
        raise ValueError(f"{place}: expected one of `object` (with `field`), `action` and `constant`, found {found}")
    above, below = (None if table.get(k) is None else _number(place, k, table[k]) for k in _TEST)
    weight = _number(place, "weight", table.get("weight", 1.0))
    source = action = index = None
    constant = 0.0
    if kinds == ["object"]:
        source = _source(place, table)
    else:
        allowed = {"action": ("action", "index", "weight", *_TEST), "constant": ("constant", "weight")}[kinds[0]]
        for key in table:
            if key not in allowed:
                raise ValueError(f"{place}: `{key}` does not belong to `{kinds[0]}`; expected {_or(allowed)}")
        if kinds == ["constant"]:
            constant = _number(place, "constant", table["constant"])
        else:
            action, index = _choice(place, "action", table["action"], REDUCTIONS), _index(place, table)
    return Term(place, source, action, index, constant, weight, above, below)


def _condition(place: str, table: Mapping[str, Any]) -> Term:
    _known(place, table, (*_SOURCE, *_TEST))
    if all(table.get(k) is None for k in _TEST):
        raise ValueError(f"{place}: expected `above` or `below`, the bound at which the episode ends")
    return _term(place, table)


def _source(place: str, table: Mapping[str, Any]) -> Source:
    reduce = table.get("reduce")
    zero = table.get("zero")
    return Source(
        place,
        _objects(place, table),
        _text(place, table, "field"),
        _index(place, table),
        None if reduce is None else _choice(place, "reduce", reduce, REDUCTIONS),
        _number(place, "nan", table.get("nan", 0.0)),
        None if zero is None else _number(place, "zero", zero),
    )


def _draw(place: str, key: str, table: Any) -> Draw:
    _mapping(place, table, "a distribution, such as `{ uniform = [8.0, 10.0] }`")
    _known(place, table, (*_DRAWS, "low", "high"))
    kinds = [k for k in _DRAWS if k in table]
    if len(kinds) != 1:
        found = " and ".join(f"`{k}`" for k in kinds) or "none"
        raise ValueError(f"{place}: expected one distribution ({_or(_DRAWS)}), found {found}")
    kind = kinds[0]
    values = table[kind]
    low, high = (None if table.get(k) is None else _number(place, k, table[k]) for k in ("low", "high"))
    if kind != "normal" and not low is high is None:
        raise ValueError(f"{place}: `low` and `high` are only allowed with `normal`, whose values they clip")
    if isinstance(values, np.ndarray):
        values = values.tolist()
    if not isinstance(values, (list, tuple)) or (len(values) < 1 if kind == "choice" else len(values) != 2):
        wanted = {
            "choice": "a list with the values to choose from",
            "normal": "[mean, deviation]",
            "integers": "[lowest, highest]",
        }.get(kind, "[low, high], both numbers or both lists of the same length")
        raise ValueError(f"{place} {kind}: {values!r} is invalid; expected {wanted}")
    if kind == "choice":
        for value in values:
            toml(value)
        return Draw(place, key, kind, list(values), None, None)
    if kind == "integers":
        first, second = (_count(place, kind, v, None) for v in values)
        if first > second:
            raise ValueError(f"{place} {kind}: {first} is above {second}; expected [lowest, highest]")
        return Draw(place, key, kind, [first, second], None, None)
    first, second = (_vector(place, kind, v) for v in values)
    if np.shape(first) != np.shape(second):
        sizes = f"{np.size(first)} and {np.size(second)} elements"
        raise ValueError(f"{place} {kind}: both values must have the same size, but have {sizes}")
    if kind == "normal" and np.any(np.asarray(second) < 0):
        raise ValueError(f"{place} normal: the deviation {second!r} is negative; expected [mean, deviation]")
    if kind != "normal" and np.any(np.asarray(first) > np.asarray(second)):
        raise ValueError(f"{place} {kind}: {values[0]!r} is above {values[1]!r}; expected [low, high]")
    if kind == "log_uniform" and np.any(np.asarray(first) <= 0):
        raise ValueError(f"{place} log_uniform: {values[0]!r} has no logarithm; expected bounds above 0")
    if low is not None and high is not None and low > high:
        raise ValueError(f"{place}: `low` {low:g} is above `high` {high:g}")
    return Draw(place, key, kind, [first, second], low, high)


# ---------------------------------------------------------------------------------------------------------------- keys


def _mapping(place: str, table: Any, expected: str) -> None:
    if not isinstance(table, Mapping):
        raise ValueError(f"{place}: expected {expected}, found {table!r}")


def _known(place: str, table: Any, keys: Sequence[str]) -> None:
    _mapping(place, table, f"a table with the keys {_or(keys)}")
    for key in table:
        if key not in keys:
            near = difflib.get_close_matches(str(key), keys, 1)
            hint = f"; did you mean `{near[0]}`?" if near else ""
            raise ValueError(f"{place}: unknown key `{key}`; expected {_or(keys)}{hint}")


def _list(table: Mapping[str, Any], key: str) -> List[Tuple[str, Any]]:
    """Return the entries of a list of tables, with their locations."""
    entries = table.get(key)
    if entries is None:
        return []
    if isinstance(entries, Mapping) or not isinstance(entries, (list, tuple)):
        raise ValueError(f"[env] {key}: expected a list of tables, `{key} = [{{ ... }}, {{ ... }}]`, found {entries!r}")
    return [(f"[env] {key}[{n}]", entry) for n, entry in enumerate(entries)]


def _text(place: str, table: Mapping[str, Any], key: str) -> str:
    if key not in table:
        raise ValueError(f"{place}: `{key}` is missing; expected the name of a property or of a field of readings")
    if not isinstance(table[key], str):
        raise ValueError(f"{place} {key}: expected a string, found {table[key]!r}")
    return table[key]


def _objects(place: str, table: Mapping[str, Any]) -> Tuple[str, ...]:
    given = table.get("object")
    objects = (given,) if isinstance(given, str) else tuple(given) if isinstance(given, (list, tuple)) else ()
    if not objects or not all(isinstance(o, str) for o in objects):
        raise ValueError(f"{place}: `object` must be the path of an object, or a list of paths; found {given!r}")
    return objects


def _number(place: str, key: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, Real) or math.isnan(value):
        raise ValueError(f"{place} {key}: expected a number, found {value!r}")
    return float(value)


def _vector(place: str, key: str, value: Any) -> Union[float, np.ndarray]:
    if isinstance(value, (list, tuple)) and value:
        return np.array([_vector(place, key, v) for v in value])
    number = _number(place, key, value)
    if not math.isfinite(number):
        raise ValueError(f"{place} {key}: expected a finite number, found {value!r}")
    return number


def _count(place: str, key: str, value: Any, least: Optional[int]) -> int:
    if isinstance(value, bool) or not isinstance(value, Integral) or (least is not None and value < least):
        limit = "" if least is None else f", at least {least}"
        raise ValueError(f"{place} {key}: expected an integer{limit}, found {value!r}")
    return int(value)


def _range(place: str, table: Mapping[str, Any], low: float, high: float) -> Tuple[float, float]:
    low, high = _number(place, "low", table.get("low", low)), _number(place, "high", table.get("high", high))
    if low >= high:
        raise ValueError(f"{place}: `low` {low:g} is not below `high` {high:g}")
    return low, high


def _choice(place: str, key: str, value: Any, choices: Sequence[str]) -> str:
    if value not in choices:
        raise ValueError(f"{place} {key}: expected {_or(choices)}, found {value!r}")
    return value


def _index(place: str, table: Mapping[str, Any]) -> Optional[Tuple[int, ...]]:
    given = table.get("index")
    if given is None:
        return None
    if not isinstance(given, (list, tuple)):
        given = [given]
    if not given:
        raise ValueError(f"{place} index: the list is empty; expected indices, or no key to select all elements")
    return tuple(_count(place, "index", i, 0) for i in given)


def _or(words: Sequence[str]) -> str:
    return ", ".join(f"`{w}`" for w in words[:-1]) + f" or `{words[-1]}`" if len(words) > 1 else f"`{words[0]}`"
