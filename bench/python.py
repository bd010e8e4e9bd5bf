#!/usr/bin/env python3
"""Measures the speed of the Python package as ratios: a step compared with the same step in Rust, and a batch of 64
Pioneers with 16 sonars compared with MuJoCo's batches and Gymnasium's processes.

    python bench/python.py [--worlds 64] [--seconds 20]

Requires numpy; the peers require gymnasium, mujoco==3.14.0 and mjbatch==0.1.4. All simulate the same time: one step of
50 ms in Tatu, five of 10 ms in the peers. Every row is the best of three, because other programs only make it slower;
the batch is measured again with each peer, because the speed of a shared machine changes within minutes.
"""

import argparse
import functools
import json
import subprocess
import sys
import time

import numpy as np

import tatu_sim

SCENE = "first/pioneer_avoids_walls.toml"
MODEL = """
<mujoco>
  <option timestep="0.01" integrator="implicitfast"/>
  <worldbody>
    <geom type="plane" size="20 20 0.1"/>
    {walls}
    <body name="robot" pos="0 0 0.1">
      <freejoint/>
      <geom type="box" size="0.2 0.15 0.08" mass="8" group="1"/>
      <geom type="sphere" size="0.03" pos="-0.18 0 -0.07" mass="0.3" friction="0 0 0" group="1"/>
      {sites}
      <body pos="0 0.16 0"><joint name="l" axis="0 1 0"/><geom type="sphere" size="0.0975" mass="1" group="1"/></body>
      <body pos="0 -0.16 0"><joint name="r" axis="0 1 0"/><geom type="sphere" size="0.0975" mass="1" group="1"/></body>
    </body>
  </worldbody>
  <actuator><velocity joint="l" kv="5"/><velocity joint="r" kv="5"/></actuator>
  <sensor>{sensors}</sensor>
</mujoco>
"""


def model(sonars):
    """Returns the MuJoCo model of a robot with two wheels and a ring of sonars, between boxes."""
    places = [(2, 0), (-2, 0), (0, 2), (0, -2), (1.5, 1.5), (-1.5, 1.5), (1.5, -1.5)]
    walls = "".join(f'<geom type="box" size="0.2 0.2 0.3" pos="{x} {y} 0.3"/>' for x, y in places)
    angles = np.linspace(0, 2 * np.pi, sonars, endpoint=False)
    sites = "".join(
        f'<site name="s{i}" pos="{0.3 * np.cos(a):.4f} {0.3 * np.sin(a):.4f} 0" zaxis="{np.cos(a):.4f} {np.sin(a):.4f} 0"/>'
        for i, a in enumerate(angles)
    )
    sensors = "".join(f'<rangefinder site="s{i}"/>' for i in range(sonars))
    return MODEL.format(walls=walls, sites=sites, sensors=sensors)


def best(run, times=3):
    """Runs `run` several times, and returns the shortest duration, s."""
    found = []
    for _ in range(times):
        begin = time.perf_counter()
        run()
        found.append(time.perf_counter() - begin)
    return min(found)


def steps(count):
    """Returns durations of a step, s: in the program, with one call per step, with one call in total; and of a call."""
    out = subprocess.run(
        [sys.executable, "-m", "tatu_sim", "run", SCENE, "--steps", str(count), "--json"], capture_output=True, check=True
    )
    program = json.loads(out.stdout)["wall_s"] / count
    with tatu_sim.World(SCENE) as world:
        world.step(count)

        def singly():
            for _ in range(count):
                world.step()

        one = best(singly) / count
        many = best(lambda: world.step(count)) / count
    with tatu_sim.World(text="format = 1") as world:

        def empty():
            for _ in range(count):
                world.step()

        nothing = best(empty) / count
        together = best(lambda: world.step(count)) / count
    return program, one, many, nothing - together


