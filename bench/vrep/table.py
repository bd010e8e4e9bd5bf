"""Compares scenes of V-REP with their behaviour in the original program.

    python bench/vrep/table.py FOLDER [--program target/release/tatu] [--seconds 10] [--only NAME] [--write]

FOLDER contains scenes, each with a file NAME.reference.json that was measured with the original: poses at load and in
every half second of a run, masses, modes and errors of scripts. Sensors detected nothing in these runs. --write writes
the table into docs/vrep-scenes.md.
"""
import argparse
import functools
import json
import math
import multiprocessing
import os
import subprocess
import tempfile
import tomllib

HERE = os.path.dirname(os.path.abspath(__file__))
PAGE = os.path.join(HERE, "../../docs/vrep-scenes.md")
BEGIN, END = "<!-- table -->", "<!-- end -->"


def mul(a, b):
    """Returns the product of two quaternions x y z w."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz)


def turn(q, v):
    x, y, z, _ = mul(mul(q, (*v, 0.0)), (-q[0], -q[1], -q[2], q[3]))
    return (x, y, z)


def compose(a, b):
    p = turn(a[1], b[0])
    return (tuple(x + y for x, y in zip(a[0], p)), mul(a[1], b[1]))


def euler(e):
    """Returns the quaternion of rotations about the body's x, then y, then z axis, degrees."""
    out = (0.0, 0.0, 0.0, 1.0)
    for i, deg in enumerate(e):
        axis = [0.0, 0.0, 0.0]
        axis[i] = math.sin(math.radians(deg) / 2)
        out = mul(out, (*axis, math.cos(math.radians(deg) / 2)))
    return out


def apart(a, b):
    """Returns the distance, m, and the angle, rad, between two poses of seven numbers."""
    d = math.dist(a[:3], b[:3])
    na, nb = (math.sqrt(sum(x * x for x in q)) for q in (a[3:], b[3:]))
    dot = abs(sum(x * y for x, y in zip(a[3:], b[3:]))) / (na * nb)
    return d, 2 * math.acos(min(1.0, dot))


def at_load(scene):
    """Returns table (with `_path` added) and world pose of each object of a scene file without models, in order."""
    names, out, count = {}, [], {}
    for o in scene["object"]:
        above = names.get(o.get("parent"))
        q = tuple(o["quaternion"]) if "quaternion" in o else euler(o.get("orientation_deg", (0, 0, 0)))
        here = (tuple(o.get("position_m", (0, 0, 0))), q)
        world = compose(above["frame"], here) if above else here
        frame = world
        if o["kind"] == "joint":
            if o.get("type") == "spherical":
                frame = compose(world, ((0, 0, 0), tuple(o.get("rotation", (0, 0, 0, 1)))))
            elif o.get("type") == "prismatic":
                frame = compose(world, ((0, 0, o.get("joint_position_m", 0.0)), (0, 0, 0, 1)))
            else:
                rad = math.radians(o["joint_position_deg"]) if "joint_position_deg" in o else o.get("joint_position_rad", 0.0)
                lead = o.get("lead_m", 0.0) * rad / math.tau
                frame = compose(world, ((0, 0, lead), (0, 0, math.sin(rad / 2), math.cos(rad / 2))))
        key = (o.get("parent"), o["alias"])
        count.setdefault(key, []).append(o)
        names[o.get("name", o["alias"])] = {"frame": frame, "above": above, "o": o, "key": key}
        o["_me"] = names[o.get("name", o["alias"])]
        out.append((o, world))
    for o, _ in out:
        me, parts = o["_me"], []
        while me:
            same = count[me["key"]]
            parts.append(me["o"]["alias"] + (f"[{next(i for i, x in enumerate(same) if x is me['o'])}]" if len(same) > 1 else ""))
            me = me["above"]
        o["_path"] = "/" + "/".join(reversed(parts))
    return out


def paths(reference):
    """Returns the paths of the objects of a reference."""
    out = []
    for o in reference["objects"]:
        above = out[o["parent"]] if o["parent"] >= 0 else ""
        out.append(above + "/" + o["alias"])
    return out


