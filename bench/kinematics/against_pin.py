"""Compares `tatu.kin` with Pinocchio: Jacobian, mass matrix, gravity and inverse dynamics in random states.

    python bench/kinematics/against_pin.py [--states 100] [MODEL ...] [FILE.urdf ...]

Needs `pip install pin numpy` and the package tatu_sim. Without names, all models with joints are compared; a URDF file is
read by both programs, such as those of the package example-robot-data.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import tatu_sim
from mechanism import PinMechanism

ROOT = Path(__file__).resolve().parents[2]
TOLERANCE = 1e-9
QUANTITIES = ("jacobian", "mass matrix", "gravity", "inverse dynamics", "forward dynamics")


def relative(found, expected):
    """Returns the greatest difference, as a share of the greatest value if that exceeds 1."""
    return float(np.abs(found - expected).max() / max(1.0, np.abs(expected).max()))


def forward(call, forces, q, v):
    """Returns the accelerations, or None if a joint moves no mass."""
    try:
        return np.array(call("forwardDynamics", list(forces), q, v), float)
    except Exception as error:
        if "moves no mass" in str(error):
            return None
        raise


def compare(name, states):
    """Returns the number of velocities, and the greatest difference of each quantity."""
    text = f'format = 1\n[[model]]\nmodel = "{name}"\nalias = "robot"\n'
    with tatu_sim.World(text=text) as world:
        base = int(world.call("sim.getObject", "/robot"))
        call = lambda command, *rest: world.call(f"tatu.kin.{command}", base, *rest)
        wanted = [int(h) for h in call("joints")[0]]
        own = PinMechanism(world, base)
        model = own.model
        data = model.createData()
        to_q, to_v = own.order(wanted)
        nq, nv = model.nq, model.nv
        # A tip: the last object that moves.
        tip = [h for h, joint in own.carriers.items() if joint][-1]
        frame = model.addFrame(pin.Frame("tip", own.carriers[tip], 0, own.frames[tip], pin.FrameType.OP_FRAME))
        data = model.createData()
        random = np.random.default_rng(1)
        worst = dict.fromkeys(QUANTITIES, 0.0)
        free = [(i, model.joints[i + 1]) for i, kind in enumerate(own.kinds) if kind == "free"]
        for _ in range(states):
            q = pin.randomConfiguration(model, -2 * np.ones(nq), 2 * np.ones(nq))
            v, a = random.uniform(-2, 2, nv), random.uniform(-2, 2, nv)
            # T converts velocities of tatu to those of Pinocchio: a free base moves along the axes of the world there.
            turn, shift = np.eye(nv), np.zeros(nv)
            for _, joint in free:
                r = pin.Quaternion(q[joint.idx_q + 3:][:4]).toRotationMatrix()
                at = joint.idx_v
                turn[at:at + 3, at:at + 3] = r.T
                shift[at:at + 3] = -np.cross(v[at + 3:at + 6], r.T @ v[at:at + 3])
            pv, pa = turn @ v, turn @ a + shift
            pin.computeJointJacobians(model, data, q)
            pin.updateFramePlacements(model, data)
            jacobian = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED).reshape(6, nv) @ turn
            mass = np.triu(pin.crba(model, data, q))
            mass = turn.T @ (mass + np.triu(mass, 1).T) @ turn
            gravity = turn.T @ pin.computeGeneralizedGravity(model, data, q)
            inverse = turn.T @ pin.rnea(model, data, q, pv, pa)
            tq, tv, ta = list(q[to_q]), list(v[to_v]), list(a[to_v])
            found = [np.array(call("jacobian", tip, tq)[0], float), np.array(call("massMatrix", tq), float),
                     np.array(call("gravityTorques", tq), float), np.array(call("inverseDynamics", tq, tv, ta), float),
                     forward(call, inverse[to_v], tq, tv)]
            expected = [jacobian[:, to_v], mass[np.ix_(to_v, to_v)], gravity[to_v], inverse[to_v], a[to_v]]
            for key, x, y in zip(QUANTITIES, found, expected):
                if x is None:
                    worst[key] = float("nan")
                    continue
                worst[key] = max(worst[key], relative(x, y))
    return nv, worst


def compare_urdf(file, states):
    """Returns the same for a file that both programs read; without the Jacobian."""
    with tatu_sim.World(file) as world:
        base = int(world.call("sim.getObject", next(iter(world.objects))))
        owners = [int(h) for h in world.call("tatu.kin.joints", base)[0]]
        free = world.call("tatu.get", owners[0], "object.kind") != "joint"
        model = pin.buildModelFromUrdf(file, pin.JointModelFreeFlyer()) if free else pin.buildModelFromUrdf(file)
        model.gravity.linear = np.array(world.call("tatu.get", 0, "scene.gravity"), float)
        model.armature[:] = 0
        data, random = model.createData(), np.random.default_rng(1)
        alias = lambda h: world.call("tatu.get", h, "object.alias")
        joints = [model.joints[1 if free and i == 0 else model.getJointId(alias(h))] for i, h in enumerate(owners)]
        to_v = np.concatenate([range(j.idx_v, j.idx_v + j.nv) for j in joints])
        worst = dict.fromkeys(QUANTITIES, float("nan"))
        worst |= dict.fromkeys(("mass matrix", "gravity", "inverse dynamics"), 0.0)
        for _ in range(states):
            q = pin.randomConfiguration(model, -2 * np.ones(model.nq), 2 * np.ones(model.nq))
            # Joints without limits have a cosine and a sine there.
            parts = [q[j.idx_q:][:j.nq] for j in joints]
            tq = np.concatenate([[np.arctan2(p[1], p[0])] if len(p) == 2 else p for p in parts])
            v, a = random.uniform(-2, 2, (2, model.nv))
            turn, shift = np.eye(model.nv), np.zeros(model.nv)
            if free:
                r = pin.Quaternion(q[3:7]).toRotationMatrix()
                turn[:3, :3], shift[:3] = r.T, -np.cross(v[3:6], r.T @ v[:3])
            mass = np.triu(pin.crba(model, data, q))
            mass = turn.T @ (mass + np.triu(mass, 1).T) @ turn
            expected = [mass[np.ix_(to_v, to_v)], (turn.T @ pin.computeGeneralizedGravity(model, data, q))[to_v],
                        (turn.T @ pin.rnea(model, data, q, turn @ v, turn @ a + shift))[to_v]]
            call = lambda command, *rest: np.array(world.call(f"tatu.kin.{command}", base, tq, *rest), float)
            found = [call("massMatrix"), call("gravityTorques"), call("inverseDynamics", v[to_v], a[to_v])]
            for key, x, y in zip(("mass matrix", "gravity", "inverse dynamics"), found, expected):
                worst[key] = max(worst[key], relative(x, y))
    return model.nv, worst


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--states", type=int, default=100)
    parser.add_argument("models", nargs="*")
    options = parser.parse_args()
    names = options.models or sorted(p.parent.name for p in ROOT.glob("models/*/model.toml"))
    print(f"{'model':20}{'velocities':>11}" + "".join(f"{key:>18}" for key in QUANTITIES))
    failed = []
    for name in names:
        try:
            count, worst = (compare_urdf if name.endswith(".urdf") else compare)(name, options.states)
        except Exception as error:
            if "has no joint below it" in str(error) or "is a screw" in str(error):
                if options.models:
                    print(f"{name:20} {error}")
                continue
            print(f"{name:20} {type(error).__name__}: {error}")
            failed.append(name)
            continue
        name = Path(name).stem
        print(f"{name:20}{count:>11}" + "".join(f"{worst[key]:>18.1e}" for key in QUANTITIES))
        if any(worst[key] > TOLERANCE for key in QUANTITIES[:4]):
            failed.append(name)
    sys.exit(f"greater than {TOLERANCE}: {', '.join(failed)}" if failed else 0)


if __name__ == "__main__":
    main()
