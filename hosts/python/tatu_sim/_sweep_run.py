"""Distributes the jobs of a sweep to the workers of an executor, and collects their rows."""

import heapq
import json
import logging
import os
import sys
import time
from collections import deque
from concurrent.futures import BrokenExecutor, Executor, Future
from queue import Empty, SimpleQueue
from typing import Any, Callable, Deque, Dict, List, NamedTuple, Optional, Tuple

from . import _native
from ._sweep_rows import CheckError, Output, Row, plain
from ._sweep_worker import Bundle, Done, Ran, Work, Worker, error, run

logger = logging.getLogger("tatu_sim")

#: Target duration of a chunk, s: long compared with the overhead of a task, short compared with a sweep.
CHUNK = 0.75
#: Maximum number of jobs in a chunk.
MAX_JOBS = 10_000
#: Number of times a check that reaches the worker of the first run is submitted again (for about 5 s in total) before
#: that worker runs it.
TRIES = 20
#: Time to wait for the rows of running chunks when the sweep is interrupted, s.
GRACE = 2.0


class Planned(NamedTuple):
    """A job, and whether it must be run twice."""

    key: str
    text: str
    check: bool


class Check:
    """A job that must be run a second time; its row is written only if both runs yield the same row."""

    def __init__(self, job: Planned, row: Row, worker: Worker):
        self.job, self.row, self.worker = job, row, worker
        self.tries = 0


class Chunk(NamedTuple):
    """A chunk that was submitted to a worker."""

    jobs: List[Planned]
    checks: List[Check]