def run(program, scene, seconds, watch, place):
    args = [program, "run", scene, "--seconds", str(seconds), "--json", "--trace", "trace.jsonl", "--no-addons"]
    for path in watch:
        args += ["--watch", path]
    done = subprocess.run(args, cwd=place, capture_output=True, text=True, timeout=900)
    if done.returncode == 2:
        return None, done.stderr
    poses = {p: [] for p in watch}
    with open(os.path.join(place, "trace.jsonl")) as f:
        for line in f:
            line = json.loads(line)
            for path in watch:
                o = line.get("objects", {}).get(path)
                if o and None not in o["position"] + o["quaternion"]:
                    poses[path].append((line["time"], o["position"] + o["quaternion"]))
    return (json.loads(done.stdout), poses), done.stderr


def mean_speed(poses, seconds):
    """Returns the mean speed from sorted pairs (time, pose): the path over intervals of 0.5 s, divided by the time."""
    way, last = 0.0, None
    for t, p in poses:
        if t > seconds + 1e-6:
            break
        if last is None or t - last[0] >= 0.5 - 1e-6:
            if last is not None:
                way += math.dist(p[:3], last[1][:3])
            last = (t, p)
    return way / seconds


def facts(converted, reference):
    """Returns the differences at load: maximum distance and angle, number of missing objects, other differences."""
    ours = {o["_path"]: (o, w) for o, w in at_load(converted)}
    worst, other, missing = (0.0, 0.0), [], 0
    spherical, overridden = set(), []
    for i, (o, path) in enumerate(zip(reference["objects"], paths(reference))):
        above = overridden[o["parent"]] if o["parent"] >= 0 else 0
        overridden.append(above | (o.get("modelProp", 0) if o.get("model") else 0))
        if o["parent"] in spherical or o.get("joint") == "spherical":
            spherical.add(i)
        if o["type"] == "script" or o["alias"] == "addedFloor":
            continue
        if path not in ours:
            missing += 1
            continue
        table, world = ours[path]
        if o["parent"] not in spherical:
            d = apart(list(world[0]) + list(world[1]), o["pose"])
            worst = (max(worst[0], d[0]), max(worst[1], d[1]))
        if "mass" in o and not o.get("static") and table["kind"] == "shape":
            if abs(table.get("mass_kg", 0.0) - o["mass"]) > 1e-4 * max(1e-3, o["mass"]):
                other.append("mass")
        if table["kind"] == "shape":
            dynamic = not o.get("static", True) and not overridden[i] & 0x20
            respondable = o.get("respondable", False) and not overridden[i] & 0x40
            if bool(table.get("dynamic", False)) != dynamic:
                other.append("static")
            if bool(table.get("respondable", False)) != bool(respondable):
                other.append("respondable")
    return worst, missing, other


