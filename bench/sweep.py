"""Measures the overhead of a sweep over Ray, with two workers of one CPU each, compared with the same jobs in one plain
process per core.

    python bench/sweep.py                  # 10,000 jobs of 1 s of simulation
    python bench/sweep.py --quick          # 1,000 jobs

Requires `tatu_sim` and `ray`. Everything runs in separate namespaces, without a network (hosts/python/tests/ray_cluster.py).
The two sides run alternately for half a second each, so other load on the machine affects both equally.
Times include opening the scene and Ray's start of its workers, but neither the start of the cluster nor imports.
"""

import argparse
import os
import select
import signal
import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).absolute().parents[1]
sys.path.insert(0, str(ROOT / "hosts/python/tests"))

from ray_cluster import ADDRESS, JOIN, Cluster, NotAllowed, run_in_namespaces  # noqa: E402

WORKERS = 2
TURN = 0.5  # s
# The first word of the line in which a program reports its result.
ANSWER = "answer"
#: A metric that exists in every scene.
METRICS = {"gravity": {"object": "", "field": "scene.gravity", "index": 2}}


def jobs(args):
    from tatu_sim import Job

    return [Job(args.seconds, seed=seed, metrics=METRICS) for seed in range(args.jobs)]


def native(args):
    """Returns the native sweep of the scene, without the wrapper `tatu_sim.sweep`."""
    from tatu_sim import _native
    from tatu_sim._world import setup

    scene = setup(args.scene, None, ".", None, None, None, (), (), (), 1, None)
    return _native.Sweep(_native.bundle(scene))


def ready():
    """Reports readiness, and waits for the start."""
    print("ready", flush=True)
    sys.stdin.readline()


def plain(args):
    """Runs a plain process, which does its share of the jobs one after the other."""
    from tatu_sim._sweep import job_json

    texts = [job_json(job) for job in jobs(args)[args.plain :: WORKERS]]
    ready()
    sweep = native(args)
    walls = []
    for text in texts:
        begin = time.perf_counter()
        sweep.run(text)
        walls.append(time.perf_counter() - begin)
    print(ANSWER, statistics.median(walls), flush=True)


def over_ray(args):
    """Runs the sweep in the process with Ray."""
    import tatu_sim

    all_jobs = jobs(args)
    executor = tatu_sim.ray_executor(ADDRESS, **JOIN)
    tatu_sim.sweep  # Triggers its lazy imports.
    ready()
    begin = time.process_time()
    rows = tatu_sim.sweep(all_jobs, args.scene, executor=executor, check=args.check, output=args.output)
    used = time.process_time() - begin
    assert len(rows) == args.jobs
    print(ANSWER, statistics.median(row["wall_s"] for row in rows), used, len({row["pid"] for row in rows}), flush=True)
    executor.shutdown()


class Side:
    """Programs that run at the same time, and the time for which they were not stopped, s."""

    def __init__(self, argv, *kinds):
        def start(kind):
            # Programs report failures on standard error.
            command = [sys.executable, __file__, *argv, kind]
            return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

        self.programs = [start(kind) for kind in kinds]
        for program in self.programs:
            assert program.stdout.readline() == "ready\n", "a program did not start"
        self.time, self.answers = 0.0, []

    def begin(self):
        for program in self.programs:
            program.stdin.write("go\n")
            program.stdin.flush()

    def let_run(self, seconds):
        begin = time.monotonic()
        waiting = {p.stdout: p for p in self.programs[len(self.answers) :]}
        while len(self.answers) < len(self.programs) and time.monotonic() < begin + seconds:
            # The order is irrelevant, because the measurement ends only when all have finished.
            stdout = next(iter(waiting))
            if select.select([stdout], [], [], max(0.0, begin + seconds - time.monotonic()))[0]:
                line = stdout.readline()
                assert line, "a program failed"
                # All other lines are output of Ray.
                if line.startswith(ANSWER):
                    self.answers.append(line.split()[1:])
                    waiting.pop(stdout)
        self.time += time.monotonic() - begin

    @property
    def done(self):
        return len(self.answers) == len(self.programs)


def signal_all(number, pids):
    for pid in pids:
        try:
            os.kill(pid, number)
        except ProcessLookupError:
            continue


def processes():
    return {int(name) for name in os.listdir("/proc") if name.isdigit()} - {os.getpid()}


def in_turns(args, argv):
    cluster = Cluster(workers=WORKERS)
    ray = Side(argv, "--over-ray")
    plain = Side(argv, *(f"--plain={k}" for k in range(WORKERS)))
    of_plain = {program.pid for program in plain.programs}
    sides = {plain: lambda: of_plain, ray: lambda: processes() - of_plain}
    for side, pids in sides.items():
        signal_all(signal.SIGSTOP, pids())
        side.begin()
    before = cluster.cpu_seconds()
    while not (ray.done and plain.done):
        for side, pids in sides.items():
            if not side.done:
                signal_all(signal.SIGCONT, pids())
                side.let_run(TURN)
                # The second pass also stops processes that were started during the first.
                for _ in range(2):
                    signal_all(signal.SIGSTOP, pids())
    cpu = cluster.cpu_seconds() - before
    signal_all(signal.SIGCONT, processes())
    job = statistics.mean(float(answer[0]) for answer in plain.answers)
    job_over_ray, driver, workers = map(float, ray.answers[0])
    print(f"{WORKERS} plain processes: {plain.time:.2f} s, the median job {1e3 * job:.2f} ms")
    print(f"over Ray, {workers:.0f} workers: {ray.time:.2f} s, the median job {1e3 * job_over_ray:.2f} ms; ", end="")
    print(f"CPU time of the driver {driver:.2f} s, of everything {cpu:.2f} s")
    print(f"Ray costs {ray.time / plain.time - 1:+.1%} beyond plain processes")


def parts(args):
    """Prints a breakdown of the time of a job, in one process."""
    from tatu_sim._sweep import Job, job_json

    begin = time.perf_counter()
    sweep = native(args)
    opened = time.perf_counter() - begin
    times = {}
    for seconds in (0.0, args.seconds) * 10:
        texts = [job_json(Job(seconds, seed=seed, metrics=METRICS)) for seed in range(20)]
        begin = time.perf_counter()
        for text in texts:
            sweep.run(text)
        times.setdefault(seconds, []).append((time.perf_counter() - begin) / len(texts))
    load, whole = min(times[0.0]), min(times[args.seconds])
    print(f"a job of {args.seconds:g} s takes {1e3 * whole:.2f} ms: {1e3 * load:.2f} ms ({load / whole:.0%}) to load")
    print(f"the scene, {1e3 * (whole - load):.2f} ms for the steps; the plugins are opened in {1e3 * opened:.0f} ms")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=10_000)
    parser.add_argument("--seconds", type=float, default=1.0, help="simulation time of a job")
    parser.add_argument("--scene", default=str(ROOT / "scenes/first/pioneer_avoids_walls.toml"))
    parser.add_argument("--check", type=float, default=0.0, help="share of the jobs that Ray runs twice")
    parser.add_argument("--output", help="write the rows to this file, which must not exist")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--plain", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--over-ray", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.quick:
        args.jobs = min(args.jobs, 1000)
    argv = [a for a in sys.argv[1:] if a != "--inside"]
    if args.plain is not None:
        plain(args)
    elif args.over_ray:
        over_ray(args)
    elif args.inside:
        parts(args)
        in_turns(args, argv)
    else:
        try:
            sys.exit(run_in_namespaces([sys.executable, __file__, *argv, "--inside"]).returncode)
        except NotAllowed as e:
            sys.exit(str(e))


if __name__ == "__main__":
    main()
