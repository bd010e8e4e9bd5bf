"""A sweep over a Ray cluster, one machine of which dies in the middle."""

import os
import sys
import threading
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from ray_cluster import ADDRESS, JOIN, Cluster, NotAllowed, run_in_namespaces, wait_for  # noqa: E402

SCENE = Path(__file__).parents[3] / "scenes/first/pioneer_avoids_walls.toml"
JOBS = 300


def test_a_machine_dies_and_the_rows_are_those_of_one_process(tmp_path):
    pytest.importorskip("ray", reason="Ray is not installed")
    pytest.importorskip("pyarrow", reason="PyArrow is not installed")
    import tatu_sim

    package = Path(tatu_sim.__file__).parent.parent
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(package), os.environ.get("PYTHONPATH", "")])}
    out = tmp_path / "rows.parquet"
    try:
        command = [sys.executable, __file__, str(out)]
        done = run_in_namespaces(command, env=environment, capture_output=True, timeout=600)
    except NotAllowed as e:
        pytest.skip(str(e))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "the rows are the same" in done.stdout, done.stdout + done.stderr
    assert len(tatu_sim.Rows.read(out)) == JOBS


def inside(out: Path) -> None:
    """The part of the test that runs in the namespaces."""
    import tatu_sim

    way = {"object": "/Pioneer_p3dx", "field": "object.world_pose", "index": 0, "over": "way"}
    jobs = [
        tatu_sim.Job(2.0, seed=seed, set={"/Pioneer_p3dx.sonar_range_m": reach}, metrics={"way": way})
        for seed in range(JOBS // 3)
        for reach in (1.0, 2.0, 3.0)
    ]
    serial = tatu_sim.sweep(jobs, SCENE, check=0.0)
    cluster = Cluster(workers=2)
    executor = tatu_sim.ray_executor(ADDRESS, max_retries=5, **JOIN)
    journal = out.with_name(out.name + ".jsonl")
    rows_at_death = []

    def die() -> None:
        def written() -> int:
            return journal.read_bytes().count(b"\n") if journal.exists() else 0

        wait_for(lambda: written() >= JOBS // 10)
        cluster.kill(2)
        rows_at_death.append(written())

    killer = threading.Thread(target=die)
    killer.start()
    with executor:
        rows = tatu_sim.sweep(jobs, SCENE, executor=executor, output=out, check=0.05)
    killer.join()
    print(f"{rows_at_death[0]} of {JOBS} rows were there when a raylet was killed; processes: "
          f"{sorted({row['pid'] for row in rows})}")
    assert rows_at_death[0] < JOBS * 2 // 3, "the raylet was killed too late to be in the middle"
    assert len(rows) == JOBS and rows.without_machine() == serial.without_machine()
    print("the rows are the same")


if __name__ == "__main__":
    inside(Path(sys.argv[1]))
