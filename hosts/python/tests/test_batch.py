"""Tests of batches: many worlds that are stepped together."""

import numpy as np
import pytest
from conftest import PIONEER

import tatu_sim

ROBOT = "/Pioneer_p3dx"


def test_the_same_bits_for_any_number_of_threads_and_as_alone():
    hashes = []
    for threads in (1, 2, 3):
        with tatu_sim.Batch(PIONEER, 5, seeds=range(5), threads=threads) as batch:
            batch.step(n=20)
            batch.step(n=10)
            hashes.append(batch.hash())
    assert hashes[0] == hashes[1] == hashes[2]
    with tatu_sim.World(PIONEER, seed=3) as world:
        world.step(30)
        assert world.hash == hashes[0][3]


def test_observations_and_actions_are_rows(falling):
    observe = [("/ball", "object.world_pose"), ("", "scene.time")]
    with tatu_sim.Batch(text=falling, n=3, set={"/ball.position_m": [[0, 0, z] for z in (1.0, 2.0, 3.0)]},
                        observe=observe, act=[("/ball", "object.world_pose")]) as batch:
        assert batch.shapes == ([(7,), ()], [(7,)])
        assert batch.observations[:, 2].tolist() == [1.0, 2.0, 3.0]
        seen = batch.step(n=4)
        assert seen.shape == (3, 8) and np.allclose(seen[:, 7], 4 * batch.dt)
        assert np.allclose(np.diff(seen[:, 2]), 1.0)
        back = np.tile([0, 0, 5.0, 0, 0, 0, 1], (3, 1))
        assert (batch.step(back)[:, 2] < 5.0).all() and (batch.observations[:, 2] > 4.8).all()
        with pytest.raises(ValueError):
            batch.step(back[:2])


def test_some_worlds_are_stepped_and_reset(falling):
    with tatu_sim.Batch(text=falling, n=3, observe=[("/ball", "object.world_pose")]) as batch:
        batch.step(n=5, worlds=[True, False, True])
        assert np.allclose(batch.times, [5 * batch.dt, 0, 5 * batch.dt])
        batch.reset([0], sets=[{"/ball.position_m": [0, 0, 7.0]}])
        heights = batch.observations[:, 2]
        assert heights[0] == 7.0 and heights[1] == 1.0 and heights[2] < 1.0
        batch.reset()
        assert batch.observations[0, 2] == 7.0 and batch.observations[2, 2] == 1.0
        with pytest.raises(IndexError):
            batch.reset([3])
        with pytest.raises(tatu_sim.Error, match="world 1"):
            batch.reset([1], sets=[{"/nothing.position_m": [0, 0, 0]}])


def test_worlds_are_forked():
    with tatu_sim.Batch(PIONEER, 3) as batch:
        batch.step(n=10, worlds=[True, False, False])
        assert len(set(batch.hash())) == 2
        batch.fork(0)
        assert len(set(batch.hash())) == 1
        batch.step(n=10)
        assert len(set(batch.hash())) == 1


def test_properties_of_all_worlds():
    with tatu_sim.Batch(PIONEER, 2) as batch:
        motor = "/Pioneer_p3dx/Pioneer_p3dx_leftMotor"
        batch.set(motor, "joint.target_velocity", [1.0, 2.0])
        assert batch.get(motor, "joint.target_velocity").tolist() == [1.0, 2.0]
        assert batch.get(ROBOT, "object.world_pose").shape == (2, 7)
        with pytest.raises(tatu_sim.Error, match="one for each world"):
            batch.set(motor, "joint.target_velocity", [1.0])


def test_wrong_batches_are_refused_with_the_expected_value(falling):
    for wrong, text in (
        ({"n": 0}, "at least 1"),
        ({"n": 2, "seeds": [1]}, "1 seeds"),
        ({"n": 3, "set": {"/ball.position_m": [[0, 0, 1], [0, 0, 2]]}}, "expected 3 values, one per world"),
    ):
        with pytest.raises(ValueError, match=text):
            tatu_sim.Batch(text=falling, **wrong)
    with pytest.raises(tatu_sim.Error, match="no object `/bal`"):
        tatu_sim.Batch(text=falling, n=2, observe=[("/bal", "object.world_pose")])
    with pytest.raises(tatu_sim.Error):
        tatu_sim.Batch(text="format = 2", n=2)
    with pytest.raises(ValueError, match="`threads`"):
        tatu_sim.Batch(text=falling, n=2, threads=0)


def test_actions_are_never_reshaped():
    motors = [(f"Pioneer_p3dx_{side}Motor", "joint.target_velocity") for side in ("left", "right")]
    with tatu_sim.Batch("learn/avoid_walls.toml", 4, act=motors) as batch:
        batch.step(np.ones((4, 2)))
        for wrong in (np.ones((2, 4)), np.ones(8), np.ones((3, 2)), 1.0):
            with pytest.raises(ValueError, match=r"expected \(4, 2\), one row per world"):
                batch.step(wrong)
        with pytest.raises(ValueError, match="array of numbers"):
            batch.step([[1.0, 2.0], [1.0]])


def test_a_reset_preserves_the_shapes_of_observations():
    scene = "first/pioneer_looks_around.toml"
    with tatu_sim.World(scene) as world:
        scanner = next(path for path in world.sensors if path.endswith("/scanner"))
    with tatu_sim.Batch(scene, 2, observe=[(scanner, "range_scan.distance")]) as batch:
        with pytest.raises(tatu_sim.Error, match="different shapes"):
            batch.reset([1], sets=[{"scanner.preset": "velodyne_vlp16"}])
        shape = batch.step().shape
        batch.reset([1], sets=[{}])
        assert batch.step().shape == shape
