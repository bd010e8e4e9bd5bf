#!/usr/bin/env python3
"""Builds the templates of `tatu new plugin` with several compilers, runs their scenes and checks them.

compilers.py PROGRAM

gcc and clang (from the PyPI package ziglang), C11 and C++17, -O0 and -O3; Rust by Debian's rustc-web. Missing compilers
are reported and skipped.
"""

import os
import shutil
import subprocess
import sys
import tempfile
import venv
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

KINDS = ["command", "sensor", "actuator", "model", "importer", "service", "script"]
CPP_KINDS = ["command", "sensor"]
AT_ONCE = 2


def zig(folder):
    """Creates scripts that run clang's C and C++ compilers. Returns their paths, or None if ziglang is missing."""
    venv.create(folder, with_pip=True)
    python = folder / "bin/python"
    if subprocess.run([python, "-m", "pip", "install", "--quiet", "ziglang"], capture_output=True).returncode:
        return None
    scripts = []
    for name, tool in [("zcc", "cc"), ("zc++", "c++")]:
        script = folder / name
        script.write_text(f'#!/bin/sh\nexec {python} -m ziglang {tool} "$@"\n')
        script.chmod(0o755)
        scripts.append(str(script))
    return scripts


def attempt(program, folder, name, lang, kind, env):
    """Creates, builds, runs and checks a plugin; returns the output of the first command that fails, or None."""
    place = folder / name
    place.mkdir()
    # Projects with the same name would overwrite each other's library in a common target folder.
    plugin = f"tried_{kind}"
    env = {**os.environ, "XDG_DATA_HOME": str(place / ".data"), **env}
    for command in [["new", "plugin", plugin, "--lang", lang, "--kind", kind], ["plugin", "run", plugin],
                    ["plugin", "check", plugin]]:
        ran = subprocess.run([program, *command], cwd=place, env=env, capture_output=True, text=True)
        if ran.returncode:
            return f"tatu {' '.join(command)}\n{ran.stdout}{ran.stderr}"
    return None


def main():
    program = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        compilers = {"gcc": ("gcc", "g++")}
        clang = zig(folder / "zig")
        if clang:
            compilers["clang"] = clang
        else:
            print("skipped: clang, since ziglang cannot be installed from PyPI")
        jobs = []
        for name, (cc, cxx) in compilers.items():
            for level in ["-O0", "-O3"]:
                env = {"CC": cc, "CXX": cxx, "CFLAGS": level, "CXXFLAGS": level}
                jobs += [(f"{name}{level}-c-{kind}", "c", kind, env) for kind in KINDS]
                jobs += [(f"{name}{level}-cpp-{kind}", "cpp", kind, env) for kind in CPP_KINDS]
        if Path("/usr/bin/rustc").exists():
            env = {"RUSTC": "/usr/bin/rustc", "CARGO_TARGET_DIR": str(folder / "rust"), "CARGO_NET_OFFLINE": "true",
                   "CARGO_PROFILE_DEV_DEBUG": "0"}
            jobs += [(f"rustc-web-{kind}", "rust", kind, env) for kind in KINDS]
        else:
            print("skipped: Debian's rustc-web, which is not installed")
        if not shutil.which("gcc"):
            sys.exit("there is no gcc")
        with ThreadPoolExecutor(AT_ONCE) as pool:
            results = list(pool.map(lambda job: attempt(program, folder, *job), jobs))
    failed = [(job[0], why) for job, why in zip(jobs, results) if why]
    for name, why in failed:
        print(f"FAIL  {name}: {why}")
    print(f"{len(jobs) - len(failed)} of {len(jobs)} plugins are built, run, and pass the checks")
    sys.exit(1 if failed else 0)


main()
