"""The description of an environment; these tests need no Gymnasium."""

import numpy as np
import pytest

from sled import SLED
from tatu_sim._env import describe
from tatu_sim._episodes import Episodes, reduced


@pytest.mark.parametrize("how", ["first", "min", "max", "sum", "mean", "norm"])
@pytest.mark.parametrize("k", [1, 2, 3, 7, 8, 9, 16, 127, 129, 640])
def test_a_row_does_not_depend_on_others(how, k):
    x = np.random.default_rng(k).normal(size=(67, k)) * 1e3
    whole = reduced(x, how)
    for n in (1, 2, 5, 64):
        assert reduced(x[:n].copy(), how).tobytes() == whole[:n].tobytes()


BEAM = {"object": "beam", "field": "proximity.distance"}
JOINT = {"object": "/rail/joint", "field": "joint.target_velocity", "low": -1, "high": 1}


@pytest.mark.parametrize(
    "env, message",
    [
        ({"stepz": 1}, r"\[env\]: unknown key `stepz`; .*did you mean `steps`\?"),
        ({"steps": 0}, r"\[env\] steps: expected an integer, at least 1, found 0"),
        ({"seconds": -1}, r"\[env\] seconds: -1 is not a duration"),
        ({"observe": []}, r"`observe` is missing or empty"),
        ({"observe": [BEAM, {**BEAM, "filed": "x"}]}, r"observe\[1\]: unknown key `filed`; .*did you mean `field`\?"),
        ({"observe": [{"object": "beam"}]}, r"observe\[0\]: `field` is missing"),
        ({"observe": [{"field": "x"}]}, r"observe\[0\]: `object` must be the path of an object"),
        ({"observe": {"object": "beam"}}, r"observe: expected a list of tables"),
        ({"observe": [{**BEAM, "low": 2, "high": 1}]}, r"observe\[0\]: `low` 2 is not below `high` 1"),
        ({"observe": [{**BEAM, "reduce": "avg"}]}, r"observe\[0\] reduce: expected `first`, .* found 'avg'"),
        ({"observe": [{**BEAM, "index": 1}]}, r"observe\[0\] index: `proximity.distance` of `beam` is a single value"),
        ({"observe": [{**BEAM, "object": "beem"}]}, r"observe\[0\]: there is no object `beem`; did you mean `beam`\?"),
        ({"observe": [{**BEAM, "field": "proximity.distanze"}]}, r"observe\[0\]: .*proximity.distanze"),
        ({"act": [{"object": "/rail/joint", "field": "joint.target_velocity"}]}, r"act\[0\]: `low` is missing"),
        ({"act": [{**JOINT, "field": "joint.velocity"}]}, r"act\[0\]: .*joint.velocity"),
        ({"act": [{**JOINT, "object": "beam", "field": "proximity.distance"}]}, r"act\[0\]: .*cannot be set"),
        ({"reward": [{"weight": 1}]}, r"reward\[0\]: expected one of `object`"),
        ({"reward": [{"constant": 1, "above": 2}]}, r"reward\[0\]: `above` does not belong to `constant`"),
        ({"reward": [{"action": "norm", "index": 3}]}, r"reward\[0\] index: the size of an action is 1"),
        ({"reward": [{"object": "sled", "field": "object.pose"}]}, r"reward\[0\]: `object.pose` has 7 values"),
        ({"end": [BEAM]}, r"end\[0\]: expected `above` or `below`"),
        ({"random": {"x": 3}}, r'\[env.random\] "x": expected a distribution'),
        ({"random": {"x": {"uniform": [2, 1]}}}, r'\[env.random\] "x" uniform: 2 is above 1'),
        ({"random": {"x": {"uniform": [[1, 2], [3]]}}}, r"both values must have the same size, but have 2 and 1"),
        ({"random": {"x": {"unform": [1, 2]}}}, r"unknown key `unform`; .*did you mean `uniform`\?"),
        ({"random": {"x": {"log_uniform": [0, 2]}}}, r"expected bounds above 0"),
        ({"random": {"x": {"choice": []}}}, r"expected a list with the values"),
        ({"random": {"x": {"uniform": [1, 2], "low": 0}}}, r"are only allowed with `normal`"),
        ({"random": {"/wall.mas_kg": {"uniform": [1, 2]}}}, r"\[env.random\]: .*mas_kg"),
        ({"random": {"/wal.mass_kg": {"uniform": [1, 2]}}}, r"\[env.random\]: .*/wal"),
    ],
)
def test_errors_name_the_place(env, message):
    with pytest.raises(ValueError, match=message):
        Episodes(1, text=SLED, env=env)


def test_a_scene_without_description():
    with pytest.raises(ValueError, match=r"the scene has no table \[env\]"):
        Episodes(1, "first/pioneer_avoids_walls.toml")


def test_distributions():
    kinds = {
        "uniform": {"uniform": [-1.0, 3.0]},
        "several": {"uniform": [[0.0, 10.0], [1.0, 11.0]]},
        "log_uniform": {"log_uniform": [0.1, 10.0]},
        "normal": {"normal": [5.0, 2.0]},
        "clipped": {"normal": [0.0, 5.0], "low": -1.0, "high": 1.0},
        "integers": {"integers": [1, 3]},
        "choice": {"choice": ["a", "b"]},
    }
    base = {"observe": [BEAM], "act": [JOINT], "random": kinds}
    draws = describe(base).random
    random = np.random.default_rng(0)
    values = {d.key: [d.draw(random) for _ in range(2000)] for d in draws}
    assert -1 <= min(values["uniform"]) and max(values["uniform"]) < 3 and abs(np.mean(values["uniform"]) - 1) < 0.1
    several = np.array(values["several"])
    assert several.shape == (2000, 2) and (several[:, 1] >= 10).all() and (several[:, 0] < 1).all()
    assert 0.1 <= min(values["log_uniform"]) and abs(np.mean(np.log(values["log_uniform"]))) < 0.1
    assert abs(np.mean(values["normal"]) - 5) < 0.2 and abs(np.std(values["normal"]) - 2) < 0.2
    assert min(values["clipped"]) == -1 and max(values["clipped"]) == 1
    assert set(values["integers"]) == {1, 2, 3} and set(values["choice"]) == {"a", "b"}
    assert all(type(v) in (float, int, str, np.ndarray) for vs in values.values() for v in vs)


def test_missing_readings_are_replaced():
    """A proximity sensor reports 0 if it detects nothing; a lost element of a scan is NaN or infinite."""
    env = {"observe": [BEAM, {**BEAM, "zero": 7.0, "high": 5.0}], "random": None}
    with Episodes(2, text=SLED, env=env) as episodes:
        episodes.begin([0, 1], [np.random.default_rng(1)] * 2, {"/wall.position_m": [9.0, 0.0, 0.3]})
        assert episodes.observe().tolist() == [[0.0, 5.0]] * 2
        observer = episodes._observe
        assert observer(np.full((1, episodes.batch.observe_size), np.nan), True).tolist() == [[0.0, 5.0]]
        assert observer(np.full((1, episodes.batch.observe_size), np.inf), False).tolist() == [[np.inf, 5.0]]


def test_bounds_of_observations():
    entries = [{**BEAM, "low": 0.0, "high": 2.0, "offset": -2.0, "scale": -0.5}, BEAM, {**BEAM, "low": -1.0}]
    with Episodes(1, text=SLED, env={"observe": entries}) as episodes:
        low, high = episodes.observe_bounds
        assert low.tolist() == [0.0, -np.inf, -1.0] and high.tolist() == [1.0, np.inf, np.inf]
        assert low.dtype == np.float32
