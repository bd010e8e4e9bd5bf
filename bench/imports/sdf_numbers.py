"""Compares the numbers of imported SDF files with those of a reader in this script.

    python bench/imports/sdf_numbers.py [--tatu PROGRAM] FILE.sdf|FOLDER ...

Needs `pip install numpy`. There is no other program that reads SDF and can be installed from a package index, so this
script reads links, joints and poses on its own: it resolves frames, follows the joints of each model from its root, and
sums masses. `tatu check --numbers` prints masses, and poses at three configurations. Models with includes are resolved by
neither, and are skipped; so are those whose joints form loops. Prints the greatest differences, relative for masses and
inertias, in m and as entries of rotation matrices for poses; exits with 1 if one exceeds 1e-9.
"""

import argparse
import json
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
TOLERANCE = 1e-9


class Skipped(Exception):
    """The model uses something that this script does not read."""


def clean(text):
    """Returns the text without comments and prefixes."""
    text = re.sub(r"<!--.*?-->|<\?.*?\?>", "", text, flags=re.S)
    return re.sub(r"(</?|\s)(?!xmlns)(\w+):(\w+)(?=[\s=/>])", r"\1\2_\3", text)


def numbers(text):
    return [float(word) for word in (text or "").split()]


def rotation(roll, pitch, yaw):
    (cr, cp, cy), (sr, sp, sy) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return z @ y @ x


def of_quaternion(x, y, z, w):
    x, y, z, w = np.array([x, y, z, w]) / np.linalg.norm([x, y, z, w])
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])


def transform(turn=np.eye(3), shift=(0, 0, 0)):
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = turn, shift
    return out


