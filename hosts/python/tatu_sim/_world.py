"""The class `World`, which loads and simulates a scene, and its objects and readings."""

import contextlib
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from . import _native
from ._commands import Namespaces, commands_of
from ._log import logger, write_line
from ._settings import settings, whole

PathLike = Union[str, "os.PathLike[str]"]


class Fault(NamedTuple):
    """An error of a script or plugin during a run. `str()` returns a single line."""

    code: str
    text: str
    help: Optional[str]
    plugin: Optional[str]
    script: Optional[str]
    object: Optional[str]
    file: Optional[str]
    line: Optional[int]
    traceback: Optional[str]
    count: int

    def __str__(self) -> str:
        place = f" ({self.file}:{self.line})" if self.file and self.line else ""
        where = f" {self.object}:" if self.object else ""
        often = f" [{self.count} times]" if self.count > 1 else ""
        return f"[{self.code}]{where} {self.text}{place}{often}"


class Reading(Mapping[str, Any]):
    """The last measurement of a sensor: a mapping from names of fields, such as `range_scan.distance`, to arrays.

    A field is also an attribute if the last part of its name is unique: `reading.distance`. The arrays are copies.
    """

    def __init__(self, raw: Dict[str, Any]):
        self.path: str = raw["path"]
        self.kind: str = raw["kind"]
        #: Simulation time of the measurement, s.
        self.time: float = raw["time"]
        #: Number of measurements so far; 0 if the sensor has not been measured yet.
        self.sequence: int = raw["sequence"]
        self.fields: Dict[str, Any] = raw["fields"]

    def __getitem__(self, name: str) -> Any:
        try:
            return self.fields[name]
        except KeyError:
            raise KeyError(f"the reading has no field {name!r}; it has {', '.join(self.fields)}") from None

    def __iter__(self):
        return iter(self.fields)

    def __len__(self) -> int:
        return len(self.fields)

    def __getattr__(self, name: str) -> Any:
        found = [key for key in self.__dict__.get("fields", ()) if key.rpartition(".")[2] == name]
        if len(found) == 1:
            return self.fields[found[0]]
        raise AttributeError(f"the reading has no field {name!r}; it has {', '.join(self.__dict__.get('fields', ()))}")

    def __repr__(self) -> str:
        return f"<Reading of {self.path} ({self.kind}) at {self.time:g} s: {', '.join(self.fields)}>"


class Object:
    """An object of a world, by its path. Its properties are items: `joint["joint.target_velocity"] = 2.0`."""

    __slots__ = ("world", "path")

    def __init__(self, world: "World", path: str):
        self.world = world
        self.path = path

    def __getitem__(self, key: str) -> Any:
        return self.world.get(self.path, key)

    def __setitem__(self, key: str, value: Any) -> None:
        self.world.set(self.path, key, value)

    @property
    def position(self) -> np.ndarray:
        """The position x, y, z in the world frame, m."""
        return self["object.world_pose"][:3]

    @property
    def pose(self) -> np.ndarray:
        """The position x, y, z in the world frame, m, and the quaternion x, y, z, w. It can be set."""
        return self["object.world_pose"]

    @pose.setter
    def pose(self, value: Any) -> None:
        self["object.world_pose"] = np.asarray(value, dtype=float)

    @property
    def twist(self) -> np.ndarray:
        """The linear velocity, m/s, and angular velocity, rad/s, in the world frame."""
        return self["object.twist"]

    @property
    def reading(self) -> Reading:
        """The last reading, if the object is a sensor."""
        return self.world.reading(self.path)

    def __repr__(self) -> str:
        return f"<Object {self.path}>"


