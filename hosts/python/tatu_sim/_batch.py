"""Batches of worlds, stepped together on all cores."""

import os
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from . import _native
from ._log import write_line
from ._settings import settings, whole
from ._world import PathLike, setup, view

#: An observation or action: the path of an object, and the name of a property or of a field of readings.
Name = Tuple[str, str]


class Batch:
    """`n` worlds of one scene, stepped together by one call. Their results do not depend on the number of threads.

    Args:
        scene, text, folder, scripts, allow, languages, plugins, files: As for `World`.
        n: Number of worlds.
        seeds: One seed for each world; by default the scene's own seed plus the index of the world.
        set: Changes to the scene, as for `World`. A list or array of length `n` sets a separate value for each
            world, so a list that is the value for all worlds must be repeated `n` times.
        threads: Number of threads; by default the number of cores.
        observe: The observations that `step` returns, as pairs of path and name: `[("/Robot", "object.world_pose"),
            ("/Robot/laser", "range_scan.distance")]`.
        act: The properties that the actions of `step` set: `[("/Robot/leftMotor", "joint.target_velocity")]`.
        quiet: Do not print the output and log lines of scripts.
    """

    def __init__(
        self,
        scene: Optional[PathLike] = None,
        n: int = 1,
        *,
        text: Optional[str] = None,
        folder: PathLike = ".",
        seeds: Optional[Sequence[int]] = None,
        set: Optional[Mapping[str, Any]] = None,
        scripts: Optional[Mapping[str, PathLike]] = None,
        allow: Sequence[str] = (),
        languages: Optional[Mapping[str, Mapping[str, Any]]] = None,
        plugins: Sequence[PathLike] = (),
        files: Optional[PathLike] = None,
        threads: Optional[int] = None,
        observe: Sequence[Name] = (),
        act: Sequence[Name] = (),
        quiet: bool = False,
    ):
        if n < 1:
            raise ValueError(f"`n` is {n}; expected at least 1 world")
        if seeds is not None and len(seeds) != n:
            raise ValueError(f"{len(seeds)} seeds were given for {n} worlds; expected one for each world")
        if any(not isinstance(script, (str, os.PathLike)) for script in (scripts or {}).values()):
            raise TypeError("only `World` takes objects as scripts; expected paths of files")
        changes = spread(set, n)
        arguments = []
        for world in range(n):
            seed = None if seeds is None else seeds[world]
            arguments.append(
                setup(scene, text, folder, seed, changes[world], scripts, allow, (), languages, plugins, 1, files)
            )
        self.n = n
        self.quiet = quiet
        self._native = _native.Batch(arguments, cores() if threads is None else whole("threads", threads, 1))
        self._shapes: Tuple[List[List[int]], List[List[int]]] = ([], [])
        self.running = np.ones(n, dtype=bool)
        self.bind(observe, act)

    def bind(self, observe: Sequence[Name], act: Sequence[Name] = ()) -> None:
        """Set the observations that `step` returns, and the properties that its actions set."""
        pairs = [(str(path), str(name)) for path, name in observe], [(str(path), str(name)) for path, name in act]
        self._shapes = self._native.bind(*pairs)
        self.observe_size, self.act_size = (sum(int(np.prod(s, dtype=int)) for s in shapes) for shapes in self._shapes)
        self._out = np.empty((self.n, self.observe_size))
        self._native.observe(self._out)
        self._flush()

    @property
    def shapes(self) -> Tuple[List[Tuple[int, ...]], List[Tuple[int, ...]]]:
        """The shapes of the observations and of the actions, in the order given to `bind`."""
        return [tuple(s) for s in self._shapes[0]], [tuple(s) for s in self._shapes[1]]

    @property
    def bounds(self) -> List[Tuple[Optional[float], Optional[float]]]:
        """The lowest and the highest value of each action, in the order given to `bind`; `None` if it is unlimited."""
        return self._native.bounds()

    def step(
        self, actions: Optional[Any] = None, n: int = 1, *, worlds: Optional[np.ndarray] = None
    ) -> np.ndarray:
        """Set the actions, run `n` steps in each world, and return the observations, an array of `self.n` rows.

        Args:
            actions: One row per world, with the values in the order of `act`; None keeps the last actions.
            n: Number of steps.
            worlds: A mask of the worlds that are stepped; by default all. The observations of the other worlds are
                those of their last step.

        Returns:
            A new array with one row per world, in the order of `observe`. Afterwards, `self.running` is a mask of the
            worlds that are still running.
        """
        if actions is not None:
            actions = rows(actions, self.n, self.act_size)
        if worlds is not None:
            worlds = np.ascontiguousarray(worlds, dtype=bool)
            if worlds.shape != (self.n,):
                raise ValueError(f"expected a mask of shape ({self.n},), one per world; found shape {worlds.shape}")
        n = whole("n", n)
        # Steps are run in chunks, between which Python handles Ctrl-C.
        running, logged = self._native.step(actions, min(n, 64), worlds, self._out)
        for done in range(64, n, 64):
            running, more = self._native.step(None, min(n - done, 64), worlds, self._out)
            logged |= more
        self.running = np.array(running)
        if logged:
            self._flush()
        return self._out.copy()

    @property
    def observations(self) -> np.ndarray:
        """A copy of the observations after the last step or reset."""
        return self._out.copy()

    def reset(
        self,
        worlds: Optional[Sequence[int]] = None,
        *,
        seeds: Optional[Sequence[Optional[int]]] = None,
        sets: Optional[Sequence[Optional[Mapping[str, Any]]]] = None,
    ) -> np.ndarray:
        """Reset the given worlds, by default all, and return the observations of all worlds.

        Args:
            worlds: Indices of worlds, or a mask.
            seeds: A new seed for each of these worlds; None keeps the current one.
            sets: Changes to the scene for each of these worlds, which replace the current changes; None keeps them.
        """
        chosen = list(range(self.n)) if worlds is None else numbers(worlds, self.n)
        for name, values in (("seeds", seeds), ("sets", sets)):
            if values is not None and len(values) != len(chosen):
                raise ValueError(f"{len(values)} {name} were given for {len(chosen)} worlds; expected one for each")
        seeds_of = [None] * len(chosen) if seeds is None else [None if s is None else whole("seeds", s) for s in seeds]
        sets_of = [None] * len(chosen) if sets is None else [None if s is None else settings(s) for s in sets]
        self._native.reset(chosen, seeds_of, sets_of)
        self.running[chosen] = True
        self._native.observe(self._out)
        self._flush()
        return self._out.copy()

    def get(self, path: str, key: str) -> np.ndarray:
        """Return a property of an object in all worlds, one row per world."""
        return np.array(self._native.get(path, key))

    def set(self, path: str, key: str, values: Sequence[Any]) -> None:
        """Set a property of an object in all worlds, with one value per world."""
        self._native.set(path, key, list(values))

    def fork(self, world: int, into: Optional[Sequence[int]] = None) -> None:
        """Copy the state of one world to others, by default to all. All must have the same seed and changes."""
        others = range(self.n) if into is None else numbers(into, self.n)
        state = self._native.snapshot(world)
        self._native.restore([other for other in others if other != world], state)
        self.running[list(others)] = True
        self._native.observe(self._out)

    def snapshot(self, world: int) -> bytes:
        """Return the state of a world, for `restore`."""
        return self._native.snapshot(world)

    def restore(self, worlds: Sequence[int], snapshot: bytes) -> None:
        """Restore worlds to a state that `snapshot` returned for this scene."""
        chosen = numbers(worlds, self.n)
        self._native.restore(chosen, snapshot)
        self.running[chosen] = True
        self._native.observe(self._out)

    def render(
        self,
        world: int = 0,
        camera: Optional[str] = None,
        *,
        look_from: Optional[Sequence[float]] = None,
        look_at: Optional[Sequence[float]] = None,
        size: Tuple[int, int] = (640, 480),
        fov: Optional[float] = None,
    ) -> np.ndarray:
        """Render a picture of a world, as `World.render` does."""
        points = view(look_from, look_at)
        return self._native.render(world, camera, points, int(size[0]), int(size[1]), fov)

    @property
    def env(self) -> Optional[Dict[str, Any]]:
        """The table `[env]` of the scene, or None if there is none."""
        return self._native.env()

    def hash(self) -> List[int]:
        """Return the hash of each world's state."""
        return self._native.hashes()

    @property
    def times(self) -> np.ndarray:
        """The simulation time of each world, s."""
        return np.array(self._native.times())

    @property
    def dt(self) -> float:
        """The length of a step, s."""
        return self._native.dt()

    def close(self) -> None:
        """End all worlds."""
        self._native.close()

    def __len__(self) -> int:
        return self.n

    def __enter__(self) -> "Batch":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def _flush(self) -> None:
        for world, level, code, text in self._native.lines():
            if not self.quiet:
                write_line(level, code, text, f"world {world}: ")