def about(axis, angle):
    """Returns the rotation about a unit vector."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def stated_pose(element):
    """Returns the pose of an element, and the name of the frame to which it is relative."""
    pose = element.find("pose")
    if pose is None or not (pose.text or "").strip():
        return np.eye(4), pose.get("relative_to") if pose is not None else None
    values = numbers(pose.text)
    frame = pose.get("relative_to") or pose.get("frame")
    if pose.get("rotation_format") == "quat_xyzw":
        return transform(of_quaternion(*values[3:]), values[:3]), frame
    if pose.get("degrees") in ("true", "1"):
        values[3:] = np.radians(values[3:])
    return transform(rotation(*values[3:]), values[:3]), frame


class Model:
    """A model without nested ones."""

    def __init__(self, tag, version):
        if tag.find("model") is not None or tag.find("include") is not None:
            raise Skipped("nested")
        self.tag, self.name = tag, tag.get("name")
        self.links = {link.get("name"): link for link in tag.findall("link")}
        self.joints = {joint.get("name"): joint for joint in tag.findall("joint")}
        self.frames = {frame.get("name"): frame for frame in tag.findall("frame")}
        self.version = version
        self.pose = stated_pose(tag)[0]

    def frame(self, name, depth=0):
        """Returns the pose of a frame in the model."""
        if name in ("__model__", "world", None) or depth > 100:
            return np.eye(4)
        name = name.split("::")[-1]
        if name in self.links:
            pose, base = stated_pose(self.links[name])
        elif name in self.frames:
            pose, base = stated_pose(self.frames[name])
            base = base or self.frames[name].get("attached_to")
        else:
            return self.joint_frame(self.joints[name], depth)
        return self.frame(base, depth + 1) @ pose

    def joint_frame(self, joint, depth=0):
        pose, base = stated_pose(joint)
        return self.frame(base or joint.findtext("child").strip(), depth + 1) @ pose

    def attached(self, name):
        """Returns the link to which a frame is attached."""
        name = name.strip().split("::")[-1]
        if name in self.links or name == "world":
            return name
        if name == "__model__":
            return next(iter(self.links))
        if name in self.frames:
            return self.attached(self.frames[name].get("attached_to") or "__model__")
        return self.attached(self.joints[name].findtext("child"))

    def motions(self, joint, positions):
        """Returns the motion of a joint about and along its axes, in its frame."""
        name, kind = joint.get("name"), joint.get("type")
        motion = np.eye(4)
        if kind in ("fixed", "ball"):
            return motion
        for which, suffix in (("axis", ""), ("axis2", "_axis2")):
            if which == "axis2" and kind not in ("universal", "revolute2"):
                break
            axis = joint.find(which)
            xyz = axis.find("xyz") if axis is not None else None
            vector = np.array(numbers(xyz.text)) if xyz is not None and xyz.text else np.array([0.0, 0.0, 1.0])
            old = self.version <= (1, 4) or axis is not None and axis.findtext("use_parent_model_frame", "0").strip() in ("1", "true")
            frame = xyz.get("expressed_in") if xyz is not None else None
            own = self.joint_frame(joint)[:3, :3]
            if frame:
                vector = own.T @ self.frame(frame)[:3, :3] @ vector
            elif old:
                vector = own.T @ vector
            vector /= np.linalg.norm(vector)
            q = positions.get(name + suffix, 0.0)
            if kind == "prismatic":
                motion = motion @ transform(shift=q * vector)
            else:
                lead = 0.0
                if kind == "screw":
                    pitch = joint.findtext("screw_thread_pitch")
                    lead = float(pitch) if pitch else -2 * np.pi / float(joint.findtext("thread_pitch", "1"))
                motion = motion @ transform(about(vector, q), q * lead / (2 * np.pi) * vector)
        return motion

    def poses(self, positions):
        """Returns the poses of all links in the world."""
        edges = {}
        for joint in self.joints.values():
            ends = [self.attached(joint.findtext(role)) for role in ("parent", "child")]
            if joint.get("type") == "gearbox" or ends[0] == ends[1]:
                continue
            motion, frame = self.motions(joint, positions), self.joint_frame(joint)
            down = frame @ motion @ np.linalg.inv(frame)
            edges.setdefault(ends[0], []).append((ends[1], down))
            edges.setdefault(ends[1], []).append((ends[0], np.linalg.inv(down)))
        children = {self.attached(j.findtext("child")) for j in self.joints.values() if j.get("type") != "gearbox"}
        order = ["world"] + [l for l in self.links if l not in children] + list(self.links)
        moved, used = {}, set()
        for root in order:
            if root in moved or root == "world" and root not in edges:
                continue
            moved[root] = np.eye(4)
            open_links = [root]
            while open_links:
                link = open_links.pop()
                for other, motion in edges.get(link, []):
                    # The motion is one of the model from its pose in the file.
                    if other not in moved:
                        moved[other] = moved[link] @ motion
                        used.add(frozenset((link, other)))
                        open_links.append(other)
        pairs = [frozenset(self.attached(j.findtext(r)) for r in ("parent", "child")) for j in self.joints.values()
                 if j.get("type") != "gearbox"]
        if len([p for p in pairs if len(p) == 2]) != len(used):
            raise Skipped("loop")
        fixed = self.fixed(edges)
        return {name: self.pose @ moved[name] @ self.frame(name) for name in self.links}, fixed

    def fixed(self, edges):
        """Returns the links that cannot move."""
        if self.tag.findtext("static", "0").strip() in ("1", "true"):
            return set(self.links)
        if "world" in self.links and self.links["world"].find("inertial") is not None:
            return set()
        found, open_links = {"world"}, ["world"]
        while open_links:
            link = open_links.pop()
            for joint in self.joints.values():
                ends = [self.attached(joint.findtext(role)) for role in ("parent", "child")]
                if joint.get("type") == "fixed" and link in ends:
                    other = ends[1 - ends.index(link)]
                    if other not in found:
                        found.add(other)
                        open_links.append(other)
        return found

    def mass(self, name):
        """Returns mass, centre of mass and tensor about it, in the frame of the link."""
        tag = self.links[name].find("inertial")
        if tag is None:
            return 1.0, np.zeros(3), np.eye(3)
        if tag.get("auto") in ("true", "1"):
            raise Skipped("computed inertia")
        pose, _ = stated_pose(tag)
        value = lambda of, key, default: float(of.findtext(key) or default) if of is not None else default
        of = tag.find("inertia")
        xx, yy, zz = (value(of, key, 1.0) for key in ("ixx", "iyy", "izz"))
        xy, xz, yz = (value(of, key, 0.0) for key in ("ixy", "ixz", "iyz"))
        own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        turn = pose[:3, :3]
        return value(tag, "mass", 1.0), pose[:3, 3], turn @ own @ turn.T


def combined(parts):
    """Returns the sum of masses with their poses: mass, centre and tensor about it."""
    total = sum(m for m, _, _ in parts)
    centre = sum(m * c for m, c, _ in parts) / total if total > 0 else np.zeros(3)
    tensor = np.zeros((3, 3))
    for m, c, i in parts:
        d = c - centre
        tensor += i + m * (d @ d * np.eye(3) - np.outer(d, d))
    return total, centre, tensor


def models_of(file):
    root = ET.fromstring(clean(file.read_text(errors="replace")))
    version = tuple(int(x) for x in root.get("version", "1.12").split(".")[:2])
    world = root.find("world")
    around = root if world is None else world
    if around.find("include") is not None:
        raise Skipped("include")
    models = [Model(tag, version) for tag in around.findall("model")]
    if len({model.name for model in models}) < len(models):
        raise Skipped("equal names")
    return models, world


def last(path):
    return path.rsplit("/", 1)[-1].split("[")[0]


def compare(program, file):
    """Returns the numbers of models, bodies and poses that were compared, and the greatest differences."""
    models, world = models_of(file)
    done = subprocess.run([program, "check", file, "--numbers"], capture_output=True, text=True, timeout=120)
    if done.returncode != 0:
        return None, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    joints = set(found["joints"])
    worst = {"mass": 0.0, "inertia": 0.0, "pose": 0.0}
    poses = 0
    everything = []
    for which, configuration in enumerate(found["configurations"]):
        for model in models:
            start = next((p for p in configuration["poses"] if model.name.replace("/", "_") in p.split("/")), None)
            if start is None:
                continue
            inside = [p for p in configuration["poses"] if model.name.replace("/", "_") in p.split("/")[1:3] and p not in joints]
            own = {last(p): q for p, q in configuration["positions"].items() if model.name.replace("/", "_") in p.split("/")[1:3]}
            wanted, fixed = model.poses(own)
            for path in inside:
                name = last(path)
                if name not in wanted or name == model.name and path.count("/") <= 2:
                    continue
                x, y, z, *quaternion = configuration["poses"][path]
                other = transform(of_quaternion(*quaternion), (x, y, z))
                worst["pose"] = max(worst["pose"], np.abs(other - wanted[name]).max())
                poses += 1
            if which == 0:
                for name, at in wanted.items():
                    if name not in fixed:
                        m, c, i = model.mass(name)
                        everything.append((m, (at @ [*c, 1])[:3], at[:3, :3] @ i @ at[:3, :3].T))
    total = found["total"]
    if everything:
        mass, centre, tensor = combined(everything)
        worst["mass"] = abs(total["mass_kg"] - mass) / max(mass, 1e-12)
        scale = max(np.abs(tensor).max(), 1e-12)
        worst["inertia"] = max(np.abs(centre - total["com_m"]).max() / max(1.0, np.abs(centre).max()),
                               np.abs(tensor - total["inertia_kg_m2"]).max() / scale)
    return (len(models), len(found["bodies"]), poses, worst), done.stderr


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tatu", default=str(ROOT / "target/release/tatu"), help="the program")
    parser.add_argument("paths", nargs="+", type=Path)
    options = parser.parse_args()
    files = sorted(f for p in options.paths for f in (p.rglob("*.sdf") if p.is_dir() else [p]))
    wrong = models = bodies = poses = skipped = 0
    for file in files:
        try:
            result, reports = compare(options.tatu, file)
        except (Skipped, ET.ParseError, KeyError, AttributeError, subprocess.TimeoutExpired) as e:
            skipped += 1
            print(f"{file.name:40} skipped: {type(e).__name__} {e}")
            continue
        if result is None:
            print(f"{file.name:40} not imported: {reports.splitlines()[0] if reports else ''}")
            wrong += 1
            continue
        m, b, p, worst = result
        models, bodies, poses = models + m, bodies + b, poses + p
        # Values that the importer replaces are reported.
        is_told = any(word in reports for word in ("has no mass", "physically impossible", "computed without"))
        is_wrong = worst["pose"] > TOLERANCE or max(worst["mass"], worst["inertia"]) > TOLERANCE and not is_told
        wrong += is_wrong
        print(f"{file.name:40} {m:3} models {b:4} bodies {p:5} poses  mass {worst['mass']:.0e}  "
              f"inertia {worst['inertia']:.0e}  pose {worst['pose']:.0e}{'  WRONG' if is_wrong else ''}")
    print(f"{len(files)} files: {models} models, {bodies} moving bodies, {poses} poses compared; {skipped} skipped, {wrong} wrong")
    sys.exit(int(wrong > 0))


if __name__ == "__main__":
    main()
