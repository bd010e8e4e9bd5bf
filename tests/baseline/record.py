#!/usr/bin/env python3
"""Records the results of all scenes and demos, to compare two builds of the program.

    tests/baseline/record.py record [--program target/release/tatu] OUT
    tests/baseline/record.py compare A B

`record` runs every scene in `scenes/` and every `demo.toml` of a plugin or model for 5 s with seed 1 and writes into
OUT, per scene: the trace (hash of each object, poses, readings of all sensors, status bar, consoles), the output of the
program, and pictures of the scene at the start and at the end. `compare` lists each file that differs, and the first
step in which two traces differ. A change that should preserve behaviour leaves all files equal.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SECONDS = "5"
VIEWS = {"start": ("0", "-3,-4,3"), "end": (SECONDS, "4,-3,2.5")}


def scenes():
    found = [*ROOT.glob("scenes/*/*.toml"), *ROOT.glob("plugins/*/*/demo.toml"), *ROOT.glob("models/*/demo.toml")]
    return sorted(p.relative_to(ROOT) for p in found)


def run(program, *args):
    # Scripts write files to the working folder, so runs use an empty one, to leave no files in the repository.
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([program, *args, "--files", folder], cwd=ROOT, capture_output=True, text=True, timeout=600)
        written = {p.relative_to(folder): p.read_bytes() for p in sorted(pathlib.Path(folder).rglob("*")) if p.is_file()}
    return done, written


def summary_of(text):
    """Returns the summary of a run without its wall times, or the text itself if it is not JSON."""
    try:
        summary = json.loads(text)
    except ValueError:
        return text
    for key in ("wall_s", "step_wall_s"):
        summary.pop(key, None)
    return json.dumps(summary, indent=1, sort_keys=True)


def record(program, out):
    out.mkdir(parents=True, exist_ok=True)
    for scene in scenes():
        name = "__".join(scene.with_suffix("").parts)
        first = out / f"{name}.objects.jsonl"
        run(program, "run", scene, "--steps", "1", "--hashes", "--trace", first)
        objects = sorted(json.loads(first.read_text().splitlines()[0]).get("hashes", {})) if first.exists() else []
        first.unlink(missing_ok=True)
        watch = [arg for path in objects for arg in ("--watch", path)]
        trace = out / f"{name}.trace.jsonl"
        done, written = run(program, "run", scene, "--seconds", SECONDS, "--seed", "1", "--hashes", "--json",
                            "--trace", trace, *watch)
        (out / f"{name}.summary.json").write_text(summary_of(done.stdout))
        (out / f"{name}.messages.txt").write_text(f"exit {done.returncode}\n{done.stderr}")
        for path, content in written.items():
            file = out / f"{name}.files" / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content)
        for view, (at, camera) in VIEWS.items():
            picture = out / f"{name}.{view}.png"
            run(program, "look", scene, "--seed", "1", "--at", at, "--from", camera, "--to", "0,0,0.2",
                "--size", "640x360", "-o", picture)
        print(name, flush=True)


def compare(a, b):
    names = sorted({p.relative_to(d) for d in (a, b) for p in d.rglob("*") if p.is_file()})
    differ = 0
    for name in names:
        left, right = a / name, b / name
        if not (left.exists() and right.exists()):
            print(f"{name}: only in {a if left.exists() else b}")
        elif left.read_bytes() != right.read_bytes():
            lines = enumerate(zip(left.read_bytes().splitlines(), right.read_bytes().splitlines()), 1)
            at = next((n for n, (x, y) in lines if x != y), "its length")
            print(f"{name}: differs at line {at}")
        else:
            continue
        differ += 1
    print(f"{len(names) - differ} of {len(names)} files are equal")
    return 1 if differ or not names else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    one = commands.add_parser("record", help="run all scenes and write what they do")
    one.add_argument("--program", type=pathlib.Path, default=ROOT / "target/release/tatu")
    one.add_argument("out", type=pathlib.Path)
    two = commands.add_parser("compare", help="name the files in which two records differ")
    two.add_argument("a", type=pathlib.Path)
    two.add_argument("b", type=pathlib.Path)
    args = parser.parse_args()
    if args.command == "record":
        record(args.program.resolve(), args.out.resolve())
        return 0
    return compare(args.a, args.b)


if __name__ == "__main__":
    sys.exit(main())