def compare(args, name):
    base = os.path.join(args.folder, name)
    scene = next(base + e for e in (".ttt", ".ttm") if os.path.exists(base + e))
    reference = json.load(open(base + ".reference.json"))
    row = {"name": name, "objects": reference.get("object_count")}
    if "objects" not in reference:
        row["why"] = "the original does not load it"
        return row
    with tempfile.TemporaryDirectory() as place:
        done = subprocess.run([args.program, "convert", scene, "c.toml"], cwd=place, capture_output=True, text=True)
        if done.returncode:
            row["why"] = done.stderr.strip().splitlines()[-1][:80]
            return row
        row["load"], row["missing"], row["other"] = facts(tomllib.load(open(os.path.join(place, "c.toml"), "rb")), reference)
        motion = reference.get("motion_with_module_stand_ins") or reference.get("motion")
        if isinstance(motion, dict) and "same_as" in motion:
            motion = reference["motion"]
        all_paths = paths(reference)
        watched = [(all_paths[o["i"]], o) for o in (motion or {}).get("objects", []) if o["i"] < len(all_paths)]
        if scene.endswith(".ttm"):
            # In the original, a model was placed on a floor in an empty scene.
            with open(os.path.join(place, "m.toml"), "w") as f:
                f.write('format = 1\n[[object]]\nkind = "shape"\nalias = "addedFloor"\nsize_m = [10.0, 10.0, 0.1]\n'
                        'position_m = [0.0, 0.0, -0.05]\nrespondable = true\n' + open(os.path.join(place, "c.toml")).read().split("\n", 1)[1])
            scene = "m.toml"
        seconds = args.seconds
        watch = [p for p, _ in watched if not p.endswith("/addedFloor")]
        got, err = run(args.program, scene, seconds, sorted(set(watch)), place)
        if got is None and watch:
            # The converted scene names some objects differently.
            known = {p for p in watch if subprocess.run(
                [args.program, "run", scene, "--steps", "1", "--trace", "x.jsonl", "--watch", p, "--no-addons"],
                cwd=place, capture_output=True).returncode != 2}
            row["unknown"] = len(watch) - len(known)
            watch = [p for p in watch if p in known]
            got, err = run(args.program, scene, seconds, sorted(set(watch)), place)
        if got is None:
            row["why"] = err.strip().splitlines()[-1][:80]
            return row
        summary, poses = got
        row["errors"] = (sum(1 for _ in summary["errors"]), len(reference.get("script_errors", [])))
        row["bodies"], row["good"], row["worst"] = 0, 0, []
        for path, o in watched:
            if path not in watch or not poses.get(path):
                continue
            theirs = [(i * 0.5, p) for i, p in enumerate(o["poses"])] if "poses" in o else [(i * 0.5, o["still"]) for i in range(61)]
            mine = [(0.0, theirs[0][1])] + poses[path]
            a, b = mean_speed(mine, seconds), mean_speed(theirs, seconds)
            at5 = lambda list_: min(list_, key=lambda e: abs(e[0] - min(5.0, seconds)))[1]
            d5, _ = apart(at5(mine), at5(theirs))
            rest = b < 1e-3
            good = d5 < 0.01 if rest else abs(a - b) <= 0.05 * b
            row["bodies"] += 1
            row["good"] += good
            if not good:
                row["worst"].append((path, a, b, d5))
    return row


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("--program", default="target/release/tatu")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--only")
    parser.add_argument("--write", action="store_true")
    args = parser.parse_args()
    args.folder, args.program = os.path.abspath(args.folder), os.path.abspath(args.program)
    names = sorted(f[:-len(".reference.json")] for f in os.listdir(args.folder) if f.endswith(".reference.json"))
    lines = ["| file | objects | pose at load, m / rad | differs | errors of scripts, here / there | bodies that move likewise |",
             "|---|---|---|---|---|---|"]
    names = [n for n in names if not args.only or args.only in n]
    with multiprocessing.Pool() as pool:
        rows = pool.imap(functools.partial(compare, args), names)
        lines += [told(args, name, r) for name, r in zip(names, rows)]
    if args.write:
        page = open(PAGE).read()
        head, rest = page.split(BEGIN, 1)
        _, tail = rest.split(END, 1)
        open(PAGE, "w").write(head + BEGIN + "\n" + "\n".join(lines) + "\n" + END + tail)


def told(args, name, r):
    """Prints and returns the line of a file."""
    if "why" in r:
        line = f"| {name} | {r['objects']} | | {r['why']} | | |"
    else:
        other = ", ".join(sorted(set(r["other"]))) + (f" {r['missing']} not found" if r["missing"] else "")
        line = (f"| {name} | {r['objects']} | {r['load'][0]:.0e} / {r['load'][1]:.0e} | {other} "
                f"| {r['errors'][0]} / {r['errors'][1]} | {r['good']} of {r['bodies']} |")
    print(line, flush=True)
    worst = sorted(r.get("worst", []), key=lambda w: -w[3])
    for path, a, b, d in worst if args.only else worst[:1]:
        print(f"    {path}: {a:.4f} m/s here, {b:.4f} there, {d:.4f} m apart at 5 s")
    return line


if __name__ == "__main__":
    main()
