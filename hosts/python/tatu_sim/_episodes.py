"""Episodes of an environment in many worlds at once; `tatu_sim.gym` builds Gymnasium environments on top of it.

All worlds are computed together, by operations in which each row is independent of the others: the results for a world
are bit-identical to those of the same world alone.
"""

import re
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from ._batch import Batch, rows
from ._env import Description, Observed, Source, Term, describe
from ._native import Error
from ._world import PathLike

#: A function of observations, actions (clipped, `float64`) and watched values of all worlds; returns a value per world.
Function = Callable[[np.ndarray, np.ndarray, Dict[str, np.ndarray]], np.ndarray]


class Began(NamedTuple):
    """The initial conditions of a world's episode."""

    seed: int
    #: All changes to the scene, both fixed and random ones.
    changes: Dict[str, Any]


class Episodes:
    """`n` worlds with an environment.

    Args:
        n: Number of worlds.
        scene, text, folder, scripts, allow, languages, plugins, files, quiet: As for `Batch`.
        env: Keys that replace those of the scene's table `[env]`; the value None removes a key.
        set: Changes to the scene, the same for all worlds.
        threads: Number of threads.
        reward, end: Functions whose results are combined with the terms and conditions of the table.
        dtype: Type of observations and actions.
    """

    def __init__(
        self,
        n: int,
        scene: Optional[PathLike] = None,
        *,
        text: Optional[str] = None,
        folder: PathLike = ".",
        env: Optional[Mapping[str, Any]] = None,
        set: Optional[Mapping[str, Any]] = None,
        scripts: Optional[Mapping[str, PathLike]] = None,
        allow: Sequence[str] = (),
        languages: Optional[Mapping[str, Mapping[str, Any]]] = None,
        plugins: Sequence[PathLike] = (),
        files: Optional[PathLike] = None,
        threads: Optional[int] = None,
        quiet: bool = False,
        reward: Optional[Function] = None,
        end: Optional[Function] = None,
        dtype: Any = np.float32,
    ):
        self.n = n
        self.dtype = np.dtype(dtype)
        self._reward, self._end = reward, end
        self._set = dict(set or {})
        self._began: List[Optional[Began]] = [None] * n
        # Here, a list is a single value for all worlds.
        for_each = {key: [value] * n for key, value in self._set.items()}
        self.batch = Batch(
            scene,
            n,
            text=text,
            folder=folder,
            set=for_each,
            scripts=scripts,
            allow=allow,
            languages=languages,
            plugins=plugins,
            files=files,
            threads=threads,
            quiet=quiet,
        )
        #: Number of steps of the current episode in each world.
        self.elapsed = np.zeros(n, dtype=np.int64)
        try:
            self.description = self._described(env)
            self._bind(self.description)
            if self.description.random:
                # Random changes are tried once, so that invalid ones are reported now and not in the first reset.
                with _Place("[env.random]"):
                    self.begin([0], [np.random.default_rng(0)])
        except BaseException:
            self.batch.close()
            raise
        #: Length of a step of the environment, s.
        self.dt = self.batch.dt * self.description.steps
        self._limit = self.description.limit(self.batch.dt)

    # ------------------------------------------------------------------------------------------------- the description

    def _described(self, env: Optional[Mapping[str, Any]]) -> Description:
        table = self.batch.env
        if table is None and env is None:
            raise ValueError("the scene has no table [env], which describes the environment; add one, or pass `env=`")
        if env is not None and not isinstance(env, Mapping):
            raise ValueError(f"`env` is a {type(env).__name__}; expected a dict with the keys of the table [env]")
        both = {**(table or {}), **(env or {})}
        return describe({key: value for key, value in both.items() if value is not None})

    def _bind(self, d: Description) -> None:
        """Look up all sources and actions in the worlds."""
        terms = [*d.reward, *d.end]
        sources = [o.source for o in d.observe] + [t.source for t in terms if t.source] + list(d.watch.values())
        names = dict.fromkeys((path, s.field) for s in sources for path in s.objects)
        acted = [((path, a.field), a) for a in d.act for path in a.objects]
        # Each source is looked up separately, so that errors can state its location.
        for s in sources:
            with _Place(s.place):
                self.batch.bind([(path, s.field) for path in s.objects])
        for name, a in acted:
            with _Place(a.place):
                self.batch.bind([name], [name])
                # Set the current value, to check that the property can be set.
                self.batch.step(self.batch.observations, 0)
        self.batch.bind(list(names), [name for name, _ in acted])
        seen, set_ = self.batch.shapes
        sizes = [int(np.prod(shape, dtype=int)) for shape in seen]
        starts = np.concatenate([[0], np.cumsum(sizes)]).astype(int)
        at = {name: np.arange(starts[i], starts[i + 1]) for i, name in enumerate(names)}
        self._observe = Observer([(o, Numbers(o.source, at)) for o in d.observe], self.dtype)
        sizes = [int(np.prod(shape, dtype=int)) for shape in set_]
        # Values beyond the range of a property would be refused.
        ranges = self.batch.bounds
        least = [a.low if low is None else max(a.low, low) for (_, a), (low, _) in zip(acted, ranges)]
        greatest = [a.high if high is None else min(a.high, high) for (_, a), (_, high) in zip(acted, ranges)]
        for (_, a), low, high in zip(acted, least, greatest):
            if not low < high:
                raise ValueError(f"{a.place}: no value from {a.low:g} to {a.high:g} is in the range of `{a.field}`")
        #: Bounds of the elements of an action.
        self.act_low = np.repeat(least, sizes)
        self.act_high = np.repeat(greatest, sizes)
        self._terms = [Value(t, at, len(self.act_low)) for t in d.reward]
        self._conditions = [Value(t, at, len(self.act_low)) for t in d.end]
        self._watch = {name: Numbers(s, at) for name, s in d.watch.items()}

    @property
    def observe_bounds(self) -> Tuple[np.ndarray, np.ndarray]:
        """Return the bounds of the observations."""
        return self._observe.least, self._observe.greatest

    # ----------------------------------------------------------------------------------------------------- the episodes

    def begin(
        self, worlds: Sequence[int], randoms: Sequence[np.random.Generator], extra: Optional[Mapping[str, Any]] = None
    ) -> List[Dict[str, Any]]:
        """Start an episode in each of these worlds, and return the infos. `randoms` has a generator for each of them.

        A generator draws the seed of the world first, and then the changes of `[env.random]` in their order.
        """
        for world, random in zip(worlds, randoms):
            seed = int(random.integers(1 << 53))
            changes = {d.key: d.draw(random) for d in self.description.random}
            self._began[world] = Began(seed, {**self._set, **changes, **(extra or {})})
        began = [self._began[world] for world in worlds]
        self.batch.reset(list(worlds), seeds=[b.seed for b in began], sets=[b.changes for b in began])
        if self.description.settle:
            mask = np.zeros(self.n, dtype=bool)
            mask[list(worlds)] = True
            self.batch.step(None, self.description.settle, worlds=mask)
        self.elapsed[list(worlds)] = 0
        keys = [d.key for d in self.description.random]
        return [{"seed": b.seed, **({"random": {k: b.changes[k] for k in keys}} if keys else {})} for b in began]

    def observe(self) -> np.ndarray:
        """Return the observations of all worlds."""
        return self._observe(self.batch._out, gaps=True)

    def advance(
        self, actions: np.ndarray, worlds: Optional[np.ndarray] = None
    ) -> Tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Run one environment step in the worlds that a mask selects, by default in all.

        Returns:
            Observations, rewards, and whether the episode was terminated or truncated, for all worlds. For worlds that
            were not stepped, the reward is 0, and both flags are False.
        """
        given = rows(actions, self.n, len(self.act_low))
        clipped = np.minimum(np.maximum(given, self.act_low), self.act_high)
        if not np.isfinite(clipped).all():
            raise ValueError("an action contains NaN; the policy may have diverged")
        numbers = self.batch.step(clipped, self.description.steps, worlds=worlds)
        gaps = bool(np.isnan(numbers).any())
        observations = self._observe(numbers, gaps)
        rewards = np.zeros(self.n)
        for value in self._terms:
            rewards += value.reward(numbers, clipped, gaps)
        # A script that stops its world ends the episode.
        ended = ~self.batch.running
        for value in self._conditions:
            ended |= value.holds(numbers, clipped, gaps)
        if self._reward is not None or self._end is not None:
            watched = {name: pick(numbers, gaps) for name, pick in self._watch.items()}
            if self._reward is not None:
                rewards += self._checked("reward", self._reward(observations, clipped, watched))
            if self._end is not None:
                ended |= self._checked("end", self._end(observations, clipped, watched)).astype(bool)
        if worlds is None:
            self.elapsed += 1
        else:
            self.elapsed += worlds
            rewards[~worlds] = 0.0
            ended &= worlds
        if self._limit is None:
            cut = np.zeros(self.n, dtype=bool)
        else:
            cut = self.elapsed >= self._limit
            if worlds is not None:
                cut &= worlds
        return observations, rewards, ended, cut

    def _checked(self, name: str, values: Any) -> np.ndarray:
        values = np.asarray(values)
        if values.shape != (self.n,):
            expected = f"expected one value for each world, ({self.n},)"
            raise ValueError(f"`{name}` returned an array of shape {values.shape}; {expected}")
        return values

    def picture(self, world: int, camera: Optional[str], size: Tuple[int, int]) -> np.ndarray:
        """Render a picture of a world."""
        return self.batch.render(world, camera, size=size)

    def close(self) -> None:
        """End all worlds."""
        self.batch.close()

    def __enter__(self) -> "Episodes":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()


class _Place:
    """Adds the location in the description to errors of the simulator."""

    def __init__(self, place: str):
        self.place = place

    def __enter__(self) -> None:
        pass

    def __exit__(self, _kind: Any, error: Any, _trace: Any) -> None:
        if isinstance(error, Error):
            # The error is the same in all worlds, so the index is removed.
            text = re.sub("^world 0: ", "", getattr(error, "text", None) or str(error))
            raise ValueError(f"{self.place}: {text}") from error


# ------------------------------------------------------------------------------------------------------------- numbers


class Numbers:
    """Selects the values of a source from the observations of a batch, with one row per world."""

    def __init__(self, source: Source, at: Mapping[Tuple[str, str], np.ndarray]):
        columns = []
        for path in source.objects:
            all_ = at[path, source.field]
            if source.index is None:
                columns.append(all_)
                continue
            if max(source.index) >= len(all_):
                have = f"has {len(all_)} values" if len(all_) != 1 else "is a single value"
                expected = f"expected indices from 0 to {len(all_) - 1}"
                raise ValueError(f"{source.place} index: `{source.field}` of `{path}` {have}; {expected}")
            columns.append(all_[list(source.index)])
        self.columns = np.concatenate(columns)
        self.reduce = source.reduce
        self.nan, self.zero = source.nan, source.zero
        self.size = len(self.columns) if source.reduce is None else 1
        if source.reduce is not None and not len(self.columns):
            raise ValueError(f"{source.place} reduce: `{source.field}` has no values")

    def __call__(self, numbers: np.ndarray, gaps: bool) -> np.ndarray:
        """Return the values of the source. `gaps` states whether the observations can contain NaN."""
        x = numbers.take(self.columns, axis=1)
        if gaps:
            x[np.isnan(x)] = self.nan
        if self.zero is not None:
            x[x == 0.0] = self.zero
        return x if self.reduce is None else reduced(x, self.reduce)[:, None]


def reduced(x: np.ndarray, how: str) -> np.ndarray:
    """Reduce each row to a number. Rows must be contiguous in memory, so that the order of summation does not depend
    on the number of rows."""
    if how == "first":
        return x[:, 0].copy()
    if how == "min":
        return np.minimum.reduce(x, axis=1)
    if how == "max":
        return np.maximum.reduce(x, axis=1)
    if how == "norm":
        x = x * x
    total = np.add.reduce(x, axis=1)
    return np.sqrt(total) if how == "norm" else total / x.shape[1] if how == "mean" else total


class Observer:
    """Converts the observations of a batch to those of the environment."""

    def __init__(self, parts: List[Tuple[Observed, Numbers]], dtype: np.dtype):
        self.dtype = dtype
        sizes = [pick.size for _, pick in parts]

        def each(values):
            return np.repeat(np.array(list(values), dtype=float), sizes)

        self.low, self.high = each(o.low for o, _ in parts), each(o.high for o, _ in parts)
        self.offset, self.scale = each(o.offset for o, _ in parts), each(o.scale for o, _ in parts)
        self.nan = each(pick.nan for _, pick in parts)
        zero = each(np.nan if pick.zero is None else pick.zero for _, pick in parts)
        self.zero = None if np.isnan(zero).all() else zero
        self.has_zero = ~np.isnan(zero)
        # If no part is reduced, all are selected in a single operation.
        plain = all(pick.reduce is None for _, pick in parts)
        self.columns = np.concatenate([pick.columns for _, pick in parts]) if plain else None
        self.picks = [pick for _, pick in parts]
        ends = self._scaled(self.low.copy()), self._scaled(self.high.copy())
        self.least, self.greatest = np.minimum(*ends).astype(dtype), np.maximum(*ends).astype(dtype)

    def _scaled(self, x: np.ndarray) -> np.ndarray:
        x += self.offset
        x *= self.scale
        return x

    def __call__(self, numbers: np.ndarray, gaps: bool) -> np.ndarray:
        if self.columns is None:
            x = np.concatenate([pick(numbers, gaps) for pick in self.picks], axis=1)
        else:
            x = numbers.take(self.columns, axis=1)
            if gaps:
                np.copyto(x, self.nan, where=np.isnan(x))
            if self.zero is not None:
                np.copyto(x, self.zero, where=(x == 0.0) & self.has_zero)
        np.maximum(x, self.low, out=x)
        np.minimum(x, self.high, out=x)
        return self._scaled(x).astype(self.dtype)


class Value:
    """Evaluates a term of the reward, or a condition of the end, in all worlds."""

    def __init__(self, term: Term, at: Mapping[Tuple[str, str], np.ndarray], actions: int):
        self.term = term
        self.pick = None if term.source is None else Numbers(term.source, at)
        self.columns = None
        if self.pick is not None and self.pick.size != 1:
            found = f"`{term.source.field}` has {self.pick.size} values, but a single one is required"
            raise ValueError(f"{term.place}: {found}; select one by `index`, or combine them by `reduce`")
        if term.action is not None:
            self.columns = np.arange(actions) if term.index is None else np.array(term.index)
            if max(self.columns) >= actions:
                expected = f"expected indices from 0 to {actions - 1}"
                raise ValueError(f"{term.place} index: the size of an action is {actions}; {expected}")

    def _value(self, numbers: np.ndarray, actions: np.ndarray, gaps: bool) -> np.ndarray:
        if self.pick is not None:
            return self.pick(numbers, gaps)[:, 0]
        return reduced(actions.take(self.columns, axis=1), self.term.action)

    def holds(self, numbers: np.ndarray, actions: np.ndarray, gaps: bool) -> np.ndarray:
        """Return whether the value is strictly within the bounds of the term, for each world."""
        return self._within(self._value(numbers, actions, gaps))

    def _within(self, x: np.ndarray) -> np.ndarray:
        above, below = self.term.above, self.term.below
        if above is None:
            return x < below
        return x > above if below is None else (x > above) & (x < below)

    def reward(self, numbers: np.ndarray, actions: np.ndarray, gaps: bool) -> Any:
        """Return the contribution of the term to the reward of each world: its value times its weight or, if the term
        has bounds, the weight where the value is within them, and 0 elsewhere."""
        term = self.term
        if self.pick is None and self.columns is None:
            return term.weight * term.constant
        x = self._value(numbers, actions, gaps)
        if term.above is not None or term.below is not None:
            return np.where(self._within(x), term.weight, 0.0)
        return term.weight * x