def cores() -> int:
    """Return the number of cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:
        return os.cpu_count() or 1


def rows(actions: Any, n: int, size: int) -> np.ndarray:
    """Return actions as an array with a row of `size` values for each of `n` worlds.

    An array with one dimension is accepted if there is only one world, or only one value per world.
    """
    try:
        array = np.ascontiguousarray(actions, dtype=np.float64)
    except (TypeError, ValueError) as e:
        raise ValueError(f"the actions cannot be converted to an array of numbers: {e}") from None
    if array.shape == (n, size) or (array.ndim == 1 and array.size == n * size and 1 in (n, size)):
        return array.reshape(n, size)
    expected = f"({size},)" if n == 1 else f"({n}, {size}), one row per world"
    raise ValueError(f"the actions have the shape {array.shape}; expected {expected}")


def numbers(worlds: Any, n: int) -> List[int]:
    """Return the indices of the worlds that `worlds` selects: indices, or a boolean mask of length `n`."""
    array = np.asarray(worlds)
    if array.dtype == bool:
        if array.shape != (n,):
            raise ValueError(f"expected a boolean mask of shape ({n},), one value per world; found shape {array.shape}")
        return [int(w) for w in np.flatnonzero(array)]
    chosen = [int(w) for w in array.reshape(-1)]
    for world in chosen:
        if not 0 <= world < n:
            raise IndexError(f"there is no world {world}; expected an index from 0 to {n - 1}")
    return chosen


def spread(changes: Optional[Mapping[str, Any]], n: int) -> List[Dict[str, Any]]:
    """Return one dictionary of changes per world; a sequence of length `n` gives each world its own value."""
    out: List[Dict[str, Any]] = [{} for _ in range(n)]
    for key, value in (changes or {}).items():
        each = isinstance(value, (list, tuple, np.ndarray)) and len(value) == n
        if isinstance(value, (list, tuple, np.ndarray)) and not each:
            expected = f"expected {n} values, one per world, or a single value for all worlds"
            raise ValueError(f"`{key}` has {len(value)} values; {expected}")
        for world in range(n):
            out[world][key] = value[world] if each else value
    return out
