"""Kinematics and dynamics of mechanisms, with NumPy arrays."""

import numpy as np
import pytest
import tatu_sim

ARM = 'format = 1\n[[model]]\nmodel = "ur5"\nalias = "arm"\ncontroller = false\n'


@pytest.fixture
def arm():
    with tatu_sim.World(text=ARM) as world:
        base, tip = (int(world.sim.getObject(path)) for path in ("/arm", "/arm/tool0"))
        yield world, base, tip


def test_results_are_arrays_that_obey_the_equations_of_motion(arm):
    world, base, _ = arm
    kin = world.tatu.kin
    random = np.random.default_rng(0)
    q, qd, qdd = random.uniform(-1, 1, (3, 6))
    mass = np.array(kin.massMatrix(base, q))
    assert mass.shape == (6, 6)
    assert np.allclose(mass, mass.T, atol=1e-12)
    bias = np.array(kin.inverseDynamics(base, q, qd))
    forces = np.array(kin.inverseDynamics(base, q, qd, qdd))
    assert np.allclose(forces, mass @ qdd + bias, atol=1e-9)
    assert np.allclose(kin.forwardDynamics(base, forces, q, qd), qdd, atol=1e-9)
    assert np.allclose(kin.gravityTorques(base, q), kin.inverseDynamics(base, q, np.zeros(6)), atol=1e-12)


def test_jacobian_is_the_derivative_of_the_pose(arm):
    world, base, tip = arm
    q = np.array([0.3, -1.2, 1.5, -0.8, 0.9, -0.4])
    jacobian, _ = world.tatu.kin.jacobian(base, tip, q)
    place = lambda q: np.array(world.tatu.kin.jacobian(base, tip, q)[1])[:3]
    h = 1e-6
    for k, column in enumerate(np.array(jacobian).T):
        step = h * np.eye(6)[k]
        assert np.allclose((place(q + step) - place(q - step)) / (2 * h), column[:3], atol=1e-8)


def test_positions_for_a_pose_are_found_or_the_reason_is_returned(arm):
    world, base, tip = arm
    q, joints, reason = world.tatu.kin.ik(tip, [0.4, 0.2, 0.4, 1, 0, 0, 0])
    assert reason is None and len(joints) == 6
    world.tatu.setState(base, q)
    assert np.allclose(world.get("/arm/tool0", "object.world_pose")[:3], [0.4, 0.2, 0.4], atol=2e-6)
    q, _, reason = world.tatu.kin.ik(tip, [2.0, 0.0, 0.4])
    assert q is None and reason["kind"] == "out of reach" and reason["by"] > 1
    with pytest.raises(tatu_sim.Error, match="2 numbers"):
        world.tatu.kin.massMatrix(base, [1.0, 2.0])


def test_linear_model_has_the_derivatives_of_the_accelerations(arm):
    world, base, _ = arm
    joints = world.tatu.kin.joints(base)[0]
    hold = np.array(world.tatu.kin.gravityTorques(base))
    a, b, c, d = (np.array(m) for m in world.tatu.linearize(base, joints, None, {"forces": hold}))
    assert a.shape == (12, 12) and b.shape == (12, 6) and c.shape == (12, 12) and d.shape == (12, 6)
    assert np.allclose(b[6:] @ np.array(world.tatu.kin.massMatrix(base)), np.eye(6), atol=1e-9)
    assert np.allclose(a[:6], np.hstack([np.zeros((6, 6)), np.eye(6)]))
