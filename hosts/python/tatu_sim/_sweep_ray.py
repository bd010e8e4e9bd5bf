"""An executor that runs the jobs of sweeps on Ray."""

import os
from concurrent.futures import Executor, Future, InvalidStateError
from typing import Any, Callable, Dict, Optional

try:
    import ray
except ImportError as e:
    raise ImportError('Ray is not installed; run `pip install "tatu-sim[ray]"` on all machines of the cluster') from e


def ray_executor(
    address: Optional[str] = None,
    *,
    max_retries: int = 5,
    cpus: float = 1.0,
    scheduling_strategy: Any = "SPREAD",
    **init: Any,
) -> "RayExecutor":
    """Create an executor that runs jobs on a Ray cluster, on whose machines this version of `tatu_sim` is installed.

    Args:
        address: The cluster, such as `"10.0.0.1:6379"`; by default the one that `ray.init()` finds, or a new one on
            this machine. It has no effect if Ray is already initialized.
        max_retries: Number of times a chunk of jobs is retried after its machine or process has died.
        cpus: Number of CPUs per worker.
        scheduling_strategy: The strategy by which Ray places the workers.
        init: Further arguments of `ray.init`, such as `runtime_env`.
    """
    return RayExecutor(address, max_retries, cpus, scheduling_strategy, init)


class Task(Future):
    """A Ray task with the interface of a future."""

    def __init__(self, ref: Any):
        super().__init__()
        self.ref = ref
        ref.future().add_done_callback(self._ended)

    def _ended(self, of_ray: "Future[Any]") -> None:
        try:
            e = of_ray.exception()
            if e is None:
                self.set_result(of_ray.result())
            else:
                self.set_exception(e)
        except InvalidStateError:
            pass  # The future was cancelled.

    def cancel(self) -> bool:
        if not super().cancel():
            return False
        ray.cancel(self.ref)
        return True


class RayExecutor(Executor):
    """A `concurrent.futures` executor on a Ray cluster: see `ray_executor`."""

    def __init__(self, address: Optional[str], max_retries: int, cpus: float, strategy: Any, init: Dict[str, Any]):
        self._connected = not ray.is_initialized()
        if self._connected:
            # Usage statistics are off unless the user enables them. This only affects a cluster that is started here.
            os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
            ray.init(address=address, **{"log_to_driver": False, **init})
        self._cpus = cpus
        self._options = {"num_cpus": cpus, "max_retries": max_retries, "scheduling_strategy": strategy}
        self._remote: Dict[Callable[..., Any], Any] = {}
        self._tasks: Dict[Task, None] = {}
        self._closed = False

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Task:
        """Run a function on the cluster. Arguments that `share` returned are sent once to each machine."""
        if self._closed:
            raise RuntimeError("the executor was shut down")
        if fn not in self._remote:
            self._remote[fn] = ray.remote(fn).options(**self._options)
        task = Task(self._remote[fn].remote(*args, **kwargs))
        self._tasks[task] = None
        task.add_done_callback(lambda done: self._tasks.pop(done, None))
        return task

    def share(self, value: Any) -> Any:
        """Put a value into the object store of the cluster, from which the machines read it."""
        return ray.put(value)

    def slots(self) -> int:
        """Return the number of workers that the cluster has room for; 0 if no machine has joined yet."""
        return int(ray.cluster_resources().get("CPU", 0.0) / max(self._cpus, 1e-3))

    def lost(self, e: BaseException) -> bool:
        """Return whether an error means that a task was lost with its process or machine."""
        known = ray.exceptions
        return isinstance(e, (known.WorkerCrashedError, known.NodeDiedError, known.OutOfMemoryError))

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Cancel the tasks (`cancel_futures`) or wait for them (`wait`), and disconnect from the cluster if this
        executor connected to it."""
        self._closed = True
        for task in list(self._tasks):
            if cancel_futures:
                task.cancel()
            elif wait:
                task.exception()
        if self._connected and ray.is_initialized():
            ray.shutdown()
