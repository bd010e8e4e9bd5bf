"""Tests of the environments for Gymnasium."""

import os
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import tatu_sim

gymnasium = pytest.importorskip("gymnasium", reason="gymnasium is not installed: pip install 'tatu-sim[gym]'")

from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium.vector import AutoresetMode, SyncVectorEnv  # noqa: E402

from sled import SLED  # noqa: E402
from tatu_sim.gym import Env, VectorEnv, make_env, make_vec  # noqa: E402

PIONEER = "learn/avoid_walls.toml"


def sled(**arguments):
    return make_env(text=SLED, **arguments)


def same(a, b):
    """Returns whether two infos, or arrays, are bit-identical."""
    if isinstance(a, dict):
        return isinstance(b, dict) and a.keys() == b.keys() and all(same(a[k], b[k]) for k in a)
    a, b = np.asarray(a), np.asarray(b)
    if a.dtype != b.dtype or a.shape != b.shape:
        return False
    if a.dtype == object:
        return all(x is y is None or same(x, y) for x, y in zip(a.flat, b.flat))
    return a.tobytes() == b.tobytes()


# ---------------------------------------------------------------------------------------------------- with Gymnasium


@pytest.mark.parametrize("arguments", [{"text": SLED}, {"scene": PIONEER}])
def test_checker(arguments):
    env = Env(render_mode="rgb_array", size=(64, 48), **arguments)
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        check_env(env)
    # These warnings are expected: the environment was not created by `gymnasium.make`, and actions have the bounds and
    # units of the property.
    harmless = ("spec", "symmetric and normalized")
    assert [str(w.message) for w in seen if not any(h in str(w.message) for h in harmless)] == []


def test_registered():
    env = gymnasium.make("tatu_sim.gym:Tatu-v0", text=SLED)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        first, _ = env.reset(seed=3)
        assert env.observation_space.contains(env.step(env.action_space.sample())[0])
    env.close()
    vector = gymnasium.make_vec("Tatu-v0", num_envs=2, vectorization_mode="vector_entry_point", text=SLED)
    assert same(vector.reset(seed=3)[0][0], first)
    vector.close()


def test_importing_the_package_does_not_import_gymnasium():
    code = "import sys, tatu_sim; sys.exit('gymnasium' in sys.modules)"
    folder = str(Path(tatu_sim.__file__).resolve().parents[1])
    assert subprocess.run([sys.executable, "-c", code], cwd=folder).returncode == 0


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP, AutoresetMode.DISABLED])
@pytest.mark.parametrize("scene, n", [("sled", 5), ("pioneer", 3)])
def test_vector_equals_sync(mode, scene, n):
    arguments = {"text": SLED} if scene == "sled" else {"scene": PIONEER, "env": {"seconds": 4}}
    # A world with a robot takes long in a build without optimisation.
    steps = 1000 if scene == "sled" or "TATU_LONG" in os.environ else 250
    ours = VectorEnv(num_envs=n, autoreset_mode=mode, **arguments)
    theirs = SyncVectorEnv([lambda: Env(**arguments)] * n, autoreset_mode=mode)
    assert ours.observation_space == theirs.observation_space and ours.action_space == theirs.action_space
    assert ours.metadata == theirs.metadata
    (a, a_info), (b, b_info) = ours.reset(seed=7), theirs.reset(seed=7)
    assert same(a, b) and same(a_info, b_info)
    random = np.random.default_rng(1)
    low, high = ours.action_space.low, ours.action_space.high
    over = episodes = 0
    for step in range(steps):
        # Actions persist for a while, so that some episodes end at the bounds.
        if step % 10 == 0:
            actions = random.uniform(1.2 * low, 1.2 * high).astype(np.float32)
        (a, *a_rest), (b, *b_rest) = ours.step(actions), theirs.step(actions)
        assert same(a, b), step
        for one, other in zip(a_rest, b_rest):
            assert same(one, other), step
        over = a_rest[1] | a_rest[2]
        episodes += int(over.sum())
        if mode is AutoresetMode.DISABLED and over.any():
            (a, a_info), (b, b_info) = (e.reset(options={"reset_mask": over.copy()}) for e in (ours, theirs))
            assert same(a, b) and same(a_info, b_info), step
    assert episodes > 10 * n * steps / 1000
    assert ours.batch.hash() == [e.batch.hash()[0] for e in theirs.envs]
    ours.close()
    theirs.close()


