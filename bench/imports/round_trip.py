"""Exports robots that Tatu imports, imports them again, and compares the numbers.

    python bench/imports/round_trip.py [--tatu PROGRAM] [--to urdf|mjcf] [--list] FILE|FOLDER ...

For each URDF or MJCF file: `tatu export FILE -o copy`, then `tatu check --numbers` of both. Compares masses, centres of
mass, inertia tensors, joints with limits and passive forces, and the poses of all bodies and dummies in three configurations
of the joints. Without `--to`, both formats are written. The copies are also loaded by MuJoCo (`pip install mujoco`) and
Pinocchio (`pip install pin`), if they are installed, and masses and poses are compared with theirs.

A good set of URDF files is that of the package example-robot-data (`pip install --no-deps example-robot-data`, then the folder
cmeel.prefix/share/example-robot-data/robots), and of MJCF files those of dm_control and gymnasium. Prints one line for each
file that differs, or for each with `--list`, and how many are equal; exits with 1 if one differs.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
# Poses near a start position in another format are rounded once more.
TOLERANCE = 1e-9
# What the copies in another format cannot hold, by format: keys of joints.
UNHELD = {"urdf": {"armature"}, "mjcf": {"max_velocity"}}


def run(program, *arguments):
    return subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, timeout=300)


def last(path):
    """Returns the last part of a path, without its index."""
    return path.rsplit("/", 1)[-1].split("[")[0]


def by_name(table):
    """Returns a table by the names of objects; names that several objects have are left out."""
    names = [last(path) for path in table]
    return {last(path): value for path, value in table.items() if names.count(last(path)) == 1}


def numbers(program, file, options=()):
    done = run(program, "check", file, "--numbers", *options)
    if done.returncode != 0:
        raise ValueError("not imported: " + (done.stderr.strip().splitlines() or ["?"])[-1])
    return json.loads(done.stdout.splitlines()[-1])


class Differences:
    """The greatest differences, by what differs."""

    def __init__(self):
        self.worst, self.missing, self.count = {}, [], 0

    def note(self, what, error, name):
        self.count += 1
        if not error <= self.worst.get(what, (0.0, ""))[0]:
            self.worst[what] = (float(error), name)

    def arrays(self, what, a, b, name, scale=None):
        a, b = np.asarray(a, float), np.asarray(b, float)
        size = max(1e-300, np.abs(a).max()) if scale is None else scale
        self.note(what, np.abs(a - b).max() / size, name)

    def found(self):
        wrong = [f"{what} {error:.0e} ({name})" for what, (error, name) in self.worst.items() if not error <= TOLERANCE]
        return wrong + self.missing[:3]


def matrix(pose):
    """Returns a pose as a 4 x 4 matrix."""
    x, y, z, w = pose[3:]
    turn = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = turn, pose[:3]
    return out


def matrix_error(a, b):
    return max(np.abs(a[:3, :3] - b[:3, :3]).max(), np.abs(a[:3, 3] - b[:3, 3]).max() / max(1.0, np.abs(a[:3, 3]).max()))


def pose_error(a, b):
    return matrix_error(matrix(a), matrix(b))


def root_of(table):
    """Returns the name of the topmost moving body."""
    return last(min(table["bodies"], key=lambda path: path.count("/"))) if table["bodies"] else ""


def compare(a, b, fmt, is_other):
    """Compares two sets of numbers. In another format, frames of joints may turn about their axis, those of bodies may lie
    elsewhere, and the whole may be placed elsewhere."""
    out = Differences()
    bodies, theirs = by_name(a["bodies"]), by_name(b["bodies"])
    # The importers name the base of a robot differently.
    root = root_of(a)
    lost, extra = sorted(set(bodies) - set(theirs)), sorted(set(theirs) - set(bodies))
    renamed = {lost[0]: extra[0]} if len(lost) == 1 and len(extra) == 1 else {}
    for name, body in bodies.items():
        other = theirs.get(renamed.get(name, name))
        if other is None:
            out.missing.append(f"no body {name}")
            continue
        out.arrays("mass", body["mass_kg"], other["mass_kg"], name)
        out.arrays("inertia", body["inertia_kg_m2"], other["inertia_kg_m2"], name)
    joints, others = by_name(a["joints"]), by_name(b["joints"])
    for name, joint in joints.items():
        other = others.get(name)
        if other is None:
            out.missing.append(f"no joint {name}")
            continue
        for key, value in joint.items():
            if is_other and key in UNHELD[fmt]:
                continue
            # Where there is no motor, importers assume one; a coupled joint has none in MJCF.
            if is_other and key == "max_force" and (value == 0.0 or "follows" in joint):
                continue
            found = other.get(key)
            if key == "follows":
                value, found = last(value), last(found or "")
            if isinstance(value, (list, float, int)) and found is not None:
                size = max(1e-300, np.abs(np.asarray(value, float)).max()) if np.any(value) else 1.0
                out.arrays(key, value, found, name, size)
            elif value != found:
                out.missing.append(f"{key} of {name}: {value}, not {found}")
    is_placed = not (is_other and fmt == "urdf")
    for ours, copies in zip(a["configurations"], b["configurations"]):
        positions, found = by_name(ours["positions"]), by_name(copies["positions"])
        for name in set(positions) & set(found):
            out.arrays("position", positions[name], found[name], name, 1.0)
        poses = {name: matrix(pose) for name, pose in by_name(ours["poses"]).items()}
        found = {name: matrix(pose) for name, pose in by_name(copies["poses"]).items()}
        shift = np.eye(4)
        if not is_placed and root in poses and renamed.get(root, root) in found:
            shift = found[renamed.get(root, root)] @ np.linalg.inv(poses[root])
        # The dummy that stands for a model has no counterpart in another format.
        tops = {last(path) for path in ours["poses"] if path.count("/") == 1} - set(bodies) if not is_placed else set()
        for name, pose in poses.items():
            if name in tops:
                continue
            other = found.get(renamed.get(name, name), found.get(f"{name}_dummy"))
            if other is None:
                # A name that several objects have cannot be compared.
                if not any(last(path) == name for path in copies["poses"]) and name not in lost:
                    out.missing.append(f"no pose of {name}")
                continue
            pose, other = shift @ pose, other.copy()
            if name in joints and is_other:
                # The zero about the axis is a matter of convention.
                out.note("joint place", np.abs(pose[:3, 3] - other[:3, 3]).max() / max(1.0, np.abs(pose[:3, 3]).max()), name)
                continue
            if name in bodies and renamed.get(name, name) in theirs:
                # The centre of mass is a point that does not depend on the frame.
                pose[:3, 3] = (pose @ [*bodies[name]["com_m"], 1.0])[:3]
                other[:3, 3] = (other @ [*theirs[renamed.get(name, name)]["com_m"], 1.0])[:3]
            out.note("pose", matrix_error(pose, other), name)
    return out


def check_mujoco(file, table):
    """Compares a MJCF copy as MuJoCo compiles it; returns what differs."""
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    out = Differences()
    bodies = by_name(table["bodies"])
    for number in range(1, model.nbody):
        body = bodies.get(model.body(number).name)
        if body is None:
            continue
        out.arrays("MuJoCo's mass", body["mass_kg"], model.body_mass[number], model.body(number).name)
        out.arrays("MuJoCo's centre", body["com_m"], model.body_ipos[number], model.body(number).name, 1.0)
        axes = np.zeros(9)
        mujoco.mju_quat2Mat(axes, model.body_iquat[number])
        axes = axes.reshape(3, 3)
        tensor = axes @ np.diag(model.body_inertia[number]) @ axes.T
        out.arrays("MuJoCo's inertia", body["inertia_kg_m2"], tensor, model.body(number).name)
    # The configurations of Tatu, at MuJoCo's joints of the same names.
    for configuration in table["configurations"]:
        positions = by_name(configuration["positions"])
        names = [model.joint(j).name for j in range(model.njnt)]
        if not set(names) - {""} <= set(positions) or any(k == mujoco.mjtJoint.mjJNT_BALL for k in model.jnt_type):
            continue
        data.qpos[:] = model.qpos0
        for j, name in enumerate(names):
            if name:
                data.qpos[model.jnt_qposadr[j]] = positions[name]
        mujoco.mj_kinematics(model, data)
        for name, (x, y, z, *quaternion) in by_name(configuration["poses"]).items():
            number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
            if number < 0 or name not in bodies or model.body_dofnum[model.body_rootid[number]] == 6:
                continue
            theirs = [*data.xpos[number], *np.roll(data.xquat[number], -1)]
            out.note("MuJoCo's pose", pose_error([x, y, z, *quaternion], theirs), name)
    return out.found()


def check_pinocchio(file, table):
    """Compares a URDF copy as Pinocchio reads it; returns what differs."""
    import pinocchio as pin

    model = pin.buildModelFromUrdf(str(file))
    data = model.createData()
    out = Differences()
    joints = by_name(table["joints"])
    for configuration in table["configurations"]:
        positions, q = by_name(configuration["positions"]), pin.neutral(model)
        for name, index in zip(model.names, range(model.njoints)):
            if name in positions and index > 0:
                at, joint, x = model.idx_qs[index], model.joints[index], positions[name]
                q[at : at + joint.nq] = [x] if joint.nq == 1 else [np.cos(x), np.sin(x)]
        pin.forwardKinematics(model, data, q)
        pin.updateFramePlacements(model, data)
        for name, (x, y, z, *quaternion) in by_name(configuration["poses"]).items():
            frames = [f for f in model.frames if f.type == pin.FrameType.BODY and f.name == name]
            if name in joints or len(frames) != 1:
                continue
            expected = data.oMf[model.getFrameId(name, pin.FrameType.BODY)]
            theirs = [*expected.translation, *pin.Quaternion(expected.rotation).coeffs()]
            out.note("Pinocchio's pose", pose_error([x, y, z, *quaternion], theirs), name)
    return out.found()


def files_of(places):
    for place in places:
        if place.is_dir():
            yield from sorted(f for f in place.rglob("*") if f.suffix in (".urdf", ".xml", ".toml"))
        else:
            yield place


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tatu", default=str(ROOT / "target/release/tatu"), help="the program")
    parser.add_argument("--to", choices=["urdf", "mjcf"], help="only this format")
    parser.add_argument("--list", action="store_true", help="a line for each file")
    parser.add_argument("files", nargs="+", type=Path)
    options = parser.parse_args()
    equal, tried, wrong, unread = {}, {}, 0, 0
    for file in files_of(options.files):
        try:
            original = numbers(options.tatu, file)
        except ValueError as error:
            unread += 1
            if options.list:
                print(f"{file.name:32} {error}")
            continue
        source = "mjcf" if file.suffix == ".xml" else file.suffix[1:]
        for fmt in [options.to] if options.to else ["urdf", "mjcf"]:
            way = f"{source} -> {fmt}"
            with tempfile.TemporaryDirectory() as folder:
                copy = Path(folder) / f"{file.stem}.{'xml' if fmt == 'mjcf' else fmt}"
                done = run(options.tatu, "export", file, "-o", copy)
                if done.returncode != 0:
                    text = next((line for line in done.stderr.splitlines() if line.startswith("error")), "?")
                    # A URDF file holds one robot.
                    is_refused = fmt == "urdf" and ("a URDF file holds one robot" in text or "no robot to export" in text)
                    if not is_refused:
                        tried[way] = tried.get(way, 0) + 1
                        wrong += 1
                    if options.list or not is_refused:
                        print(f"{file.name:32} {way}: not exported: {text}")
                    continue
                # Servos of motors that hold a position are read as such.
                held = ["--set", "file.servos=hold"] if fmt == "mjcf" and source != "mjcf" else []
                try:
                    table = numbers(options.tatu, copy, held)
                    told = [line for line in done.stdout.splitlines() if "changed or left out" in line]
                    found = compare(original, table, fmt, source != fmt).found()
                    if any("other bodies, with what they carry" in line for line in told):
                        continue
                    is_balanced = any("balanceinertia" in line or "requires moments" in line for line in told)
                    if is_balanced:
                        found = [f for f in found if "inertia" not in f]
                    try:
                        more = check_mujoco(copy, table) if fmt == "mjcf" else check_pinocchio(copy, table)
                        found += more
                    except ImportError:
                        pass
                    except ValueError as error:
                        found.append(f"not loaded: {str(error).splitlines()[0]}")
                except (ValueError, subprocess.TimeoutExpired) as error:
                    found = [str(error)]
            tried[way] = tried.get(way, 0) + 1
            equal[way] = equal.get(way, 0) + (not found)
            wrong += bool(found)
            if found or options.list:
                print(f"{file.name:32} {way}: {'; '.join(found) if found else 'equal'}", flush=True)
    if unread:
        print(f"{unread} files are not imported")
    for way, count in sorted(tried.items()):
        print(f"{way}: {equal.get(way, 0)} of {count} equal")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
