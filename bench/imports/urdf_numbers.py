"""Compares the numbers of imported URDF files with Pinocchio's.

    python bench/imports/urdf_numbers.py [--tatu PROGRAM] [FILE.urdf ...]

Needs `pip install pin numpy`. Without files, all robots of the package example-robot-data are compared, if it is
installed. For each file, `tatu check --numbers` prints masses, and poses at three configurations; Pinocchio computes them
from the same file at the same positions of joints. Prints the greatest differences, relative for masses and inertias, in
m and rad for poses, and what the import reports; exits with 1 if one exceeds 1e-9 without a report about masses.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin

ROOT = Path(__file__).resolve().parents[2]
TOLERANCE = 1e-9
# Reports of values that the importer replaces, so that they differ from the file.
REPLACED = ("physically impossible", "has no mass")


def example_files():
    """Returns the URDF files of the package example-robot-data."""
    found = set()
    for folder in map(Path, sys.path):
        found.update((folder / "cmeel.prefix/share/example-robot-data/robots").rglob("*.urdf"))
    return sorted(found)


def ask_tatu(program, file):
    """Returns the numbers and the reports of the import."""
    done = subprocess.run([program, "check", file, "--numbers"], capture_output=True, text=True)
    if done.returncode != 0:
        return None, done.stderr
    return json.loads(done.stdout.splitlines()[-1]), done.stderr


def last(path):
    """Returns the last part of a path, without its index."""
    return path.rsplit("/", 1)[-1].split("[")[0]


def state(model, positions, joints):
    """Returns Pinocchio's configuration for positions of joints by name."""
    q = pin.neutral(model)
    for name, index in zip(model.names, range(model.njoints)):
        if name not in positions or index == 0:
            continue
        at, joint = model.idx_qs[index], model.joints[index]
        # A continuous joint has a cosine and a sine.
        q[at : at + joint.nq] = [positions[name]] if joint.nq == 1 else [np.cos(positions[name]), np.sin(positions[name])]
    return q


def compare(program, file):
    """Returns the greatest differences of a file, or None, and the reports."""
    numbers, reports = ask_tatu(program, file)
    if numbers is None:
        return None, reports
    model = pin.buildModelFromUrdf(str(file))
    data = model.createData()
    # A joint can have the name of a link; the aliases of joints are those of the file.
    paths = set(numbers["joints"])
    mass = pose = inertia = 0.0
    for which, configuration in enumerate(numbers["configurations"]):
        positions = {last(path): q for path, q in configuration["positions"].items()}
        q = state(model, positions, paths)
        pin.forwardKinematics(model, data, q)
        pin.updateFramePlacements(model, data)
        for path, (x, y, z, *quaternion) in configuration["poses"].items():
            # Aliases have no slashes.
            frames = [
                f for f in model.frames if f.type == pin.FrameType.BODY and f.name.replace("/", "_") == last(path)
            ]
            if path in paths or len(frames) != 1:
                continue
            expected = data.oMf[model.getFrameId(frames[0].name, pin.FrameType.BODY)]
            turn = pin.Quaternion(*np.roll(quaternion, 1)).matrix()
            pose = max(
                pose, np.abs(expected.translation - [x, y, z]).max(), np.abs(expected.rotation - turn).max()
            )
        if which == 0:
            bodies = {last(path): body for path, body in numbers["bodies"].items()}
            for index in range(1, model.njoints):
                expected = model.inertias[index]
                links = [f.name.replace("/", "_") for f in model.frames if f.type == pin.FrameType.BODY and f.parentJoint == index]
                body = next((bodies[name] for name in links if name in bodies), None)
                if body is None or expected.mass == 0.0:
                    continue
                mass = max(mass, abs(body["mass_kg"] - expected.mass) / expected.mass)
                scale = np.abs(expected.inertia).max()
                # The frame of the body is that of its first link, which is the joint's.
                inertia = max(
                    inertia,
                    np.abs(expected.lever - body["com_m"]).max(),
                    np.abs(expected.inertia - body["inertia_kg_m2"]).max() / scale,
                )
    return (mass, inertia, pose, model.njoints - 1), reports


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tatu", default=str(ROOT / "target/release/tatu"), help="the program")
    parser.add_argument("files", nargs="*", type=Path)
    options = parser.parse_args()
    wrong = 0
    for file in options.files or example_files():
        found, reports = compare(options.tatu, file)
        warnings = [line.split(": ", 2)[-1] for line in reports.splitlines() if line.startswith("warning")]
        if found is None:
            print(f"{file.name:32} not imported: {reports.splitlines()[0]}")
            wrong += 1
            continue
        mass, inertia, pose, joints = found
        is_told = any(word in reports for word in REPLACED)
        is_wrong = pose > TOLERANCE or max(mass, inertia) > TOLERANCE and not is_told
        wrong += is_wrong
        print(f"{file.name:32} {joints:3} joints  mass {mass:.0e}  inertia {inertia:.0e}  pose {pose:.0e}"
              f"{'  WRONG' if is_wrong else ''}{'  ' + '; '.join(w[:90] for w in warnings) if warnings else ''}")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