class World(Namespaces):
    """A running scene. Its time starts at 0, and each step advances it by `dt` seconds of simulation time.

    A world may be used from any thread; concurrent calls are serialized. Each world has its own thread, so worlds that
    are stepped by different Python threads run in parallel.

    Commands of plugins are methods of their namespace: `world.sim.getObjectPosition(handle)`.

    Args:
        scene: A scene file (`.toml`, `.ttt`, `.urdf`, `.sdf`, MuJoCo's `.xml`), or the name of a scene that comes with the package.
        text: The text of a scene file, instead of `scene`.
        folder: The folder to which paths in `text` are relative; the working folder by default.
        seed: Seed of all random numbers; the scene's own by default.
        set: Changes to the scene: `{"/Robot/leftMotor.max_force_nm": 2.0, "scene.dt_s": 0.01}`.
        scripts: Scripts that replace those of objects: `{"/Robot": "my_controller.lua"}`. Instead of a file, a class, an
            instance or a function of this program may be given: its methods `sysCall_init`, `sysCall_actuation`,
            `sysCall_sensing` ... are called at their place in the step, with an object that has the commands; a function
            is called as `sysCall_actuation`.
        allow: Permissions of scripts: `"python"` for scripts in Python, `"exec"`, `"native"`, `"net=HOST:PORT"`;
            `"plugins"`: load plugins that the scene names.
        services: Services to start: `"page:port=8080"`.
        languages: Settings of script languages: `{"python": {"interpreter": "/usr/bin/python3"}}`. By default, scripts in
            Python run in the interpreter of this process.
        plugins: Plugin libraries, or folders with plugin libraries.
        threads: Number of threads of this world. Results do not depend on it.
        files: The folder in which scripts open files; the working folder by default.
        strict: Raise `Error` from `step` as soon as a script or plugin fails. Otherwise errors are logged, and listed
            in `faults`.
        film: Record the run for `show`.

    Raises:
        Error: The scene or a change is invalid.
    """

    def __init__(
        self,
        scene: Optional[PathLike] = None,
        *,
        text: Optional[str] = None,
        folder: PathLike = ".",
        seed: Optional[int] = None,
        set: Optional[Mapping[str, Any]] = None,
        scripts: Optional[Mapping[str, Any]] = None,
        allow: Sequence[str] = (),
        services: Sequence[str] = (),
        languages: Optional[Mapping[str, Mapping[str, Any]]] = None,
        plugins: Sequence[PathLike] = (),
        threads: int = 1,
        files: Optional[PathLike] = None,
        strict: bool = False,
        film: bool = False,
    ):
        services = list(services)
        self._film: Optional[tempfile.TemporaryDirectory] = None
        if film:
            self._film = tempfile.TemporaryDirectory(prefix="tatu-film-")
            services.append(f"film:page={Path(self._film.name) / 'film.html'}")
        arguments = setup(scene, text, folder, seed, set, scripts, allow, services, languages, plugins, threads, files)
        self._begin(_native.World(arguments), strict)
        for warning in self._native.warnings():
            logger.warning("%s", warning)

    def _begin(self, native: "_native.World", strict: bool) -> None:
        self._native = native
        self._strict = strict
        self._views: List[Tuple[Any, np.ndarray]] = []
        self._flush()

    def _flush(self) -> None:
        for line in self._native.lines():
            write_line(*line)

    # ------------------------------------------------------------------------------------------------------ the run

    def step(self, n: int = 1) -> int:
        """Run `n` steps, or fewer if a script stops the world. Return the number of steps run.

        In the meantime, other Python threads can run, and Ctrl-C is handled.
        """
        if self._strict and n > 1:
            # Steps are run one by one, so that the run ends at the first error.
            done = 0
            while done < n and self.step(1):
                done += 1
            return done
        try:
            done, self.running, lines = self._native.step(n)
        except (OverflowError, TypeError):
            whole("n", n)
            raise
        except BaseException:
            # Even after Ctrl-C or an error, the lines that were logged before it are written.
            with contextlib.suppress(Exception):
                self._flush()
            raise
        if self._views:
            self._update()
        if lines:
            self._report(lines)
        return done

    #: Whether the world is still running, i.e. has not been stopped.
    running: bool = True

    def _report(self, lines) -> None:
        for line in lines:
            write_line(*line)
        if self._strict:
            for level, code, text in lines:
                if level == "error":
                    raise _error(code, text, self.faults)

    def run(self, seconds: float, *, progress: Optional[bool] = None) -> int:
        """Run for a duration in seconds of simulation time. Return the number of steps run.

        `progress`: show a bar; by default on a terminal, and only for runs that take longer than a second.
        """
        if not 0 <= seconds < float("inf"):
            raise ValueError(f"`seconds` is {seconds}; expected a finite time of at least 0 s")
        steps = round(seconds / self.dt)
        shown = sys.stderr.isatty() if progress is None else progress
        if not shown:
            return self.step(steps)
        done, begin = 0, time.monotonic()
        chunk = 1
        bar = False
        while done < steps:
            before = time.monotonic()
            n = self.step(min(chunk, steps - done))
            done += n
            now = time.monotonic()
            if now - before < 0.1:
                chunk *= 2
            if now - begin > 1.0 or progress:
                bar = True
                _draw(done, steps, now - begin)
            if not self.running:
                break
        if bar:
            print(file=sys.stderr)
        return done

    def reset(self, seed: Optional[int] = None, set: Optional[Mapping[str, Any]] = None) -> None:
        """Reset the world to time 0. The given seed and changes replace those given when the world was created."""
        seed = None if seed is None else whole("seed", seed)
        self._native.reset(seed, None if set is None else settings(set))
        self.running = True
        self._after()

    def _after(self) -> None:
        self._flush()
        if self._views:
            self._update()

    @property
    def time(self) -> float:
        """The simulation time, s."""
        return self._native.clock()[0]

    @property
    def steps(self) -> int:
        """The number of steps run so far."""
        return self._native.clock()[1]

    @property
    def dt(self) -> float:
        """The length of a step, s."""
        return self._native.clock()[2]

    @property
    def hash(self) -> int:
        """The hash of the state. The same scene, seed, changes and calls yield the same hash on every machine."""
        return self._native.hash()

    @property
    def faults(self) -> List[Fault]:
        """The errors of scripts and plugins so far."""
        return [Fault(**f) for f in self._native.faults()]

    # ---------------------------------------------------------------------------------------------------- the state

    def snapshot(self) -> bytes:
        """Return the state of the world for `restore`: that of objects, sensors, scripts and random numbers."""
        return self._native.snapshot()

    def restore(self, snapshot: bytes) -> None:
        """Restore a state of this world, or of another world with the same scene and changes."""
        self._native.restore(snapshot)
        self.running = True
        self._after()

    def fork(self) -> "World":
        """Create another, independent world in the same state."""
        other = World.__new__(World)
        other._film = None
        other._begin(self._native.fork(), self._strict)
        return other

    def close(self) -> None:
        """End the world, which cannot be used afterwards. `with` and garbage collection do this automatically."""
        self._native.close()

    def __enter__(self) -> "World":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    # ------------------------------------------------------------------------------------------------- the contents

    def __getitem__(self, path: str) -> Object:
        """Return an object, by path or unique name."""
        # Raises an error that suggests the nearest name if there is no such object.
        self._native.get(path, "object.path")
        return Object(self, path)

    @property
    def objects(self) -> Dict[str, str]:
        """The paths of all objects, with their kinds."""
        return dict(self._native.objects())

    @property
    def joints(self) -> List[str]:
        """The paths of all joints."""
        return [path for path, kind in self._native.objects() if kind == "joint"]

    @property
    def sensors(self) -> List[str]:
        """The paths of all sensors."""
        return self._native.sensors()

    def get(self, path: str, key: str) -> Any:
        """Return a property of an object: a number, a string or an array (a copy). An empty path refers to the
        world."""
        return self._native.get(path, key)

    def set(self, path: str, key: str, value: Any) -> None:
        """Set a property of an object, as a script would: `world.set("/Robot/motor", "joint.target_velocity", 2.0)`."""
        self._native.set(path, key, value)

    def reading(self, path: str) -> Reading:
        """Return the last reading of a sensor."""
        return Reading(self._native.reading(path))

    def view(self, path: str, name: str) -> np.ndarray:
        """Return an array that contains a property, or a field of readings, and is updated after each step.

        The array belongs to the caller and outlives the world. Writing to it does not affect the world.
        """
        channel = self._native.channel(path, name)
        flat = np.empty(int(np.prod(channel.shape, dtype=int)))
        self._views.append((channel, flat))
        self._update()
        return flat.reshape(channel.shape)

    def _update(self) -> None:
        for channel, flat in self._views:
            self._native.read_into([channel], flat)

    def call(self, name: str, *args: Any) -> Any:
        """Call a command: `world.call("sim.getObject", "/Robot")`. Several results are returned as a tuple."""
        results = self._native.call(name, list(args))
        self._flush()
        if not results:
            return None
        return results[0] if len(results) == 1 else tuple(results)

    @property
    def plugins(self) -> Dict[str, str]:
        """The ids of all plugins, with their versions."""
        return dict(self._native.plugins())

    def _declarations(self) -> Dict[str, Dict[str, Any]]:
        return commands_of(self._native)

    # ------------------------------------------------------------------------------------------------------- pictures

    def render(
        self,
        camera: Optional[str] = None,
        *,
        look_from: Optional[Sequence[float]] = None,
        look_at: Optional[Sequence[float]] = None,
        size: Tuple[int, int] = (640, 480),
        fov: Optional[float] = None,
    ) -> np.ndarray:
        """Render a picture, as an array of rows, columns and RGB (`uint8`). No display is needed.

        The viewpoint is a camera of the scene, or two points in m; by default the scene's first camera, or a viewpoint
        that shows everything. `size`: columns and rows; `fov`: the horizontal field of view, rad.
        """
        points = view(look_from, look_at)
        return self._native.render(camera, points, int(size[0]), int(size[1]), fov)

    def show(self, *, width: int = 800, height: int = 500) -> Any:
        """Return the film of the run so far, for a notebook. The world must have been created with `film=True`.

        This ends the recording, but not the run.
        """
        from ._film import Film

        if self._film is None:
            raise ValueError("the run was not recorded: create the world with `film=True`")
        self._native.end_services()
        self._flush()
        return Film(Path(self._film.name) / "film.html", width, height)

    def __repr__(self) -> str:
        try:
            time_s, steps, _ = self._native.clock()
        except ValueError:
            return "<World, closed>"
        return f"<World at {time_s:g} s, step {steps}>"


