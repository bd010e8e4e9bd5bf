"""What a sweep costs beyond its runs: jobs over Ray, with two workers of one CPU each, beside the same jobs run by one
plain process a core.

    python bench/sweep.py                  # 10,000 jobs of 1 s of simulation, in three turns
    python bench/sweep.py --quick          # 1,000 jobs, one turn

Needs `tatu_sim` and `ray`. Everything runs in namespaces of its own, without a network (python/tests/ray_cluster.py).
Times include the start of the processes and the loading of plugins, but not the start of the cluster.
"""

import argparse
import os
import resource
import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).absolute().parents[1]
sys.path.insert(0, str(ROOT / "python/tests"))

from ray_cluster import ADDRESS, JOIN, Cluster, NotAllowed, run_in_namespaces  # noqa: E402

WORKERS = 2
METRICS = {
    "way": {"object": "/Pioneer_p3dx", "field": "object.world_pose", "index": 0, "over": "way"},
}


def jobs(args):
    from tatu_sim import Job

    return [Job(args.seconds, seed=seed, metrics=METRICS) for seed in range(args.jobs)]


def native(args):
    """The scene, without what `tatu_sim.sweep` puts around it."""
    from tatu_sim import _native
    from tatu_sim._world import setup

    scene = setup(args.scene, None, ".", None, None, None, (), (), (), 1, None)
    return _native.Sweep(_native.bundle(scene))


def plain(args):
    """One process of the comparison: every second job, one after the other, and nothing else."""
    from tatu_sim._sweep import job_json

    sweep = native(args)
    texts = [job_json(job) for job in jobs(args)[args.plain :: WORKERS]]
    begin = time.perf_counter()
    for text in texts:
        sweep.run(text)
    print(time.perf_counter() - begin)


def plain_processes(argv):
    """Wall time, the mean wall time of the loops alone, and CPU time, s."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.perf_counter()
    processes = [
        subprocess.Popen([sys.executable, __file__, *argv, f"--plain={k}"], stdout=subprocess.PIPE, text=True)
        for k in range(WORKERS)
    ]
    loops = [float(p.communicate()[0]) for p in processes]
    wall = time.perf_counter() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, statistics.mean(loops), after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def parts(args):
    """Prints where the time of a job goes, in one process."""
    from tatu_sim._sweep import Job, job_json

    begin = time.perf_counter()
    sweep = native(args)
    opened = time.perf_counter() - begin
    times = {}
    for seconds in (0.0, args.seconds) * 5:
        texts = [job_json(Job(seconds, seed=seed, metrics=METRICS)) for seed in range(20)]
        begin = time.perf_counter()
        for text in texts:
            sweep.run(text)
        times.setdefault(seconds, []).append((time.perf_counter() - begin) / len(texts))
    load, whole = min(times[0.0]), min(times[args.seconds])
    print(
        f"a job of {args.seconds:g} s takes {1e3 * whole:.2f} ms: {1e3 * load:.2f} ms ({load / whole:.0%}) for loading "
        f"the scene, {1e3 * (whole - load):.2f} ms for the steps; opening the plugins took {1e3 * opened:.0f} ms, once "
        "a process"
    )


def inside(args, argv):
    import tatu_sim

    parts(args)
    cluster = Cluster(workers=WORKERS)
    ratios = []
    for turn in range(args.turns):
        wall, loops, cpu = plain_processes(argv)
        print(f"turn {turn + 1}: {WORKERS} plain processes {wall:7.2f} s, CPU {cpu:7.2f} s (loops alone {loops:.2f} s)")
        executor = tatu_sim.ray_executor(ADDRESS, **JOIN)
        cpu_before = cluster.cpu_seconds()
        begin = time.perf_counter()
        rows = tatu_sim.sweep(jobs(args), args.scene, executor=executor, check=0.0, output=args.output)
        ray_wall = time.perf_counter() - begin
        ray_cpu = cluster.cpu_seconds() - cpu_before
        executor.shutdown()
        ran = sum(row["wall_s"] for row in rows)
        print(
            f"        over Ray          {ray_wall:7.2f} s, CPU {ray_cpu:7.2f} s (jobs alone {ran / WORKERS:.2f} s): "
            f"{ray_wall / wall - 1:+.1%}, CPU {ray_cpu / cpu - 1:+.1%}"
        )
        assert len(rows) == args.jobs
        ratios.append(ray_wall / wall)
        if args.output:
            os.unlink(args.output)
    print(f"Ray costs {statistics.median(ratios) - 1:+.1%} beyond plain processes (median of {args.turns})")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=10_000)
    parser.add_argument("--seconds", type=float, default=1.0, help="simulation time of a job")
    parser.add_argument("--scene", default=str(ROOT / "scenes/first/pioneer_avoids_walls.toml"))
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--output", help="also write the rows to this file")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--plain", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.quick:
        args.jobs, args.turns = min(args.jobs, 1000), 1
    argv = [a for a in sys.argv[1:] if a != "--inside"]
    if args.plain is not None:
        plain(args)
    elif args.inside:
        inside(args, argv)
    else:
        try:
            sys.exit(run_in_namespaces([sys.executable, __file__, *argv, "--inside"]).returncode)
        except NotAllowed as e:
            sys.exit(str(e))


if __name__ == "__main__":
    main()
