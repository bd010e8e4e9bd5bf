"""Measures the processor time of a physics step of 5 ms in Tatu and MuJoCo, for robots of public URDF files that stand,
or hold a pose, and for a chain of 20 links.

    pip install mujoco numpy && pip install --no-deps example-robot-data
    python3 bench/physics/robots.py [PROGRAM ...]

Every PROGRAM is run with both solvers (`reduced`, and `auto`, which chooses trees), alternately with MuJoCo and three
times. The minimum time of each is used. Joints start at a pose and hold it, in MuJoCo by a spring with `kp` = 10 times the
torque limit and `kv` equal to the limit. If the height of the watched link has changed by more than 5 cm at the end,
the robot has not held its pose, for example because it fell; this is an error, since its time would be meaningless.
"""

import math
import re
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy

DT, SECONDS = 0.005, 24.0
SOLVERS = ("reduced", "auto")
# Largest change of the height of the watched link, m.
WITHIN = 0.05


@dataclass
class Robot:
    file: str  # in the folder of robots, or the text of the file
    floats: bool
    height: float  # of the root, m
    watched: str  # the link whose height is checked
    pose: dict = field(default_factory=dict)  # positions by the ends of the names of joints, rad; 0 for others


def standing(hip, knee):
    """Returns the pose of a humanoid with level feet. The hips are bent so that its centre of mass is above the ankles:
    MuJoCo's springs yield, so a robot that leans forward falls."""
    return {"hip_pitch_joint": hip, "knee_joint": knee, "ankle_pitch_joint": -hip - knee}


def chain(count=20):
    """Returns the URDF file of the chain of `cases.py`: links of 0.1 m and 0.1 kg, and a load of 10 kg."""
    def link(name, mass, inertia):
        moments = " ".join(f'{axis}="{inertia}"' for axis in ("ixx", "iyy", "izz"))
        z = -0.05 if name != "base" else 0
        return (f'<link name="{name}"><inertial><origin xyz="0 0 {z}"/><mass value="{mass}"/>'
                f'<inertia {moments} ixy="0" ixz="0" iyz="0"/></inertial></link>')

    def joint(i, parent):
        limit = '<limit lower="-3" upper="3" effort="100" velocity="10"/>'
        axis = "1 0 0" if i % 2 == 0 else "0 1 0"
        return (f'<joint name="j{i}" type="revolute"><parent link="{parent}"/><child link="l{i}"/>'
                f'<origin xyz="0 0 {-0.1 if i else 0}"/><axis xyz="{axis}"/>{limit}</joint>')

    last = count - 1
    links = "".join(link(f"l{i}", 0.1, 1e-4) for i in range(last)) + link(f"l{last}", 10, 0.01)
    joints = "".join(joint(i, f"l{i - 1}" if i else "base") for i in range(count))
    return f'<robot name="chain">{link("base", 1, 0.01)}{links}{joints}</robot>'


ROBOTS = {
    # Both arms are bent forward, so all joints carry weight, and no link is near the floor.
    "UR5": Robot("ur_description/urdf/ur5_robot.urdf", False, 0.0, "wrist_3_link",
                 {"shoulder_lift_joint": -1.2, "elbow_joint": 1.0, "wrist_1_joint": -1.4, "wrist_2_joint": -1.57}),
    "xArm7": Robot("xarm_description/urdf/xarm7.urdf", False, 0.0, "link7",
                   {"joint2": -0.3, "joint4": 0.9, "joint6": 1.2}),
    # The pose `standing` of go1.srdf.
    "Go1": Robot("go1_description/urdf/go1.urdf", True, 0.28, "base",
                 {"thigh_joint": 0.8, "calf_joint": -1.853}),
    "G1": Robot("g1_description/urdf/g1_29dof_rev_1_0.urdf", True, 0.785, "pelvis", standing(-0.2, 0.3)),
    "G1 with hands": Robot("g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf", True, 0.785, "pelvis",
                           standing(-0.22, 0.3)),
    # The legs of the pose `half_sitting` of talos.srdf.
    "Talos": Robot("talos_data/robots/talos_reduced.urdf", True, 1.02, "base_link",
                   {"leg_left_3_joint": -0.411354, "leg_left_4_joint": 0.859395, "leg_left_5_joint": -0.448041,
                    "leg_right_3_joint": -0.411354, "leg_right_4_joint": 0.859395, "leg_right_5_joint": -0.448041}),
    # The fingers of both hands, 22 joints, mimic one joint each.
    "Romeo": Robot("romeo_description/urdf/romeo.urdf", False, 1.2, "l_wrist",
                   {"ShoulderPitch": 0.6, "LElbowRoll": -0.8, "RElbowRoll": 0.8}),
    "Tiago": Robot("tiago_description/robots/tiago.urdf", False, 0.1, "arm_7_link",
                   {"arm_1_joint": 0.5, "arm_2_joint": 0.3, "arm_4_joint": 1.2}),
    "chain of 20": Robot(chain(), False, 3.0, "l19", {"j0": 0.1}),
}