def view(look_from, look_at) -> Optional[Tuple[List[float], List[float]]]:
    """Return the points of a view, or None if it is not given by points."""
    if (look_from is None) != (look_at is None):
        raise ValueError("`look_from` and `look_at` must be given together")
    if look_from is None or look_at is None:
        return None
    return [float(x) for x in look_from], [float(x) for x in look_at]


def setup(
    scene, text, folder, seed, changes, scripts, allow, services, languages, plugins, threads, files
) -> Dict[str, Any]:
    """Convert arguments for the native part."""
    if (scene is None) == (text is None):
        raise TypeError("expected either `scene` or `text`")
    if not 1 <= threads <= 256:
        raise ValueError(f"`threads` is {threads}; expected a number from 1 to 256")
    files_of = {path: script for path, script in (scripts or {}).items() if isinstance(script, (str, os.PathLike))}
    objects = [(path, script) for path, script in (scripts or {}).items() if path not in files_of]
    # Scripts in Python find the packages that this program has, unless the user has chosen another interpreter.
    own = None if os.environ.get("TATU_PYTHON") else sys.executable
    return {
        "scene": None if scene is None else os.fspath(scene),
        "text": text,
        "folder": os.path.abspath(folder),
        "seed": None if seed is None else whole("seed", seed),
        "set": settings(changes),
        "scripts": [f"{path}={os.fspath(file)}" for path, file in files_of.items()],
        "objects": objects,
        "allow": list(allow),
        "services": list(services),
        "languages": [f"{name}:{one}" for name, values in (languages or {}).items() for one in settings(values)],
        "language_defaults": [("python", "interpreter", own)] if own else [],
        # The native module offers the language of scripts that are objects.
        "plugins": [os.path.abspath(p) for p in [*plugins, *([_native.__file__] if objects else [])]],
        "threads": int(threads),
        "files": None if files is None else os.path.abspath(files),
    }


def _error(code: Optional[str], text: str, faults: Sequence[Fault]) -> "_native.Error":
    error = _native.Error(f"[{code}] {text}" if code else text)
    last = next((f for f in reversed(faults) if f.code == code), None)
    error.code, error.text = code, text
    error.help = last.help if last else None
    error.file, error.line = (last.file, last.line) if last else (None, None)
    return error


def _draw(done: int, steps: int, seconds: float) -> None:
    width = 30
    full = width * done // max(steps, 1)
    left = seconds / done * (steps - done) if done else 0.0
    print(
        f"\r[{'#' * full}{'.' * (width - full)}] step {done} of {steps}, {left:.0f} s left  ",
        end="",
        file=sys.stderr,
        flush=True,
    )
