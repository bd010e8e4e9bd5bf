"""Tatu, a robot simulator, as a Python module.

    import tatu_sim

    world = tatu_sim.World("pioneer_avoids_walls.toml")
    world.run(10.0)
    print(world["/Pioneer_p3dx"].position, hex(world.hash))

- `World`: a running scene; `Object`: an object in it; `Reading`: the last measurement of a sensor.
- `Batch`: many worlds, stepped together on all cores.
- `tatu_sim.gym`: environments for Gymnasium, described by the scene (needs `gymnasium`).
- `tatu_sim.sweep`: many runs with different parameters, on one machine or on many.
- `python -m tatu_sim`: the command line.
"""

import atexit

from ._batch import Batch
from ._files import models, scenes
from ._native import Error, __version__, crash_reports as _crash_reports, finish
from ._world import Fault, Object, Reading, World

__all__ = [
    "Batch",
    "CheckError",
    "Error",
    "Fault",
    "Job",
    "Object",
    "Reading",
    "Rows",
    "World",
    "__version__",
    "crash_reports",
    "models",
    "ray_executor",
    "scenes",
    "sweep",
]

# Daemon threads may still be in a native call when the interpreter exits, and must not return to it after that.
atexit.register(finish)
del atexit, finish


def crash_reports(on: bool = True) -> None:
    """Report crashes of this process from now on, with the plugin, its function and the object.

    This installs signal handlers, which remain until the process exits. Without this call, the simulator installs no
    signal handlers, unless the command line is used.
    """
    if not on:
        raise ValueError("crash reports cannot be switched off: other handlers may have been installed since")
    _crash_reports()


#: Names that are imported on first use, because they need modules that most programs do not use: process pools, Ray.
_LATER = {
    "CheckError": "_sweep",
    "Job": "_sweep",
    "Rows": "_sweep",
    "ray_executor": "_sweep_ray",
    "sweep": "_sweep",
}


def __getattr__(name):
    if name in _LATER:
        from importlib import import_module

        return getattr(import_module(f".{_LATER[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
