"""What makes a run the same each time: seeds of random numbers, and the time of the simulation."""

import importlib.abc
import importlib.util
import random
import sys
import types


def seed(number, api):
    """Seeds the generators of `random` and `numpy.random`."""
    random.seed(number)
    # Generators without a seed of their own get one from the script's, in the order in which they are created.
    state = random.Random(number ^ 0x9E3779B97F4A7C15)

    class SeededRandom(random.Random):
        def seed(self, a=None, *rest, **named):
            super().seed(state.getrandbits(64) if a is None else a, *rest, **named)

    SeededRandom.__name__ = SeededRandom.__qualname__ = "Random"
    random.Random = SeededRandom
    sys.meta_path.insert(0, NumpyFinder(number, state))


class NumpyFinder(importlib.abc.MetaPathFinder):
    """Seeds numpy's generators when they are imported."""

    NAME = "numpy.random"

    def __init__(self, number, state):
        self.number, self.state, self.busy = number, state, False

    def find_spec(self, name, path, target=None):
        if name != self.NAME or self.busy:
            return None
        self.busy = True
        try:
            spec = importlib.util.find_spec(name)
        finally:
            self.busy = False
        if spec is None or spec.loader is None:
            return None
        execute, finder = spec.loader.exec_module, self

        def exec_module(module):
            execute(module)
            finder.seed(module)

        spec.loader.exec_module = exec_module
        return spec

    def seed(self, module):
        module.seed(self.number & 0xFFFFFFFF)
        make, state = module.default_rng, self.state

        def default_rng(seed=None):
            return make(state.getrandbits(64) if seed is None else seed)

        default_rng.__doc__ = make.__doc__
        module.default_rng = default_rng


def clock(api, threads, now_name, wait_name):
    """Returns a module `time` whose clock is that of the simulation, read with one command, and whose `sleep` calls the
    other. Only the script itself gets it: libraries measure real time."""
    import time

    module = types.ModuleType("time", time.__doc__)
    module.__dict__.update({k: v for k, v in time.__dict__.items() if not k.startswith("__")})

    def now():
        found, command = api.lookup(now_name)
        return float(command()) if found else time.time()

    def sleep(seconds):
        if seconds < 0:
            raise ValueError("sleep length must be non-negative")
        found, command = api.lookup(wait_name)
        # Elsewhere, the simulation stands still while the script runs, so there is nothing to wait for.
        if found and threads.running is not None:
            command(float(seconds))

    def nanoseconds():
        return int(now() * 1e9)

    for name in ("time", "monotonic", "perf_counter", "process_time", "thread_time"):
        setattr(module, name, now)
        setattr(module, name + "_ns", nanoseconds)
    module.sleep = sleep
    return module
