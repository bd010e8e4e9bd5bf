"""Sweeps: many runs of a scene, in this process, in a process pool or on many machines."""

import hashlib
import json
import math
import os
from collections.abc import Mapping as _Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field
from typing import Any, Dict, Iterable, List, Mapping, Optional, Tuple, Union

from . import _native
from ._sweep_rows import CheckError, Output, PathLike, Row, Rows
from ._sweep_run import Planned, Run, Serial
from ._sweep_worker import Bundle, drives, error, error_data, opened
from ._world import setup

__all__ = ["CheckError", "Job", "Rows", "sweep"]

# The encoder is reused, because `json.dumps` would create a new one for each call.
_encode = json.JSONEncoder(ensure_ascii=False, allow_nan=False).encode


@dataclass(frozen=True)
class Job:
    """A run of a scene.

    Args:
        seconds: Simulation time to run.
        seed: Seed of all random numbers; None: the scene's own.
        set: Changes to the scene, as for `World`: `{"/Robot.mass_kg": 9.5}`.
        metrics: Metrics of the run, as in sweep files: `{"way": {"object": "/Robot", "field": "object.world_pose",
            "index": 0, "over": "way"}}`.
    """

    seconds: float
    seed: Optional[int] = None
    set: Mapping[str, Any] = field(default_factory=dict)
    metrics: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


def sweep(
    jobs: Union[PathLike, Iterable[Union[Job, Mapping[str, Any]]]],
    scene: Optional[PathLike] = None,
    *,
    text: Optional[str] = None,
    folder: PathLike = ".",
    set: Optional[Mapping[str, Any]] = None,
    scripts: Optional[Mapping[str, PathLike]] = None,
    executor: Union[None, str, Executor] = None,
    output: Optional[PathLike] = None,
    check: float = 0.01,
    check_seed: int = 0,
    on_error: str = "raise",
    record: Optional[PathLike] = None,
    progress: Optional[bool] = None,
) -> Rows:
    """Run a scene many times, and return a row for each distinct job, sorted by key.

    The rows do not depend on the executor, apart from wall times, hosts and processes: see `Rows.without_machine`.

    Args:
        jobs: `Job`s or dicts with the same keys; or a sweep file, which names its scene.
        scene, text, folder, set, scripts: As for `World`, for all jobs.
        executor: None: run the jobs one after the other in this process. Any `concurrent.futures.Executor`, such as
            `ProcessPoolExecutor()`. `"ray"`: the Ray cluster that `ray.init()` finds; see also `ray_executor`.
        output: A file of rows, `.jsonl` or `.parquet`, which is filled while the sweep runs. Jobs whose rows it already
            contains are not run again, so that the same call continues an interrupted sweep.
        check: The fraction of jobs that are run twice, on different workers if possible, and must yield the same row.
        check_seed: Seed for the random choice of these jobs.
        on_error: The effect of a failed job: `"raise"` raises its error and ends the sweep, `"row"` adds a row with
            `error`.
        record: A folder in which each worker writes a log of each run, KEY.log, for `tatu run --replay`.
        progress: Show a progress line on standard error; by default on a terminal.

    Raises:
        Error: The scene or a job is invalid.
        CheckError: A job that was run twice yielded different rows.
    """
    if on_error not in ("raise", "row"):
        raise ValueError(f'`on_error` is {on_error!r}; expected "raise" or "row"')
    if not 0.0 <= check <= 1.0:
        raise ValueError(f"`check` is {check}; expected a fraction from 0 to 1")
    if isinstance(executor, str) and executor != "ray":
        raise ValueError(f'there is no executor {executor!r}; expected "ray" or an executor of concurrent.futures')
    if isinstance(jobs, (str, os.PathLike)):
        if scene is not None or text is not None:
            raise TypeError("a sweep file names its scene; `scene` and `text` must not be given")
        scene, texts = _native.plan(os.fspath(jobs))
    else:
        texts = map(job_json, jobs)
    drives()
    arguments = setup(scene, text, folder, None, set, scripts, (), (), None, (), 1, None)
    bundle = Bundle.of(_native.bundle(arguments))
    if record is not None:
        record = os.path.abspath(record)
        os.makedirs(record, exist_ok=True)
    out = None if output is None else Output(output)
    own = run = None
    try:
        if executor is None:
            executor = own = Serial()
        elif executor == "ray":
            from ._sweep_ray import ray_executor

            executor = own = ray_executor()
        run = Run(bundle, executor, out, on_error, record)
        # The workers open the scene while the jobs are being read here.
        run.warm_up()
        keys, planned = plan(bundle, texts, check, check_seed)
        rows: Dict[str, Row] = {}
        for key, job in planned.items():
            old = None if out is None else out.rows.get(key)
            if old is not None and "error" not in old:
                rows[key] = restored(old, job.text)
        run.go([job for key, job in planned.items() if key not in rows], rows, progress)
    finally:
        try:
            if run is not None:
                run.cancel()
            if out is not None:
                out.finish()
        finally:
            if own is not None:
                own.shutdown(wait=False)
    return Rows(rows.values(), keys)


def plan(bundle: Bundle, texts: Iterable[str], check: float, check_seed: int) -> Tuple[List[str], Dict[str, Planned]]:
    """Return the keys in the order of the jobs, and the distinct jobs."""
    native = opened(bundle)
    keys: List[str] = []
    planned: Dict[str, Planned] = {}
    for number, text in enumerate(texts):
        try:
            key = native.key(text)
        except _native.Error as e:
            raise error(error_data(e), f"job {number}: ") from None
        keys.append(key)
        if key not in planned:
            planned[key] = Planned(key, text, drawn(key, check, check_seed))
    return keys, planned


def drawn(key: str, share: float, seed: int) -> bool:
    """Return whether a job is run twice, which depends only on its key, the share and the seed."""
    digest = hashlib.sha256(f"{seed}:{key}".encode()).digest()
    return int.from_bytes(digest[:8], "big") < share * 2**64


def job_json(job: Union[Job, Mapping[str, Any]]) -> str:
    """Encode a job as JSON."""
    if isinstance(job, Job):
        job = vars(job)
    if not isinstance(job, _Mapping):
        raise TypeError(f"a job is a tatu_sim.Job or a dict, not a {type(job).__name__}")
    try:
        return _encode(job)
    except (TypeError, ValueError):
        return json.dumps(_simple(job, "job"), ensure_ascii=False)


def _simple(value: Any, where: str) -> Any:
    """Convert a value to types that JSON supports; NumPy types become Python types."""
    if isinstance(value, _Mapping):
        return {str(k): _simple(v, k) for k, v in value.items()}
    if hasattr(value, "tolist"):
        return _simple(value.tolist(), where)
    if isinstance(value, (list, tuple)):
        return [_simple(v, where) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"`{where}` is {value}; expected a finite number")
    if value is None or isinstance(value, (int, float, str)):
        return value
    raise TypeError(f"`{where}` is a {type(value).__name__}; expected a number, str, bool, list or dict")


def restored(row: Row, text: str) -> Row:
    """Return a row read from a file, with the parameters of the job instead of those of the file, whose types may have
    changed: a Parquet column of 8, 8.5 and 9.5 stores 8 as 8.0."""
    job = json.loads(text)
    row = {**row, "seed": job.get("seed"), "set": job.get("set") or {}}
    metrics = row.get("metrics") or {}
    row["metrics"] = {name: metrics.get(name) for name in sorted(job.get("metrics") or {})}
    return row
