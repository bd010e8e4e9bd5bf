"""The part of a sweep that runs in the workers: in this process, in a pool process, or on another machine."""

import hashlib
import multiprocessing
import os
import signal
import socket
import threading
import time
import zlib
from collections import OrderedDict
from pathlib import Path
from typing import Any, Dict, NamedTuple, Optional, Sequence, Tuple

from . import _native

#: A worker: host name, process id and thread id.
Worker = Tuple[str, int, int]

#: Maximum number of scenes that a process keeps open.
_MOST_OPEN = 2

_open: "OrderedDict[Tuple[int, str], Any]" = OrderedDict()
_lock = threading.Lock()
_driver = 0


class Bundle(NamedTuple):
    """A scene with all its files."""

    hash: str
    packed: bytes

    @classmethod
    def of(cls, text: str) -> "Bundle":
        data = text.encode()
        return cls(hashlib.sha256(data).hexdigest(), zlib.compress(data, 6))


class Work(NamedTuple):
    """A chunk of jobs and checks, each as key and JSON. A check is not run by the worker that is stored with it."""

    jobs: Sequence[Tuple[str, str]]
    checks: Sequence[Tuple[str, str, Optional[Worker]]] = ()
    record: Optional[str] = None
    stop_on_error: bool = False


class Ran(NamedTuple):
    """The result of a job: its row as JSON, or the error. `wall` is the duration in s of real time."""

    key: str
    row: Optional[str]
    error: Optional[Dict[str, Any]]
    wall: float


class Done(NamedTuple):
    """The result of a chunk. `left` contains the keys of the checks that this worker did not run."""

    worker: Worker
    ran: Sequence[Ran] = ()
    checked: Sequence[Ran] = ()
    left: Sequence[str] = ()
    #: The error, if the worker could not open the scene and therefore ran no job.
    refused: Optional[Dict[str, Any]] = None


def opened(bundle: Bundle) -> Any:
    """Return the scene, ready to run jobs. It remains open for later chunks."""
    # A process that was forked while a scene was open must open the scene again.
    place = os.getpid(), bundle.hash
    with _lock:
        sweep = _open.get(place)
        if sweep is None:
            sweep = _open[place] = _native.Sweep(zlib.decompress(bundle.packed).decode())
        _open.move_to_end(place)
        while len(_open) > _MOST_OPEN:
            (process, _), old = _open.popitem(last=False)
            if process == os.getpid():
                # Jobs of this scene that are still running are not affected.
                old.close()
    return sweep


def drives() -> None:
    """Mark this process as the driver, which distributes the jobs."""
    global _driver
    _driver = os.getpid()


def _leave_interrupts() -> None:
    """Ignore Ctrl-C in workers: all processes of a terminal receive it, but the driver decides how to end the sweep."""
    child = multiprocessing.parent_process() is not None
    if child and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def run(bundle: Bundle, work: Work) -> Done:
    """Run a chunk of jobs."""
    worker = socket.gethostname(), os.getpid(), threading.get_ident()
    if _driver != worker[1]:
        _leave_interrupts()
    try:
        sweep = opened(bundle)
    except _native.Error as e:
        return Done(worker, refused=error_data(e))
    ran = []
    for key, job in work.jobs:
        record = None if work.record is None else str(Path(work.record) / f"{key}.log")
        ran.append(_one(sweep, key, job, record))
        if ran[-1].error and work.stop_on_error:
            return Done(worker, ran, left=[key for key, *_ in work.checks])
    mine = [check for check in work.checks if check[2] != worker]
    left = [check[0] for check in work.checks if check[2] == worker]
    return Done(worker, ran, [_one(sweep, key, job, None) for key, job, _ in mine], left)


def _one(sweep: Any, key: str, job: str, record: Optional[str]) -> Ran:
    begin = time.perf_counter()
    try:
        row, error = sweep.run(job, record), None
    except _native.Error as e:
        row, error = None, error_data(e)
    return Ran(key, row, error, time.perf_counter() - begin)


def error_data(e: BaseException) -> Dict[str, Any]:
    """Convert an error to data that any executor can transfer."""
    names = ("code", "text", "help", "file", "line")
    return {"message": str(e), **{name: getattr(e, name, None) for name in names}}


def error(data: Dict[str, Any], prefix: str = "", kind: type = _native.Error) -> BaseException:
    """Convert the result of `error_data` back to an error."""
    e = kind(prefix + data["message"])
    for name in ("code", "text", "help", "file", "line"):
        setattr(e, name, data.get(name))
    return e
