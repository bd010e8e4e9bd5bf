"""Examples, each a program: `python -m tatu_sim.examples.avoid_walls`."""