def path_of(robot, folder):
    """Returns the path of a file with the robot in a folder. It lacks the elements for Gazebo, such as cameras, whose
    images Tatu would render."""
    text = robot.file
    if not text.startswith("<"):
        text = (share() / "example-robot-data/robots" / robot.file).read_text()
    path = Path(folder, "robot.urdf")
    path.write_text(without("gazebo", text))
    return path


def without(tag, text):
    """Returns a text without the elements of a kind."""
    text = re.sub(rf"<{tag}\b[^>]*/>", "", text)
    return re.sub(rf"<{tag}\b.*?</{tag}>", "", text, flags=re.S)


def mimics(file):
    """Returns, for each joint that mimics another, that joint, the multiplier and the offset."""
    found = {}
    for joint in ElementTree.parse(file).getroot().iter("joint"):
        mimic = joint.find("mimic")
        if mimic is not None and joint.get("type") != "fixed":
            values = float(mimic.get("multiplier", 1)), float(mimic.get("offset", 0))
            found[joint.get("name")] = (mimic.get("joint"), *values)
    return found


class Fallen(Exception):
    pass


def check(who, start, end):
    if not abs(end - start) <= WITHIN:
        raise Fallen(f"{who}: the watched link ends at a height of {end:.3f} m instead of {start:.3f} m")


def position(robot, joint, low, high):
    """Returns the position at which a joint starts and that it holds: that of the pose, or 0, within its limits."""
    wanted = next((x for end, x in robot.pose.items() if joint.endswith(end)), 0.0)
    return min(max(wanted, low), high)


def share():
    return sorted(Path(sys.prefix).glob("lib/python3*/site-packages/cmeel.prefix/share"))[0]


def joints(file):
    """Yields name, limits and type of each joint of a URDF file that is neither fixed nor a mimic of another."""
    for joint in ElementTree.parse(file).getroot().iter("joint"):
        if joint.get("type") in ("revolute", "continuous", "prismatic") and joint.find("mimic") is None:
            limit = joint.find("limit")
            range_of = (float(limit.get("lower", 0)), float(limit.get("upper", 0))) if limit is not None else (0, 0)
            unlimited = joint.get("type") == "continuous"
            yield joint.get("name"), *((-math.inf, math.inf) if unlimited else range_of), joint.get("type")


def scene_text(solver, file, robot):
    """Returns a scene with the robot on a floor, which prints the height of the watched link at its end."""
    # The body of the root link has the name of the robot.
    link = ElementTree.parse(file).getroot().get("name") if robot.floats else robot.watched
    held = "".join(
        f'"{name}.{key}_{"m" if kind == "prismatic" else "rad"}" = {float(position(robot, name, low, high))}\n'
        for name, low, high, kind in joints(file) for key in ("joint_position", "target_position"))
    return f"""format = 1
[scene]
joint_solver = "{solver}"
[set]
{held}
[[object]]
kind = "shape"
alias = "floor"
primitive = "plane"
respondable = true
[[import]]
file = "{file}"
position_m = [0, 0, {robot.height}]
package_root = "{share()}"
fixed_base = {str(not robot.floats).lower()}
motors = "position"
[[object]]
kind = "dummy"
alias = "measure"
[object.script]
text = "function sysCall_cleanup() print('height', sim.getObjectPosition(sim.getObjectHandle('{link}'), -1)[3]) end"
"""


def tatu(program, solver, file, robot, expected):
    """Returns the time of a step, µs, from the difference of two runs, which excludes the time to load the scene."""
    spent = []
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "s.toml").write_text(scene_text(solver, file, robot))
        for seconds in (SECONDS / 4, SECONDS):
            run = [program, "run", str(Path(folder, "s.toml")), "--json", "--threads", "1", "--seconds", str(seconds)]
            before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
            # Tatu reads meshes only in the working directory and its subdirectories.
            done = subprocess.run(run, cwd=share(), check=True, capture_output=True, text=True)
            check(f"Tatu, {solver}", expected, float(re.search(r"height\s+(\S+)", done.stderr)[1]))
            spent.append(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before)
    return (spent[1] - spent[0]) / (SECONDS * 3 / 4 / DT) * 1e6