def batch(worlds, count, threads=None):
    """Returns steps of 50 ms per second, summed over all worlds."""
    sonars = [(f"Pioneer_p3dx_ultrasonicSensor{i}", "proximity.distance") for i in range(1, 17)]
    motors = [(f"Pioneer_p3dx_{side}Motor", "joint.target_velocity") for side in ("left", "right")]
    with tatu_sim.Batch(SCENE, worlds, observe=sonars, act=motors, threads=threads, quiet=True) as many:
        actions = np.full((worlds, 2), 2.0)
        many.step(actions, 5)

        def run():
            for _ in range(count):
                many.step(actions)

        return worlds * count / best(run)


def mjbatch_rate(worlds, count, sonars):
    import mjbatch
    import mujoco

    many = mjbatch.Batch(mujoco.MjModel.from_xml_string(model(sonars)), worlds)
    many.bind("ctrl")[:] = 2.0
    many.step(nstep=5)

    def run():
        for _ in range(count):
            many.step(nstep=5)

    return worlds * count / best(run)


class Robot:
    """An environment that is created in each process. A call to `step` runs several steps of 10 ms."""

    def __new__(cls, steps):
        import gymnasium
        import mujoco

        class Env(gymnasium.Env):
            observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (16,))
            action_space = gymnasium.spaces.Box(-10, 10, (2,))

            def __init__(self):
                self.model = mujoco.MjModel.from_xml_string(model(16))
                self.data = mujoco.MjData(self.model)

            def reset(self, seed=None, options=None):
                mujoco.mj_resetData(self.model, self.data)
                return self.data.sensordata.astype(np.float32), {}

            def step(self, action):
                self.data.ctrl[:] = action
                mujoco.mj_step(self.model, self.data, steps)
                return self.data.sensordata.astype(np.float32), 0.0, False, False, {}

        return Env()


def async_rate(worlds, count, calls):
    """Returns steps of 50 ms per second, summed over all worlds, with one call or five per step."""
    from gymnasium.vector import AsyncVectorEnv

    many = AsyncVectorEnv([functools.partial(Robot, 5 // calls)] * worlds)
    many.reset()
    actions = np.full((worlds, 2), 2.0, dtype=np.float32)

    def run():
        for _ in range(count * calls):
            many.step(actions)

    rate = worlds * count / best(run)
    many.close()
    return rate


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--worlds", type=int, default=64)
    parser.add_argument("--steps", type=int, default=100)
    args = parser.parse_args()
    program, one, many, empty = steps(2000)
    print(f"a step: {1e6 * program:.1f} us in the program, {1e6 * many:.1f} by one call for all, {1e6 * one:.1f} one by one")
    print(f"World.step beyond the step: {1e6 * (one - many):.2f} us in this scene, {1e6 * empty:.2f} us in an empty one")
    own = batch(args.worlds, args.steps)
    alone = batch(args.worlds, args.steps // 4, threads=1)
    print(f"Batch of {args.worlds}: {own:,.0f} steps of 50 ms a second, {own / alone:.2f} x one thread")
    rows = [
        ("AsyncVectorEnv over MuJoCo, a call each 10 ms", "gymnasium", lambda: async_rate(args.worlds, args.steps // 4, 5)),
        ("AsyncVectorEnv over MuJoCo, a call each 50 ms", "gymnasium", lambda: async_rate(args.worlds, args.steps, 1)),
        ("mjbatch with 16 rangefinders", "mjbatch", lambda: mjbatch_rate(args.worlds, args.steps * 10, 16)),
        ("mjbatch without sensors", "mjbatch", lambda: mjbatch_rate(args.worlds, args.steps * 10, 0)),
    ]
    for name, needs, rate in rows:
        try:
            __import__(needs)
            own = batch(args.worlds, args.steps)
            other = rate()
            own = max(own, batch(args.worlds, args.steps))
        except ImportError as e:
            print(f"{name}: not compared, {e}")
            continue
        print(f"{name}: {other:,.0f} a second; Tatu {own / other:.2f} x")


if __name__ == "__main__":
    main()
