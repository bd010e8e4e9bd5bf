"""Runs a scene in Tatu or in MuJoCo, and returns the motion of bodies and the cost of a simulated second."""

import json
import math
import subprocess
import tempfile
import time
from pathlib import Path

import mujoco
import numpy as np

import scenes

SAMPLE = 0.05


class Trace:
    """Position, orientation (x y z w), velocity of the centre of mass and angular velocity, in the world frame."""

    def __init__(self, names):
        self.t, self.cost = [], math.nan
        self.data = {n: [] for n in names}

    def of(self, name, what):
        return np.array([s[("at", "q", "v", "w").index(what)] for s in self.data[name]])


def tatu(program, scene, seconds, dt, substeps, names, solver="auto"):
    trace = Trace(names)
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "s.toml").write_text(scenes.toml(scene, dt, substeps, solver))
        watch = [a for n in names for a in ("--watch", scene.path(n))]
        run = [program, "run", "s.toml", "--json", "--threads", "1", "--seconds", str(seconds)]
        subprocess.run([*run, "--trace", "t.jsonl", *watch], cwd=folder, check=True, capture_output=True)
        for line in Path(folder, "t.jsonl").read_text().splitlines():
            line = json.loads(line)
            if line.get("stopping"):
                continue
            trace.t.append(line["time"])
            for n in names:
                o = line["objects"][scene.path(n)]
                trace.data[n].append((o["position"], o["quaternion"], o["linear_velocity"], o["angular_velocity"]))
        plain = json.loads(subprocess.run(run, cwd=folder, check=True, capture_output=True).stdout)
        trace.cost = plain["wall_s"] / seconds
    return trace


def of_mujoco(scene, seconds, dt, tuned, names):
    model = mujoco.MjModel.from_xml_string(scenes.mjcf(scene, dt, tuned))
    data = mujoco.MjData(model)
    for b in scene.bodies:
        joint = model.body(b.name).jntadr[0]
        if not b.parent and not b.fixed and joint >= 0:
            dof = model.jnt_dofadr[joint]
            data.qvel[dof:dof + 3], data.qvel[dof + 3:dof + 6] = b.v, b.w
    for i in range(model.nu):
        j = scene.of(model.joint(model.actuator(i).trnid[0]).name.removesuffix("_joint")).joint
        data.ctrl[i] = j.get("hold", j.get("force"))
    trace = Trace(names)
    steps = round(SAMPLE / dt)
    spent = 0.0
    for k in range(round(seconds / SAMPLE)):
        before = time.perf_counter()
        mujoco.mj_step(model, data, steps)
        spent += time.perf_counter() - before
        mujoco.mj_forward(model, data)
        trace.t.append((k + 1) * SAMPLE)
        for n in names:
            body = model.body(n).id
            v = np.zeros(6)
            mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, body, v, 0)
            w, x, y, z = data.xquat[body]
            trace.data[n].append((data.xipos[body].copy(), (x, y, z, w), v[3:], v[:3]))
    trace.cost = spent / seconds
    return trace
