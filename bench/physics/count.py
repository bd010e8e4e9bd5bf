"""Counts the instructions of a physics step of 5 ms in Tatu and MuJoCo, for the robots of `robots.py`.

    apt-get install valgrind gcc
    pip install mujoco numpy && pip install --no-deps example-robot-data
    python3 bench/physics/count.py [--program target/release/tatu] [ROBOT ...]

Unlike times, counts do not depend on the load of the machine: two runs differ by less than 1 %. Both programs run
under callgrind twice, and the difference of the two runs excludes the time to load. MuJoCo is called from a C program,
which is compiled for this. What is counted lies between the second and third second of the robot's time.
"""

import argparse
import re
import subprocess
import tempfile
from pathlib import Path

import mujoco

import robots

RUNS = (2.0, 3.0)
STEPS = round((RUNS[1] - RUNS[0]) / robots.DT)
# Reads a model, the number of steps, and a file with the positions and then the controls.
PEER = """
#include <mujoco/mujoco.h>
#include <stdio.h>
#include <stdlib.h>
int main(int count, char **arguments) {
    char error[500] = "";
    mjModel *model = mj_loadModel(arguments[1], 0);
    mjData *data = mj_makeData(model);
    FILE *start = fopen(arguments[3], "rb");
    if (fread(data->qpos, sizeof(double), model->nq, start) != (size_t)model->nq) return 1;
    if (fread(data->ctrl, sizeof(double), model->nu, start) != (size_t)model->nu) return 1;
    for (int i = atoi(arguments[2]); i > 0; i--) mj_step(model, data);
    return 0;
}
"""


def counted(command, folder):
    """Returns the number of instructions of a command."""
    out = Path(folder, "callgrind.out")
    run = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", *command]
    done = subprocess.run(run, cwd=robots.share(), capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, command))} fails under valgrind:\n{done.stderr[-2000:]}")
    return int(re.search(r"Collected : (\d+)", done.stderr)[1])


def step_of_tatu(program, file, robot, folder):
    """Returns the instructions of a physics step."""
    Path(folder, "s.toml").write_text(robots.scene_text("auto", file, robot))
    # Under valgrind, a large robot takes minutes to load.
    run = [program, "run", Path(folder, "s.toml"), "--threads", "1", "--watchdog", "0", "--seconds"]
    first, second = (counted([*run, str(seconds)], folder) for seconds in RUNS)
    return (second - first) / STEPS


def peer_program(folder):
    """Compiles the C program that steps MuJoCo."""
    package = Path(mujoco.__file__).parent
    library = next(package.glob("libmujoco.so*"))
    Path(folder, "peer.c").write_text(PEER)
    compiler = ["gcc", "-O2", "-I", package / "include", "-o", Path(folder, "peer"), Path(folder, "peer.c"), library]
    subprocess.run([*compiler, f"-Wl,-rpath,{package}"], check=True)
    return Path(folder, "peer")


def step_of_mujoco(peer, file, robot, folder):
    """Returns the instructions of a physics step."""
    model, data, _ = robots.model_of(file, robot)
    mujoco.mj_saveModel(model, str(Path(folder, "model.mjb")))
    Path(folder, "start").write_bytes(data.qpos.tobytes() + data.ctrl.tobytes())
    run = [peer, Path(folder, "model.mjb")]
    first, second = (counted([*run, str(round(s / robots.DT)), Path(folder, "start")], folder) for s in RUNS)
    return (second - first) / STEPS


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("robots", nargs="*", help="robots to count, all by default")
    arguments.add_argument("--program", type=Path, default=Path("target/release/tatu"))
    options = arguments.parse_args()
    print("| robot | MuJoCo, thousand instructions | Tatu | ratio |\n|---|---:|---:|---:|")
    with tempfile.TemporaryDirectory() as folder:
        peer = peer_program(folder)
        for name in options.robots or robots.ROBOTS:
            robot = robots.ROBOTS[name]
            file = robots.path_of(robot, folder)
            theirs = step_of_mujoco(peer, file, robot, folder)
            own = step_of_tatu(options.program.resolve(), file, robot, folder)
            print(f"| {name} | {theirs / 1e3:.1f} | {own / 1e3:.1f} | {theirs / own:.2f} |", flush=True)


if __name__ == "__main__":
    main()
