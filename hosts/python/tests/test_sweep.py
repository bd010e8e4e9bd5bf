"""Sweeps in one process and in pools: the same rows, resumed, checked, and written."""

import json
import multiprocessing
import os
import random
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import pytest

import tatu_sim
from tatu_sim import CheckError, Job, Rows, _native, _sweep, _sweep_worker
from tatu_sim._sweep_rows import plain

SCENE = """
format = 1
[[object]]
kind = "shape"
alias = "floor"
primitive = "plane"
respondable = true
[[object]]
kind = "shape"
alias = "ball"
primitive = "sphere"
size_m = [0.2, 0.2, 0.2]
position_m = [0.0, 0.0, 1.0]
initial_velocity_m_s = [0.3, 0.0, 0.0]
dynamic = true
respondable = true
[[object]]
kind = "sensor"
sensor = "gps"
alias = "gps"
parent = "/ball"
noise = { position = { sigma = 0.1 } }
"""
METRICS = {
    "way": {"object": "/ball", "field": "object.world_pose", "index": 0, "over": "way"},
    "gps_x": {"object": "/ball/gps", "field": "gps.position", "index": 0},
}
SPEEDS = [[0.5, 0, 0], [1, 0, 0.25], [2, 0.5, 1]]


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "ball.toml"
    path.write_text(SCENE)
    return path


def jobs(seeds=range(4), seconds=0.5):
    return [
        Job(seconds, seed=seed, set={"/ball.initial_velocity_m_s": speed}, metrics=METRICS)
        for speed in SPEEDS
        for seed in seeds
    ]


def package_path():
    return {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}


def command_line(*args, **kwargs):
    command = [sys.executable, "-m", "tatu_sim", *map(str, args)]
    return subprocess.run(command, capture_output=True, text=True, env=package_path(), **kwargs)


def sweep_file(folder, scene):
    path = folder / "sweep.toml"
    inline = {name: ", ".join(f"{k} = {json.dumps(v)}" for k, v in metric.items()) for name, metric in METRICS.items()}
    metrics = "\n".join(f"{name} = {{ {text} }}" for name, text in inline.items())
    path.write_text(
        f"scene = {json.dumps(str(scene))}\nseconds = 0.5\nseeds = {{ first = 0, count = 4 }}\n"
        f'[grid]\n"/ball.initial_velocity_m_s" = {json.dumps(SPEEDS)}\n[metrics]\n{metrics}\n'
    )
    return path


# ------------------------------------------------------------------------------------------------------- the same rows


def test_rows_are_the_same_wherever_they_are_made(scene, tmp_path):
    serial = tatu_sim.sweep(jobs(), scene, check=0.0)
    assert len(serial) == 12 and len({row["hash"] for row in serial}) == 3
    assert len({row["metrics"]["gps_x"] for row in serial}) > 3, "the seed has an effect"
    assert serial[0]["steps"] == 10 and serial[0]["faults"] == 0
    assert [row["key"] for row in serial] == sorted(row["key"] for row in serial)
    assert serial[serial.keys[3]]["seed"] == 3, "keys are in the order of the jobs"
    with ThreadPoolExecutor(3) as pool:
        threads = tatu_sim.sweep(jobs(), scene, executor=pool, check=1.0)
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        spawned = tatu_sim.sweep(jobs(), scene, executor=pool, check=1.0)
        # The workers have already opened the scene.
        again = tatu_sim.sweep(jobs(range(4, 8)), scene, executor=pool)
    assert {row["pid"] for row in spawned}.isdisjoint({os.getpid()})
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("fork")) as pool:
        forked = tatu_sim.sweep(jobs(), scene, executor=pool, check=0.5)
    for rows in (threads, spawned, forked):
        assert rows.without_machine() == serial.without_machine() and rows.keys == serial.keys
    assert again.without_machine() == tatu_sim.sweep(jobs(range(4, 8)), scene).without_machine()


def test_rows_are_those_of_the_command_line(scene, tmp_path):
    file, out = sweep_file(tmp_path, scene), tmp_path / "cli.jsonl"
    done = command_line("sweep", file, "--output", out)
    assert done.returncode == 0, done.stderr
    serial = tatu_sim.sweep(jobs(), scene)
    assert Rows.read(out).without_machine() == serial.without_machine()
    # The command line and the module can continue each other's sweeps.
    before = out.read_text()
    assert tatu_sim.sweep(jobs(), scene, output=out).without_machine() == serial.without_machine()
    assert {row["host"] for row in Rows.read(out)} == {json.loads(before.splitlines()[0])["host"]}
    done = command_line("sweep", file, "--output", out)
    assert "12 of 12 jobs are done already" in done.stdout + done.stderr


