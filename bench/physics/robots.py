"""Measures the processor time of a physics step of 5 ms in Tatu and MuJoCo, for robots of public URDF files at rest.

    pip install mujoco numpy && pip install --no-deps example-robot-data
    python3 bench/physics/robots.py [PROGRAM ...]

Every PROGRAM is run with both solvers (`reduced`, and `auto`, which chooses trees), alternately with MuJoCo and three
times. The minimum time of each is used. Joints hold their targets, which are 0 or the nearest position within their
limits, in MuJoCo by a spring with `kp` = 10 times the torque limit and `kv` equal to the limit.
"""

import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import mujoco

DT, SECONDS = 0.005, 24.0
SOLVERS = ("reduced", "auto")
# File, whether the base floats, height of the root, m.
ROBOTS = {
    "UR5": ("ur_description/urdf/ur5_robot.urdf", False, 0.0),
    "xArm7": ("xarm_description/urdf/xarm7.urdf", False, 0.0),
    "Go1": ("go1_description/urdf/go1.urdf", True, 0.45),
    "G1": ("g1_description/urdf/g1_29dof_rev_1_0.urdf", True, 0.8),
    "G1 with hands": ("g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf", True, 0.8),
    "Talos": ("talos_data/robots/talos_reduced.urdf", True, 1.1),
}


def share():
    return sorted(Path(sys.prefix).glob("lib/python3*/site-packages/cmeel.prefix/share"))[0]


def tatu(program, solver, file, floats, height):
    """Returns the time of a step, µs, from the difference of two runs, which excludes the time to load the scene."""
    scene = f"""format = 1
[scene]
joint_solver = "{solver}"
[[object]]
kind = "shape"
alias = "floor"
primitive = "plane"
respondable = true
[[import]]
file = "{file}"
position_m = [0, 0, {height}]
package_root = "{share()}"
fixed_base = {str(not floats).lower()}
motors = "position"
"""
    spent = []
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "s.toml").write_text(scene)
        for seconds in (SECONDS / 4, SECONDS):
            run = [program, "run", str(Path(folder, "s.toml")), "--json", "--threads", "1", "--seconds", str(seconds)]
            before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
            # Tatu reads meshes only in the working directory and its subdirectories.
            subprocess.run(run, cwd=share(), check=True, capture_output=True)
            spent.append(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before)
    return (spent[1] - spent[0]) / (SECONDS * 3 / 4 / DT) * 1e6


def of_mujoco(file, floats, height):
    text = Path(file).read_text()
    for tag in ("gazebo", "transmission"):
        text = re.sub(rf"<{tag}\b[^>]*/>", "", text)
        text = re.sub(rf"<{tag}\b.*?</{tag}>", "", text, flags=re.S)
    # MuJoCo cannot read `.dae` files, so these meshes are removed from the file.
    text = re.sub(r"<(visual|collision)\b(?:(?!</\1>).)*\.dae(?:(?!</\1>).)*</\1>", "", text, flags=re.S)
    text = re.sub(r"<visual\b.*?</visual>", "", text, flags=re.S)
    text = text.replace("package://", f"{share()}/")
    options = '<compiler strippath="false" balanceinertia="true" boundmass="0.001" boundinertia="1e-7"/>'
    text = re.sub(r"(<robot[^>]*>)", rf"\1<mujoco>{options}</mujoco>", text, count=1)
    spec = mujoco.MjSpec.from_string(text)
    spec.option.timestep = DT
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1])
    spec.worldbody.first_body().pos[2] += height
    # Links of one robot pass through each other, as in Tatu.
    for geom in spec.geoms:
        plane = geom.type == mujoco.mjtGeom.mjGEOM_PLANE
        geom.contype, geom.conaffinity = (1, 2) if plane else (2, 1)
    if floats:
        spec.worldbody.first_body().add_freejoint()
    held = {}
    for joint in spec.joints:
        if joint.type == mujoco.mjtJoint.mjJNT_FREE:
            continue
        limit = float(max(abs(joint.actfrcrange[0]), abs(joint.actfrcrange[1]))) or 100.0
        motor = spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_position(kp=10 * limit, kv=limit)
        motor.forcerange, motor.forcelimited = [-limit, limit], 1
        low, high = joint.range
        held[joint.name] = min(max(0.0, low), high) if high > low else 0.0
    model = spec.compile()
    data = mujoco.MjData(model)
    for i in range(model.nu):
        data.ctrl[i] = held[model.actuator(i).name]
    half = round(SECONDS / 2 / DT)
    mujoco.mj_step(model, data, half)
    before = time.process_time()
    mujoco.mj_step(model, data, half)
    return (time.process_time() - before) / half * 1e6


def main():
    programs = sys.argv[1:] or ["target/release/tatu"]
    programs = [str(Path(p).resolve()) for p in programs]
    runs = [(p, s) for p in programs for s in SOLVERS]
    names = [f"{p if len(programs) > 1 else 'Tatu'}, {s}" for p, s in runs]
    print("| robot | MuJoCo, µs |", " | ".join(f"{name}, µs | ratio" for name in names), "|")
    print("|---|---:|" + "---:|---:|" * len(runs))
    for name, (file, floats, height) in ROBOTS.items():
        file = share() / "example-robot-data/robots" / file
        times = []
        for _ in range(3):
            times.append([of_mujoco(file, floats, height), *(tatu(*r, file, floats, height) for r in runs)])
        peer, *own = [min(column) for column in zip(*times)]
        print(f"| {name} | {peer:.1f} |", " | ".join(f"{t:.1f} | {peer / t:.3f}" for t in own), "|")


if __name__ == "__main__":
    main()
