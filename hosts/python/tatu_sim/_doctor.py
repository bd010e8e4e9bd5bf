"""`python -m tatu_sim doctor`: checks whether this installation works."""

import platform
import sys
import time
from typing import Sequence

from ._files import HERE, models, scenes
from ._native import Error, __version__
from ._world import World

#: A scene with a script, wheels and sonars, the number of steps to run, and the hash that is expected on every machine.
SCENE, STEPS, HASH = "first/pioneer_avoids_walls.toml", 200, 0x38EBB9C9559C878B


def doctor(args: Sequence[str] = ()) -> int:
    """Print the installed components, and run a scene. Return exit code 0 if the scene ends in the expected state."""
    if args:
        print(f"usage: {sys.executable} -m tatu_sim doctor", file=sys.stderr)
        return 2
    print(f"tatu_sim {__version__} in {HERE}")
    print(f"Python {platform.python_version()}, {platform.machine()}, {platform.platform()}")
    print(f"{len(scenes())} scenes, {len(models())} models")
    begin = time.perf_counter()
    try:
        world = World(SCENE)
    except Error as e:
        print(f"the scene {SCENE} cannot be opened:\n{e}", file=sys.stderr)
        return 1
    opened = time.perf_counter()
    with world:
        plugins = world.plugins
        world.step(STEPS)
        ran, found, simulated = time.perf_counter(), world.hash, world.time
    width = max(map(len, plugins))
    for name, version in sorted(plugins.items()):
        print(f"  {name:<{width}}  {version}")
    print(f"{SCENE}: opened in {1e3 * (opened - begin):.0f} ms, {simulated / (ran - opened):.0f} x real time")
    if found != HASH:
        print(
            f"hash after {STEPS} steps: {found:016x}, but {HASH:016x} was expected: this machine computes different "
            "results. Please report this, with the lines above.",
            file=sys.stderr,
        )
        return 1
    print(f"hash after {STEPS} steps: {found:016x}, as expected")
    return 0
