"""Compares models that Tatu imports from MJCF files with MuJoCo: masses, centres of mass, inertia tensors, the parameters of
joints with their actuators, and the poses of all bodies in random configurations.

    python bench/imports/mjcf_numbers.py [--states 20] [--program tatu] FILE.xml|FOLDER ...

Needs `pip install mujoco numpy` and the package tatu_sim. Files of a folder that MuJoCo cannot compile are skipped, such as
those that other files include. Good sets of files are those of the packages dm_control, gymnasium and gymnasium-robotics
(`pip download --no-deps`, then unpack the wheels).
"""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import tatu_sim

# MuJoCo stores the vertices of meshes in single precision.
EXACT, OF_MESHES = 1e-9, 1e-6


def moved(mass, com, inertia, turn, shift):
    """Returns mass properties in another frame."""
    return mass, turn @ com + shift, turn @ inertia @ turn.T


def total(parts):
    """Returns the mass, centre of mass and inertia about it of rigidly connected parts."""
    mass = sum(m for m, _, _ in parts)
    if mass <= 0:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    com = sum(m * c for m, c, _ in parts) / mass
    about = lambda m, c: m * (((c - com) @ (c - com)) * np.eye(3) - np.outer(c - com, c - com))
    return mass, com, sum(i + about(m, c) for m, c, i in parts)


def matrix(quaternion):
    out = np.zeros(9)
    mujoco.mju_quat2Mat(out, np.asarray(quaternion, float))
    return out.reshape(3, 3)


def groups(model, data):
    """Returns the mass properties of each body with all that is fixed to it, by MuJoCo's number of the first one."""
    parts = {}
    for body in range(1, model.nbody):
        first = body if model.body_weldid[body] == 0 else model.body_weldid[body]
        r, p = data.xmat[first].reshape(3, 3), data.xpos[first]
        turn = r.T @ data.xmat[body].reshape(3, 3)
        shift = r.T @ (data.xpos[body] - p)
        axes = matrix(model.body_iquat[body])
        inertia = axes @ np.diag(model.body_inertia[body]) @ axes.T
        own = moved(model.body_mass[body], model.body_ipos[body], inertia, turn, shift)
        parts.setdefault(first, []).append(own)
    return {first: total(own) for first, own in parts.items()}


def size(x):
    return max(float(np.abs(x).max()), 1e-300)