def test_threads_lead_to_the_same_bits():
    def run(threads):
        env = VectorEnv(text=SLED, num_envs=6, threads=threads)
        env.reset(seed=1)
        env.action_space.seed(1)
        for _ in range(60):
            out = env.step(env.action_space.sample())
        hashes = env.batch.hash()
        env.close()
        return hashes, out[0].tobytes()

    assert run(1) == run(2) == run(5)


# ------------------------------------------------------------------------------------------------------------- episodes


def test_seed_decides_everything():
    env = sled()
    env.action_space.seed(0)
    actions = [env.action_space.sample() for _ in range(40)]

    def run(seed):
        first, info = env.reset(seed=seed)
        return [first.tobytes(), info], [env.step(a)[0].tobytes() for a in actions]

    one, other, again = run(1), run(2), run(1)
    assert same(one[0][1], again[0][1]) and one[1] == again[1]
    assert one[0][1]["seed"] != other[0][1]["seed"] and one[1] != other[1]
    # Without a seed, the next episode is different.
    assert env.reset()[1]["seed"] != one[0][1]["seed"]


def test_info_contains_the_drawn_values():
    env = sled()
    _, info = env.reset(seed=5)
    drawn = info["random"]
    assert list(drawn) == list(env._episodes.description.random[i].key for i in range(4))
    assert env.batch.get("/rail/joint/sled", "shape.mass")[0] == drawn["/rail/joint/sled.mass_kg"]
    assert 0.5 <= drawn["/rail/joint/sled.mass_kg"] <= 5.0 and drawn["/rail/joint.max_force_n"] >= 2.0
    np.testing.assert_array_equal(env.batch.get("/wall", "object.position")[0], drawn["/wall.position_m"])
    assert drawn["/wall.color"] in ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0])


def test_changes_for_all_episodes_and_for_one():
    env = sled(set={"/rail/joint/sled.size_m": [0.2, 0.2, 0.2]})
    env.reset(seed=1, options={"set": {"/rail/joint/sled.mass_kg": 2.5}})
    assert env.batch.get("/rail/joint/sled", "shape.mass")[0] == 2.5
    assert env.batch.get("/rail/joint/sled", "shape.size")[0][0] == 0.2
    _, info = env.reset()
    assert env.batch.get("/rail/joint/sled", "shape.mass")[0] == info["random"]["/rail/joint/sled.mass_kg"] != 2.5
    with pytest.raises(ValueError, match="unknown option 'sed'"):
        env.reset(options={"sed": 1})


def test_first_observation_is_measured():
    """A sensor that has not been measured yet reports 0, so `settle` steps are run first."""
    observation, _ = sled(env={"observe": [{"object": "beam", "field": "sensor.measured"}]}).reset(seed=1)
    assert observation[0] == 1
    observation, _ = sled(env={"observe": [{"object": "beam", "field": "sensor.measured"}], "settle": 3}).reset(seed=1)
    assert observation[0] == 3


def test_truncation_after_seconds():
    env = sled(env={"steps": 2, "end": None})
    env.reset(seed=1)
    assert env.dt == pytest.approx(0.1)
    cut = [env.step(np.zeros(1, np.float32))[3] for _ in range(16)]
    assert cut.index(True) == 14