class Serial(Executor):
    """An executor that runs everything immediately in this process."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        future: "Future[Any]" = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as e:
            future.set_exception(e)
        return future


class Run:
    """A running sweep: its queued and pending jobs, and the rows collected so far."""

    def __init__(
        self, bundle: Bundle, executor: Executor, out: Optional[Output], on_error: str, record: Optional[str]
    ):
        self.executor, self.out, self.record = executor, out, record
        self.rows: Dict[str, Row] = {}
        self.stop_on_error = on_error == "raise"
        share = getattr(executor, "share", None)
        self.bundle = bundle if share is None else share(bundle)
        self.todo: Deque[Planned] = deque()
        self.checks: Deque[Check] = deque()
        # Checks that reached the worker of their first run, ordered by the time at which they are submitted again.
        self.later: List[Tuple[float, int, Check]] = []
        self.pending: Dict["Future[Done]", Chunk] = {}
        self.finished: "SimpleQueue[Future[Done]]" = SimpleQueue()
        #: Mean wall time of a job, s, and the largest chunk so far.
        self.wall: Optional[float] = None
        self.largest = 1
        self.synced = time.monotonic()
        self.slots, self.slots_at = 1, -1e9

    def warm_up(self) -> None:
        """Make the workers open the scene."""
        if not isinstance(self.executor, Serial):
            self.count_slots()
            for _ in range(self.slots):
                self.submit(Chunk([], []))

    def go(self, todo: List[Planned], rows: Dict[str, Row], progress: Optional[bool]) -> None:
        """Run the jobs, and add their rows to the existing ones."""
        self.todo.extend(todo)
        self.rows = rows
        total = len(todo) + len(rows)
        self.line = Line(total, len(rows), progress)
        try:
            if not todo:
                return
            while self.give() or self.later:
                wait = 0.5
                if not self.pending:
                    wait = max(self.later[0][0] - time.monotonic(), 0.0)
                try:
                    self.take(self.finished.get(timeout=wait))
                except Empty:
                    pass
                self.line.show(self.rows)
        except BaseException as e:
            self.abandon()
            self.line.end(self.rows)
            if self.out is not None:
                logger.warning(
                    "the sweep was interrupted (%s) after %d of %d rows, which are in %s: the same call continues it",
                    type(e).__name__, len(self.rows), total, self.out.path,
                )
            raise
        finally:
            self.line.end(self.rows)

    # ----------------------------------------------------------------------------------------------- submitting chunks

    def give(self) -> bool:
        """Submit chunks until each worker runs one and has another one queued. Return whether any chunk is pending."""
        self.count_slots()
        most = 1 if isinstance(self.executor, Serial) else 2 * self.slots
        now = time.monotonic()
        while self.later and self.later[0][0] <= now:
            self.checks.append(heapq.heappop(self.later)[2])
        while len(self.pending) < most and (self.todo or self.checks):
            # Chunks become smaller towards the end, so that all workers finish at about the same time.
            jobs = [self.todo.popleft() for _ in range(self.size(len(self.todo)))]
            checks = [self.checks.popleft() for _ in range(self.size(len(self.checks)))]
            self.submit(Chunk(jobs, checks))
        return bool(self.pending)

    def size(self, left: int) -> int:
        if self.wall is None:
            return min(left, 1)
        wanted = CHUNK / max(self.wall, 1e-6)
        fair = max(left / (2 * self.slots), 0.05 * wanted)
        return min(left, max(1, int(min(wanted, fair, 4 * self.largest, MAX_JOBS))))

    def count_slots(self) -> None:
        now = time.monotonic()
        if now < self.slots_at + 1.0:
            return
        # The number of workers may change when machines join or leave.
        slots = getattr(self.executor, "slots", None)
        known = slots() if callable(slots) else getattr(self.executor, "_max_workers", None)
        self.slots, self.slots_at = max(1, known or os.cpu_count() or 1), now

    def submit(self, chunk: Chunk) -> None:
        # A check should run on another worker, which may still be starting, so a worker repeats its own jobs only after
        # some seconds.
        alone = self.slots == 1
        checks = [(c.job.key, c.job.text, None if alone or c.tries >= TRIES else c.worker) for c in chunk.checks]
        jobs = [(job.key, job.text) for job in chunk.jobs]
        work = Work(jobs, checks, self.record, self.stop_on_error)
        try:
            future = self.executor.submit(run, self.bundle, work)
        except BrokenExecutor as e:
            self.lost(chunk, e)
            return
        self.pending[future] = chunk
        future.add_done_callback(self.finished.put)

    # -------------------------------------------------------------------------------------------------- collecting rows

    def take(self, future: "Future[Done]") -> None:
        chunk = self.pending.pop(future)
        try:
            done = future.result()
        except BaseException as e:
            self.lost(chunk, e)
            return
        if done.refused is not None:
            raise error(done.refused, f"on {done.worker[0]}: ")
        jobs = {job.key: job for job in chunk.jobs}
        checks = {check.job.key: check for check in chunk.checks}
        new: List[Row] = []
        first: Optional[Tuple[Ran, Row]] = None
        for ran in done.ran:
            row = row_of(ran, jobs[ran.key].text, done.worker)
            if ran.error is not None and self.stop_on_error:
                first = first or (ran, row)
            elif jobs[ran.key].check and ran.error is None:
                self.checks.append(Check(jobs[ran.key], row, done.worker))
            else:
                new.append(row)
        different: Optional[CheckError] = None
        for ran in done.checked:
            check = checks[ran.key]
            again = row_of(ran, check.job.text, done.worker)
            if plain(again) == plain(check.row):
                new.append(check.row)
            else:
                different = different or CheckError.of(check.row, again)
        for key in done.left:
            self.again(checks[key], counted=not chunk.jobs)
        self.keep(new)
        self.measure(done)
        if different is not None:
            raise different
        if first is not None:
            ran, row = first
            raise error(ran.error or {}, f"the job {ran.key} (seed {row['seed']}, set {json.dumps(row['set'])}): ")

    def again(self, check: Check, counted: bool) -> None:
        check.tries += counted
        when = time.monotonic() + 0.01 * 2 ** min(check.tries, 5)
        heapq.heappush(self.later, (when, id(check), check))

    def keep(self, rows: List[Row]) -> None:
        self.rows.update((row["key"], row) for row in rows)
        if self.out is not None and rows:
            self.out.write(rows)
            now = time.monotonic()
            if now > self.synced + 1.0:
                self.out.sync()
                self.synced = now

    def measure(self, done: Done) -> None:
        all_ran = [*done.ran, *done.checked]
        if all_ran:
            mean = sum(ran.wall for ran in all_ran) / len(all_ran)
            self.wall = mean if self.wall is None else 0.7 * self.wall + 0.3 * mean
            self.largest = max(self.largest, len(all_ran))

    def lost(self, chunk: Chunk, e: BaseException) -> None:
        """Handle a chunk whose worker has died."""
        lost = getattr(self.executor, "lost", None)
        if isinstance(e, BrokenExecutor):
            raise _native.Error(
                f"a worker process died ({e}); one of these jobs may have caused it: {', '.join(self.under_way(chunk))}"
            ) from e
        if not callable(lost) or not lost(e):
            raise e
        if not chunk.jobs and not chunk.checks:
            return
        if len(chunk.jobs) + len(chunk.checks) > 1:
            # One of the jobs may kill every worker, so each is submitted separately.
            for job in chunk.jobs:
                self.submit(Chunk([job], []))
            for check in chunk.checks:
                self.submit(Chunk([], [check]))
            return
        job = chunk.jobs[0] if chunk.jobs else chunk.checks[0].job
        text = f"no worker survived the job {job.key} ({job.text}): {e}"
        if self.stop_on_error or chunk.checks:
            raise _native.Error(text) from e
        self.keep([plain(row_of(Ran(job.key, None, {"message": text}, 0.0), job.text, ("", 0, 0)))])

    def under_way(self, chunk: Chunk) -> List[str]:
        chunks = [chunk, *self.pending.values()]
        return sorted(job.key for c in chunks for job in [*c.jobs, *(check.job for check in c.checks)])

    def cancel(self) -> None:
        """Cancel chunks that no worker has started yet."""
        for future in list(self.pending):
            future.cancel()

    def abandon(self) -> None:
        """Cancel queued chunks, and collect the rows of chunks that finish soon."""
        self.cancel()
        self.stop_on_error = False
        end = time.monotonic() + GRACE
        while self.pending and time.monotonic() < end:
            try:
                future = self.finished.get(timeout=max(end - time.monotonic(), 0.01))
            except Empty:
                break
            chunk = self.pending.pop(future, None)
            if chunk is None or future.cancelled() or future.exception() is not None:
                continue
            done, checked = future.result(), {job.key for job in chunk.jobs if job.check}
            texts = {job.key: job.text for job in chunk.jobs}
            rows = [row_of(r, texts[r.key], done.worker) for r in done.ran if r.error is None and r.key not in checked]
            self.keep(rows)


def row_of(ran: Ran, text: str, worker: Worker) -> Row:
    """Return the row of a finished job. The fields that depend on the machine come last."""
    if ran.row is not None:
        row = json.loads(ran.row)
    else:
        job = json.loads(text)
        row = {"key": ran.key, "seed": job.get("seed"), "set": job.get("set") or {}}
        row["error"] = (ran.error or {})["message"]
    return {**row, "wall_s": ran.wall, "host": worker[0], "pid": worker[1]}


class Line:
    """The progress line of a sweep on a terminal."""

    def __init__(self, total: int, found: int, shown: Optional[bool]):
        self.total, self.found = total, found
        self.shown = sys.stderr.isatty() if shown is None else shown
        self.begin = self.last = time.monotonic()
        # An explicitly requested line is always drawn, even if the sweep ends before the first update is due.
        self.drawn = bool(shown)

    def show(self, rows: Dict[str, Row], every: float = 0.2) -> None:
        now = time.monotonic()
        if not self.shown or now < self.last + every:
            return
        self.last = now
        rate = (len(rows) - self.found) / max(now - self.begin, 1e-9)
        left = f", {(self.total - len(rows)) / rate:.0f} s left" if rate > 0.0 else ""
        failed = sum("error" in row for row in rows.values()) if every == 0.0 else 0
        errors = f", {failed} failed" if failed else ""
        text = f"\r{len(rows)} of {self.total} jobs, {rate:.1f} a second{left}{errors}   "
        print(text, end="", file=sys.stderr, flush=True)
        self.drawn = True

    def end(self, rows: Dict[str, Row]) -> None:
        if self.drawn:
            self.show(rows, 0.0)
            self.shown = self.drawn = False
            print(file=sys.stderr)