class Comparison:
    """One file in both programs."""

    def __init__(self, root, file, program):
        self.model = mujoco.MjModel.from_xml_path(str(file))
        self.data = mujoco.MjData(self.model)
        mujoco.mj_kinematics(self.model, self.data)
        done = subprocess.run([program, "check", str(file), "--json"], cwd=root, capture_output=True, text=True)
        if done.returncode != 0:
            raise ValueError(done.stderr.strip().splitlines()[-1] if done.stderr.strip() else "failed")
        self.described = json.loads(done.stdout)
        # Files beside the model may be read from the folder in which a program runs.
        os.chdir(root)
        self.world = tatu_sim.World(str(file))
        self.base = min(self.world.objects, key=lambda path: (path.count("/"), list(self.world.objects).index(path)))
        self.bodies = self.described["bodies"]
        self.numbers = 0
        self.worst = {key: (0.0, "") for key in ("mass", "centre", "inertia", "joint", "pose")}

    def get(self, path, key):
        return np.asarray(self.world.get(self.base + path, key), float)

    def note(self, key, error, name):
        self.numbers += 1
        if not error <= self.worst[key][0]:
            self.worst[key] = (float(error), name)

    def masses(self):
        expected = groups(self.model, self.data)
        for number, body in enumerate(self.bodies):
            path = body["path"]
            if number == 0 or body["fixed_to"] != path or not self.world.get(self.base + path, "shape.dynamic"):
                continue
            parts, above = [], path
            for step in range(body["links"] + 1):
                parts.append((float(self.get(above, "shape.mass")), self.get(above, "shape.com"),
                              self.get(above, "shape.inertia").reshape(3, 3)))
                above = above.rsplit("/", 2)[0]
            found, wanted = total(parts), expected[number]
            self.note("mass", abs(found[0] - wanted[0]) / wanted[0], body["name"])
            self.note("centre", np.abs(found[1] - wanted[1]).max() / max(1.0, size(wanted[1])), body["name"])
            self.note("inertia", np.abs(found[2] - wanted[2]).max() / size(wanted[2]), body["name"])

    def joints(self):
        """Compares limits, armature, friction, and the stiffness and damping of joints together with their actuators."""
        model = self.model
        by_body = {}
        for joint in self.described["joints"]:
            by_body.setdefault(joint["body"], []).append(joint)
        hinges = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
        # What an actuator adds, by joint; joints that tendons drive are not compared.
        stiffness, damping, by_tendons = {}, {}, set()
        for i in range(model.nu):
            kind, on = model.actuator_trntype[i], model.actuator_trnid[i, 0]
            if kind == mujoco.mjtTrn.mjTRN_TENDON:
                at, n = model.tendon_adr[on], model.tendon_num[on]
                by_tendons.update(model.wrap_objid[at:at + n])
            elif kind != mujoco.mjtTrn.mjTRN_JOINT or model.actuator_gaintype[i] != mujoco.mjtGain.mjGAIN_FIXED:
                continue
            elif model.actuator_biastype[i] == mujoco.mjtBias.mjBIAS_AFFINE:
                gear = model.actuator_gear[i, 0]
                stiffness[on] = stiffness.get(on, 0.0) - model.actuator_biasprm[i, 1] * gear**2
                damping[on] = damping.get(on, 0.0) - model.actuator_biasprm[i, 2] * gear**2
        for joint in range(model.njnt):
            if model.jnt_type[joint] not in hinges or joint in by_tendons:
                continue
            body, dof = model.jnt_bodyid[joint], model.jnt_dofadr[joint]
            described = by_body[body][joint - model.body_jntadr[body]]
            own = lambda key: float(self.get(described["path"], f"joint.{key}"))
            wanted = {"armature": model.dof_armature[dof], "dry_friction": model.dof_frictionloss[dof],
                      "stiffness": float(np.ravel(model.jnt_stiffness[joint])[0]) + stiffness.get(joint, 0.0)}
            passive = float(np.ravel(model.dof_damping[dof])[0])
            if self.world.get(self.base + described["path"], "joint.control") == "velocity":
                self.note("joint", abs(1 / own("slip") - damping[joint]) / damping[joint], f"{described['name']}.slip")
                wanted["damping"] = passive
            else:
                wanted["damping"] = passive + damping.get(joint, 0.0)
            for key, value in wanted.items():
                self.note("joint", abs(own(key) - value) / max(1.0, abs(value)), f"{described['name']}.{key}")
            if model.jnt_limited[joint]:
                limits = np.abs(self.get(described["path"], "joint.limits") - model.jnt_range[joint]).max()
                self.note("joint", limits, f"{described['name']}.limits")

    def state(self, random):
        """Sets both to a random configuration."""
        model = self.model
        joints = {joint["name"]: joint for joint in self.described["joints"]}
        by_body = {}
        for joint in self.described["joints"]:
            by_body.setdefault(joint["body"], []).append(joint)
        for joint in range(model.njnt):
            kind, at, body = model.jnt_type[joint], model.jnt_qposadr[joint], model.jnt_bodyid[joint]
            if kind == mujoco.mjtJoint.mjJNT_FREE:
                q = random.normal(size=4)
                pose = np.concatenate([random.uniform(-1, 1, 3), q / np.linalg.norm(q)])
                self.data.qpos[at:at + 7] = pose
                x, y, z, w, i, j, k = map(float, pose)
                self.world.set(self.base + self.bodies[body]["path"], "object.world_pose", [x, y, z, i, j, k, w])
                continue
            path = self.base + by_body[body][joint - model.body_jntadr[body]]["path"]
            if kind == mujoco.mjtJoint.mjJNT_BALL:
                q = random.normal(size=4)
                w, i, j, k = map(float, q / np.linalg.norm(q))
                self.data.qpos[at:at + 4] = [w, i, j, k]
                self.world.set(path, "joint.rotation", [i, j, k, w])
                continue
            low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (-1.0, 1.0)
            # Joints that a constraint holds stay where they are.
            limits = np.asarray(self.world.get(path, "joint.limits"), float)
            q = float(random.uniform(max(low, -10), min(high, 10)))
            q = float(limits[0]) if limits[0] == limits[1] else q
            self.data.qpos[at] = q
            self.world.set(path, "joint.position", q)
        mujoco.mj_kinematics(model, self.data)

    def poses(self, random, states):
        for _ in range(states):
            self.state(random)
            for number, body in enumerate(self.bodies[1:], 1):
                if self.model.body_mocapid[number] >= 0:
                    continue
                pose = self.get(body["path"], "object.world_pose")
                x, y, z, w = pose[3:]
                turn = np.abs(matrix([w, x, y, z]) - self.data.xmat[number].reshape(3, 3)).max()
                shift = np.abs(pose[:3] - self.data.xpos[number]).max() / max(1.0, size(self.data.xpos[number]))
                self.note("pose", max(turn, shift), body["name"])


def files(names):
    for name in [Path(name).resolve() for name in names]:
        if name.is_dir():
            yield from ((name, p) for p in sorted(name.rglob("*.xml")) if b"<mujoco" in p.read_bytes())
        else:
            yield name.parent, name


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--states", type=int, default=20)
    parser.add_argument("--program", default="tatu")
    parser.add_argument("names", nargs="+")
    options = parser.parse_args()
    numbers = 0
    count = {"equal": 0, "different": 0, "refused": 0, "skipped": 0}
    for root, file in files(options.names):
        try:
            compared = Comparison(root, file, options.program)
        except ValueError as error:
            # Files that MuJoCo itself refuses are parts of others, or lack their meshes.
            try:
                mujoco.MjModel.from_xml_path(str(file))
            except ValueError:
                count["skipped"] += 1
                continue
            print(f"refused    {file}: {error}")
            count["refused"] += 1
            continue
        except Exception as error:
            print(f"refused    {file}: {type(error).__name__}: {error}")
            count["refused"] += 1
            continue
        try:
            if len(compared.bodies) != compared.model.nbody:
                raise ValueError(f"{len(compared.bodies)} bodies instead of {compared.model.nbody}")
            compared.masses()
            compared.joints()
            compared.poses(np.random.default_rng(1), options.states)
        except Exception as error:
            print(f"different  {file}: {type(error).__name__}: {error}")
            count["different"] += 1
            continue
        finally:
            compared.world.close()
        numbers += compared.numbers
        within = OF_MESHES if compared.model.nmesh else EXACT
        wrong = {key: (f"{error:.1e}", name) for key, (error, name) in compared.worst.items() if not error <= within}
        if wrong:
            print(f"different  {file}: {wrong}")
        count["different" if wrong else "equal"] += 1
    print(", ".join(f"{n} {what}" for what, n in count.items()) + f"; {numbers} numbers or poses compared")
    sys.exit(1 if count["different"] or count["refused"] else 0)


if __name__ == "__main__":
    main()