def model_of(file, robot):
    """Returns the robot as a model of MuJoCo, the data at its start, and the name of the watched body."""
    text = without("transmission", Path(file).read_text())
    # MuJoCo cannot read `.dae` files, so these meshes are removed from the file.
    text = re.sub(r"<(visual|collision)\b(?:(?!</\1>).)*\.dae(?:(?!</\1>).)*</\1>", "", text, flags=re.S)
    text = re.sub(r"<visual\b.*?</visual>", "", text, flags=re.S)
    text = text.replace("package://", f"{share()}/")
    options = '<compiler strippath="false" balanceinertia="true" boundmass="0.001" boundinertia="1e-7"/>'
    text = re.sub(r"(<robot[^>]*>)", rf"\1<mujoco>{options}</mujoco>", text, count=1)
    spec = mujoco.MjSpec.from_string(text)
    geared = mimics(file)
    spec.option.timestep = DT
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1])
    spec.worldbody.first_body().pos[2] += robot.height
    # Links of one robot pass through each other, as in Tatu.
    for geom in spec.geoms:
        plane = geom.type == mujoco.mjtGeom.mjGEOM_PLANE
        geom.contype, geom.conaffinity = (1, 2) if plane else (2, 1)
    for body in spec.bodies:
        # Antennas of Tiago have an inertia with a negative moment, which MuJoCo refuses.
        xx, yy, zz, xy, xz, yz = body.fullinertia
        moments, axes = numpy.linalg.eigh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) if xx == xx else ([1], None)
        if min(moments) <= 0:
            least = (axes * numpy.maximum(moments, 1e-7)) @ axes.T
            body.fullinertia = [*numpy.diag(least), least[0, 1], least[0, 2], least[1, 2]]
    root = spec.worldbody.first_body().name
    if robot.floats:
        spec.worldbody.first_body().add_freejoint()
    held = {}
    for joint in spec.joints:
        if joint.type == mujoco.mjtJoint.mjJNT_FREE:
            continue
        if joint.name in geared:
            leader, ratio, offset = geared[joint.name]
            gear = spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, name1=joint.name, name2=leader)
            gear.data[:2] = [offset, ratio]
            continue
        limit = float(max(abs(joint.actfrcrange[0]), abs(joint.actfrcrange[1]))) or 100.0
        motor = spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_position(kp=10 * limit, kv=limit)
        motor.forcerange, motor.forcelimited = [-limit, limit], 1
        low, high = joint.range
        low, high = (low, high) if high > low else (-math.inf, math.inf)
        held[joint.name] = position(robot, joint.name, low, high)
    model = spec.compile()
    data = mujoco.MjData(model)
    for i in range(model.nu):
        name = model.actuator(i).name
        data.ctrl[i] = data.joint(name).qpos[0] = held[name]
    for name, (leader, ratio, offset) in geared.items():
        data.joint(name).qpos[0] = ratio * held[leader] + offset
    mujoco.mj_forward(model, data)
    return model, data, root if robot.floats else robot.watched


def of_mujoco(file, robot):
    """Returns the time of a step, µs, and the height of the watched link at the start, m."""
    model, data, watched = model_of(file, robot)
    watched = data.body(watched)
    start = float(watched.xpos[2])
    half = round(SECONDS / 2 / DT)
    mujoco.mj_step(model, data, half)
    before = time.process_time()
    mujoco.mj_step(model, data, half)
    spent = time.process_time() - before
    # MuJoCo resets a simulation that has become infinite, and goes on.
    if any(w.number for w in data.warning):
        raise Fallen("MuJoCo: the simulation became unstable")
    check("MuJoCo", start, float(watched.xpos[2]))
    return spent / half * 1e6, start


def main():
    programs = sys.argv[1:] or ["target/release/tatu"]
    programs = [str(Path(p).resolve()) for p in programs]
    runs = [(p, s) for p in programs for s in SOLVERS]
    names = [f"{p if len(programs) > 1 else 'Tatu'}, {s}" for p, s in runs]
    print("| robot | MuJoCo, µs |", " | ".join(f"{name}, µs | ratio" for name in names), "|")
    print("|---|---:|" + "---:|---:|" * len(runs))
    for name, robot in ROBOTS.items():
        times = []
        with tempfile.TemporaryDirectory() as folder:
            file = path_of(robot, folder)
            for _ in range(3):
                peer, start = of_mujoco(file, robot)
                times.append([peer, *(tatu(*r, file, robot, start) for r in runs)])
        peer, *own = [min(column) for column in zip(*times)]
        print(f"| {name} | {peer:.1f} |", " | ".join(f"{t:.1f} | {peer / t:.3f}" for t in own), "|")


if __name__ == "__main__":
    main()