def test_observation_reward_and_end_by_hand():
    forward = {"object": "/rail/joint", "field": "joint.velocity", "weight": 2.0, "above": 0.0}
    env = sled(env={"reward": [forward, {"constant": -0.5}]})
    env.reset(seed=2)
    over = False
    while not over:
        observation, reward, over, cut, _ = env.step(np.array([3.0]))
        position, velocity = (env.batch.get("/rail/joint", f"joint.{k}")[0] for k in ("position", "velocity"))
        assert observation[1] == np.float32(velocity)
        assert reward == (1.5 if velocity > 0 else -0.5)
        assert over == (position > 0.7)
        assert not cut


def test_functions_in_python():
    seen = []

    def reward(obs, act, watch):
        seen.append((obs.shape, act.shape, watch["position"].shape))
        return watch["position"][:, 0] * 10

    def end(obs, act, watch):
        return watch["position"][:, 0] > 0.2

    env = make_vec(text=SLED, num_envs=3, reward=reward, end=end, env={"reward": None, "end": None})
    env.reset(seed=1)
    _, rewards, over, _, _ = env.step(np.full((3, 1), 3.0))
    positions = env.batch.get("/rail/joint", "joint.position")
    np.testing.assert_array_equal(rewards, positions * 10)
    while not over.any():
        over = env.step(np.full((3, 1), 3.0))[2]
    assert seen[0] == ((3, 5), (3, 1), (3, 1))
    env.close()
    env = sled(reward=lambda obs, act, watch: 1.0)
    env.reset(seed=1)
    with pytest.raises(ValueError, match=r"`reward` returned an array of shape \(\)"):
        env.step([0.0])


def test_a_script_that_stops_its_world_ends_the_episode():
    script = 'function sysCall_actuation() if sim.getSimulationTime() > 0.3 then sim.stopSimulation() end end'
    env = make_env(text=SLED + f'\n[[object]]\nkind = "dummy"\nscript = {{ text = "{script}" }}\n')
    env.reset(seed=1)
    over = [env.step([0.0])[2] for _ in range(12)]
    assert True in over and over == sorted(over)
    env.reset()
    assert not env.step([0.0])[2]


def test_calls_out_of_order_raise():
    env = sled()
    with pytest.raises(gymnasium.error.ResetNeeded, match="call `reset`"):
        env.step([0.0])
    env.reset()
    with pytest.raises(ValueError, match="NaN"):
        env.step([np.nan])
    with pytest.raises(ValueError, match=r"the actions have the shape \(2,\); expected \(1,\)"):
        env.step([0.0, 1.0])
    vector = VectorEnv(text=SLED, num_envs=2, autoreset_mode="Disabled", env={"seconds": 0.05})
    vector.reset(seed=1)
    for wrong in (np.zeros((3, 1)), np.zeros((2, 2)), [[0.0], [0.0, 1.0]]):
        with pytest.raises(ValueError, match="the actions"):
            vector.step(wrong)
    vector.step(np.zeros((2, 1)))
    with pytest.raises(gymnasium.error.ResetNeeded, match="world 0 is over"):
        vector.step(np.zeros((2, 1)))
    with pytest.raises(ValueError, match="`reset_mask` must be an array of 2 bools"):
        vector.reset(options={"reset_mask": [True, False]})


def test_render():
    env = sled(render_mode="rgb_array", size=(40, 30))
    env.reset(seed=1)
    before = env.render()
    for _ in range(10):
        env.step([3.0])
    hash_ = env.batch.hash()
    after = env.render()
    assert before.shape == after.shape == (30, 40, 3) and before.dtype == np.uint8
    assert (before != after).any()
    assert env.batch.hash() == hash_
    assert sled().render() is None
    vector = VectorEnv(text=SLED, num_envs=2, render_mode="rgb_array", size=(40, 30))
    vector.reset(seed=1)
    assert (vector.render()[0] == before).all()
    with pytest.raises(ValueError, match="render mode 'human'"):
        sled(render_mode="human")