def test_shards_of_an_array_are_joined(scene, tmp_path):
    file = sweep_file(tmp_path, scene)
    parts = [tmp_path / f"rows-{n}.jsonl" for n in range(3)]
    for n, part in enumerate(parts):
        assert command_line("sweep", file, "--shard", f"{n}/3", "--output", part).returncode == 0
    rows = Rows.read(*parts)
    serial = tatu_sim.sweep(jobs(), scene)
    assert rows.without_machine() == serial.without_machine()
    damaged = json.loads(parts[0].read_text().splitlines()[0])
    parts[1].write_text(json.dumps({**damaged, "hash": "0" * 16}) + "\n")
    with pytest.raises(CheckError, match="hash differ"):
        Rows.read(*parts)


@pytest.mark.skipif(not hasattr(_native, "plan"), reason="the native part does not read sweep files yet")
def test_a_sweep_file_is_read(scene, tmp_path):
    serial = tatu_sim.sweep(jobs(), scene)
    rows = tatu_sim.sweep(sweep_file(tmp_path, scene))
    assert rows.without_machine() == serial.without_machine() and rows.keys == serial.keys
    with pytest.raises(TypeError, match="names its scene"):
        tatu_sim.sweep(sweep_file(tmp_path, scene), scene)


def test_equal_jobs_are_run_once(scene, monkeypatch):
    ran = count_runs(monkeypatch)
    plain_job = {"seconds": 0.1, "seed": 1, "set": {"/ball.mass_kg": 2.0}}
    same = [plain_job, Job(0.1, seed=1, set={"/ball.mass_kg": 2.00}), dict(reversed(list(plain_job.items())))]
    rows = tatu_sim.sweep([*same, Job(0.1, seed=2)], scene, check=0.0)
    assert len(rows) == 2 and len(ran) == 2 and len(rows.keys) == 4 and len(set(rows.keys[:3])) == 1


# ---------------------------------------------------------------------------------------------------------- resuming


DRIVER = """
import sys, tatu_sim
sys.path.insert(0, {tests!r})
from test_sweep import jobs
tatu_sim.sweep(jobs(range(250)), {scene!r}, output={out!r}, check=0.02)
"""


@pytest.mark.parametrize("name", ["rows.jsonl", "rows.parquet"])
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_a_sweep_that_was_ended_is_continued(scene, tmp_path, name, how, monkeypatch):
    if name.endswith(".parquet"):
        pytest.importorskip("pyarrow")
    out = tmp_path / name
    code = DRIVER.format(tests=str(Path(__file__).parent), scene=str(scene), out=str(out))
    driver = subprocess.Popen([sys.executable, "-c", code], env=package_path(), stderr=subprocess.PIPE, text=True)
    journal = out if name.endswith(".jsonl") else tmp_path / f"{name}.jsonl"
    end = time.monotonic() + 60
    while not journal.exists() or journal.read_bytes().count(b"\n") < 20:
        assert driver.poll() is None and time.monotonic() < end
        time.sleep(0.01)
    driver.send_signal(how)
    _, errors = driver.communicate(timeout=30)
    assert driver.returncode != 0
    if how == signal.SIGINT:
        assert "the same call continues it" in errors and "KeyboardInterrupt" in errors
        assert out.exists()
    found = Rows.read(out if out.exists() else journal)
    assert 20 <= len(found) < 750
    ran = count_runs(monkeypatch)
    rows = tatu_sim.sweep(jobs(range(250)), scene, output=out, check=0.0)
    assert len(rows) == 750 and len(ran) == 750 - len(found)
    assert sum(row["pid"] == driver.pid for row in rows) == len(found)
    assert Rows.read(out) == rows
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(["ball.toml", name]), "nothing else is left"
    monkeypatch.undo()
    some = random.Random(0).sample(jobs(range(250)), 20)
    assert all(plain(rows[row["key"]]) == plain(row) for row in tatu_sim.sweep(some, scene))


