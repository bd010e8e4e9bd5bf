"""Tatu, a robot simulator, as a module of Python.

    import tatu_sim

    world = tatu_sim.World("pioneer_avoids_walls.toml")
    world.run(10.0)
    print(world["/Pioneer_p3dx"].position, hex(world.hash))

- `World`: a scene that runs; `Object`: an object in it; `Reading`: what a sensor measured.
- `Batch`: many worlds, stepped together on all cores.
- `tatu_sim.gym`: environments for Gymnasium, described by the scene (needs `gymnasium`).
- `tatu_sim.sweep`: many runs with different parameters, on one machine or on many.
- `python -m tatu_sim`: the command line.
"""

from ._batch import Batch
from ._files import models, scenes
from ._native import Error, __version__, crash_reports as _crash_reports
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


def crash_reports(on: bool = True) -> None:
    """Report crashes of this process from now on: the plugin, its function and the object.

    This installs signal handlers and stays until the process ends. Without it, and unless the command line is used,
    the simulator installs none.
    """
    if not on:
        raise ValueError("crash reports cannot be switched off: other handlers may have been installed since")
    _crash_reports()


#: What needs modules that most programs do without: pools of processes, Ray.
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