def test_a_damaged_output(scene, tmp_path, caplog, monkeypatch):
    out = tmp_path / "rows.jsonl"
    whole = tatu_sim.sweep(jobs(), scene, output=out, check=0.0)
    data = out.read_bytes()
    for damaged in (data[:-30], data[:-1], data[:-30] + b"\0" * 20 + b"\n"):
        out.write_bytes(damaged)
        caplog.clear()
        with monkeypatch.context() as patch:
            ran = count_runs(patch)
            rows = tatu_sim.sweep(jobs(), scene, output=out, check=0.0)
        assert rows.without_machine() == whole.without_machine() and len(ran) == 1
        assert "its last line is incomplete and is removed" in caplog.text
    out.write_bytes(data.replace(b'"key"', b'"kex"', 1))
    with pytest.raises(ValueError, match="line 1: this is not a row of a sweep"):
        tatu_sim.sweep(jobs(), scene, output=out)
    with pytest.raises(ValueError, match="ends with .jsonl or .parquet"):
        tatu_sim.sweep(jobs(), scene, output=tmp_path / "rows.csv")


def test_two_sweeps_do_not_write_one_file(scene, tmp_path):
    from tatu_sim._sweep_rows import Output

    first = Output(tmp_path / "rows.jsonl")
    with pytest.raises(BlockingIOError, match="another sweep is writing this file"):
        tatu_sim.sweep(jobs(), scene, output=tmp_path / "rows.jsonl")
    first.finish()
    assert len(tatu_sim.sweep(jobs(), scene, output=tmp_path / "rows.jsonl")) == 12


def test_a_dead_driver_leaves_no_lock(scene, tmp_path):
    out = tmp_path / "rows.jsonl"
    code = (
        "import os, signal, sys, multiprocessing, tatu_sim\n"
        "from concurrent.futures import ProcessPoolExecutor\n"
        f"sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from test_sweep import jobs\n"
        "from tatu_sim._sweep_run import Run\n"
        "def keep(self, rows):\n"
        "    print(*multiprocessing.active_children(), flush=True)\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
        "Run.keep = keep\n"
        "pool = ProcessPoolExecutor(2, mp_context=multiprocessing.get_context('fork'))\n"
        f"tatu_sim.sweep(jobs(), {str(scene)!r}, executor=pool, output={str(out)!r})\n"
    )
    driver = subprocess.Popen(
        [sys.executable, "-c", code], env=package_path(), stdout=subprocess.PIPE, text=True, start_new_session=True
    )
    line = driver.stdout.readline()
    driver.wait(timeout=60)
    try:
        assert driver.returncode == -signal.SIGKILL and "ForkProcess" in line
        assert len(tatu_sim.sweep(jobs(), scene, output=out)) == 12
    finally:
        # Processes of a pool do not notice the death of their parent.
        for pid in re.findall(r"pid=(\d+)", line) or re.findall(r"ForkProcess\(.*?(\d+)", line):
            os.kill(int(pid), signal.SIGKILL)


def test_rows_of_other_jobs_stay_in_the_file(scene, tmp_path):
    out = tmp_path / "rows.jsonl"
    tatu_sim.sweep(jobs(range(2)), scene, output=out)
    assert len(tatu_sim.sweep(jobs(range(1, 3)), scene, output=out)) == 6
    assert len(Rows.read(out)) == 9


# ------------------------------------------------------------------------------------------------------------- checks


def test_the_share_that_is_run_again(scene):
    keys = [f"{n:032x}" for n in range(10_000)]
    chosen = [_sweep.drawn(key, 0.01, 0) for key in keys]
    assert 60 < sum(chosen) < 140 and chosen == [_sweep.drawn(key, 0.01, 0) for key in keys]
    assert chosen != [_sweep.drawn(key, 0.01, 1) for key in keys]
    assert all(_sweep.drawn(key, 1.0, 0) for key in keys) and not any(_sweep.drawn(key, 0.0, 0) for key in keys)


def test_a_row_that_differs_is_found(scene, tmp_path, monkeypatch):
    class Faulty:
        def __init__(self, native):
            self.native, self.count = native, 0
            self.key = native.key

        def run(self, job, record=None):
            row = json.loads(self.native.run(job, record))
            self.count += 1
            if row["seed"] == 2:
                row["hash"] = f"{self.count:016x}"
            return json.dumps(row)

    faulty = wrap(monkeypatch, Faulty)
    out = tmp_path / "rows.jsonl"
    with ThreadPoolExecutor(2) as pool, pytest.raises(CheckError, match="gave different rows: hash differ") as caught:
        tatu_sim.sweep(jobs(), scene, executor=pool, check=1.0, output=out)
    assert isinstance(caught.value, tatu_sim.Error) and faulty
    a, b = caught.value.rows
    assert a["seed"] == b["seed"] == 2 and a["hash"] != b["hash"] and a["host"] in str(caught.value)
    assert a["key"] not in {row["key"] for row in Rows.read(out)}, "a row in doubt is not written"
    with ThreadPoolExecutor(2) as pool:
        assert len(tatu_sim.sweep(jobs(), scene, executor=pool, check=0.0, output=out)) == 12


def test_a_script_that_reads_files_is_found(scene, tmp_path, monkeypatch):
    script = tmp_path / "count.lua"
    script.write_text(
        """
        function sysCall_init()
            local file = io.open('count.txt', 'a+')
            file:write('x')
            file:seek('set', 0)
            sim.setObjectPosition(sim.getObject('/ball'), -1, {#file:read('a'), 0, 1})
            file:close()
        end
        """
    )
    monkeypatch.chdir(tmp_path)
    counted = [Job(0.1, seed=s) for s in range(3)]
    rows = tatu_sim.sweep(counted, scene, scripts={"/ball": script}, check=0.0)
    if any(row["faults"] for row in rows):
        pytest.skip("scripts of a sweep cannot write files")
    with pytest.raises(CheckError, match="does a script use anything besides the scene"):
        tatu_sim.sweep(counted, scene, scripts={"/ball": script}, check=1.0)


def test_checks_are_run_by_another_process(scene, tmp_path):
    seen = []

    class Pool(ProcessPoolExecutor):
        def submit(self, fn, *args):
            future = super().submit(fn, *args)
            future.add_done_callback(lambda done: seen.append(done.result()))
            return future

    with Pool(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        # A worker that starts late, on a busy machine, would leave checks to the other one.
        up = set()
        while len(up) < 2:
            up |= {f.result() for f in [ProcessPoolExecutor.submit(pool, os.getpid) for _ in range(4)]}
        tatu_sim.sweep(jobs(range(30)), scene, executor=pool, check=0.3)
    first = {ran.key: done.worker for done in seen for ran in done.ran}
    second = {ran.key: done.worker for done in seen for ran in done.checked}
    assert len(second) > 10 and all(first[key] != worker for key, worker in second.items())


# ------------------------------------------------------------------------------------------------------------- errors


def test_errors_of_jobs(scene, tmp_path):
    bad = Job(0.1, metrics={"x": {"object": "/bal", "field": "object.world_pose"}})
    all_jobs = [*jobs(range(2)), bad]
    out = tmp_path / "rows.jsonl"
    expected = r"(?s)the job [0-9a-f]{32} \(seed None, set \{\}\): .*metric `x`"
    with pytest.raises(tatu_sim.Error, match=expected) as caught:
        tatu_sim.sweep(all_jobs, scene, output=out)
    assert caught.value.code == "E102"
    rows = tatu_sim.sweep(all_jobs, scene, on_error="row", output=out)
    assert len(rows) == 7 and len(rows.errors) == 1 and "metric `x`" in rows.errors[0]["error"]
    # A job that failed is tried again, and its row is replaced once it works.
    assert len(Rows.read(out).errors) == 1
    with pytest.raises(tatu_sim.Error, match="metric `x`"):
        tatu_sim.sweep(all_jobs, scene, output=out)
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        with pytest.raises(tatu_sim.Error, match="metric `x`"):
            tatu_sim.sweep(all_jobs, scene, executor=pool)
        pooled = tatu_sim.sweep(all_jobs, scene, executor=pool, on_error="row")
    assert pooled.without_machine() == rows.without_machine()


def test_wrong_arguments(scene):
    with pytest.raises(tatu_sim.Error, match="job 1: .*sed"):
        tatu_sim.sweep([{"seconds": 1}, {"seconds": 1, "sed": 3}], scene)
    with pytest.raises(ValueError, match="expected a finite number"):
        tatu_sim.sweep([Job(1.0, set={"/ball.mass_kg": float("inf")})], scene)
    with pytest.raises(TypeError, match="expected a number, str"):
        tatu_sim.sweep([Job(1.0, set={"/ball.mass_kg": object()})], scene)
    with pytest.raises(ValueError, match="on_error"):
        tatu_sim.sweep([], scene, on_error="ignore")
    with pytest.raises(ValueError, match="no executor 'dask'"):
        tatu_sim.sweep([], scene, executor="dask")
    assert len(tatu_sim.sweep([], scene)) == 0


def kill_itself(*_):
    os.kill(os.getpid(), signal.SIGKILL)


def test_a_process_that_dies(scene, tmp_path, monkeypatch):
    out = tmp_path / "rows.jsonl"
    monkeypatch.setattr("tatu_sim._sweep_run.run", kill_itself)
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        with pytest.raises(tatu_sim.Error, match="a worker process died"):
            tatu_sim.sweep(jobs(), scene, executor=pool, output=out)


def test_a_metric_of_several_values_must_select_or_combine_them(scene):
    pose = {"object": "/ball", "field": "object.world_pose"}
    with pytest.raises(tatu_sim.Error, match="7 elements, but a metric is one number"):
        tatu_sim.sweep([Job(0.1, metrics={"x": pose})], scene)
    (row,) = tatu_sim.sweep([Job(0.1, metrics={"x": {**pose, "reduce": "first"}, "y": {**pose, "index": 0}})], scene)
    assert row["metrics"]["x"] == row["metrics"]["y"]


def test_a_sweep_file_that_does_not_exist_is_named(tmp_path):
    with pytest.raises(tatu_sim.Error, match="nosweep.toml"):
        tatu_sim.sweep(tmp_path / "nosweep.toml")


# ------------------------------------------------------------------------------------------------------- tables, logs


def test_tables(scene, tmp_path):
    pa = pytest.importorskip("pyarrow")
    some = [
        Job(0.1, seed=2**64 - 1, set={"/ball.mass_kg": 2}, metrics=METRICS),
        Job(0.1, set={"/ball.mass_kg": 2.5, "/ball.position_m": [0, 0, 2.0], "/ball.noise": True}),
        Job(0.1, set={"/ball.alias": "ball"}),
        Job(0.1, set={"/ball.alias": 3}),
    ]
    rows = tatu_sim.sweep(some, scene, on_error="row")
    table = rows.to_arrow()
    assert table.column_names == [
        "key", "seed", "set./ball.alias", "set./ball.mass_kg", "set./ball.noise", "set./ball.position_m", "steps",
        "time", "metric.gps_x", "metric.way", "hash", "faults", "error", "wall_s", "host", "pid",
    ]
    types = {field.name: field.type for field in table.schema}
    assert types["seed"] == pa.uint64() and types["set./ball.mass_kg"] == pa.float64()
    for name in ("a.parquet", "a.jsonl"):
        rows.write(tmp_path / name)
        read = Rows.read(tmp_path / name)
        assert read.to_arrow().equals(table)
        assert [row["set"] for row in read] == [row["set"] for row in rows]
    assert rows.without_machine().to_arrow().column_names[-1] == "error"


def test_logs_repeat_the_runs(scene, tmp_path):
    rows = tatu_sim.sweep(jobs(range(1)), scene, record=tmp_path / "logs", check=1.0)
    for row in rows:
        done = command_line("run", "--replay", tmp_path / "logs" / f"{row['key']}.log")
        assert done.returncode == 0 and row["hash"] in done.stdout + done.stderr, done.stdout + done.stderr


def test_no_heavy_module_is_imported():
    code = "import sys, tatu_sim; assert not {'ray', 'pyarrow', 'multiprocessing'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, env=package_path())
    code = "import sys, tatu_sim; tatu_sim.sweep; assert not {'ray', 'pyarrow'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, env=package_path())


def test_progress_is_shown_in_one_line(scene, capsys):
    tatu_sim.sweep(jobs(range(20)), scene, progress=True)
    assert "60 of 60 jobs" in capsys.readouterr().err


# -------------------------------------------------------------------------------------------------------------- helpers


def wrap(monkeypatch, kind):
    """Wraps the native part of sweeps in `kind`; returns the list of wrappers created so far."""
    made = []
    opened = _sweep_worker.opened

    def other(bundle):
        native = opened(bundle)
        if not made:
            made.append(kind(native))
        return made[0]

    monkeypatch.setattr(_sweep_worker, "opened", other)
    return made


def count_runs(monkeypatch):
    """Returns a list to which each job that is run in this process is appended."""
    ran = []

    class Counted:
        def __init__(self, native):
            self.native = native

        def run(self, job, record=None):
            ran.append(job)
            return self.native.run(job, record)

    wrap(monkeypatch, Counted)
    return ran
