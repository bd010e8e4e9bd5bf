"""A Ray cluster for tests, in separate namespaces: it has no access to other processes or to the network, and ends with
the program that started it.

    done = run_in_namespaces([sys.executable, "program.py"])    # or raises `NotAllowed`
    cluster = Cluster()             # in that program: a head without CPUs, and workers of one CPU each
"""

import fcntl
import os
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, List, Set

ADDRESS = "127.0.0.1:6399"
#: Arguments of `ray_executor` for this cluster: without them, Ray requires a network, which the namespace
#: does not provide.
JOIN = {"_node_ip_address": "127.0.0.1", "logging_level": "ERROR"}

# With these settings, Ray detects within seconds that a machine has died.
HEALTH = {
    "RAY_health_check_period_ms": "500",
    "RAY_health_check_failure_threshold": "3",
    "RAY_health_check_initial_delay_ms": "500",
    "RAY_health_check_timeout_ms": "500",
}


class NotAllowed(Exception):
    """Namespaces cannot be created on this machine."""


def run_in_namespaces(command: List[str], **kwargs: Any) -> "subprocess.CompletedProcess[str]":
    """Runs a command in new network and process namespaces; it may start a `Cluster`."""
    # The paths of Ray's sockets must be short.
    folder = tempfile.mkdtemp(prefix="ray", dir="/tmp")
    environment = {**(kwargs.pop("env", None) or os.environ), "TATU_TEST_RAY": folder}
    try:
        return subprocess.run([*in_namespaces(), *command], env=environment, text=True, **kwargs)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def in_namespaces() -> List[str]:
    """Returns the start of a command line that runs another command in new network and process namespaces."""
    reason = "there is no `unshare`"
    for user in [[], ["--map-root-user"]]:
        command = ["unshare", *user, "--net", "--pid", "--fork", "--mount-proc", "--kill-child"]
        try:
            tried = subprocess.run([*command, "true"], capture_output=True, text=True)
        except FileNotFoundError:
            break
        if tried.returncode == 0:
            return command
        reason = tried.stderr.strip()
    raise NotAllowed(f"cannot create network and process namespaces: {reason}")


class Cluster:
    """A head and workers, which end with this process."""

    def __init__(self, workers: int = 2):
        if os.getpid() != 1:
            # `ray stop` would stop processes of the whole machine. In a process namespace, all processes end with the
            # first one, so `ray stop` is not needed.
            raise RuntimeError("a cluster for tests is started as the first process of a process namespace")
        up("lo")
        # A token in the user's home folder would be used by some of Ray's processes and not by others.
        os.environ.update(HEALTH, RAY_USAGE_STATS_ENABLED="0", RAY_AUTH_MODE="disabled")
        self.raylets: List[int] = []
        port, folder = ADDRESS.split(":")[1], os.environ["TATU_TEST_RAY"]
        self.start("--head", f"--port={port}", "--num-cpus=0", "--include-dashboard=false", f"--temp-dir={folder}")
        for _ in range(workers):
            self.start(f"--address={ADDRESS}", "--num-cpus=1")

    def start(self, *arguments: str) -> None:
        before = raylets()
        common = ["--node-ip-address=127.0.0.1", "--disable-usage-stats", "--object-store-memory=100000000"]
        command = [sys.executable, "-m", "ray.scripts.scripts", "start", *arguments, *common]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120)
        if done.returncode != 0:
            raise RuntimeError(f"a node of Ray did not start:\n{done.stdout}{done.stderr}")
        self.raylets += sorted(raylets() - before)

    def kill(self, node: int) -> None:
        """Ends a node as a power failure does. Node 0 is the head."""
        os.kill(self.raylets[node], signal.SIGKILL)

    def cpu_seconds(self) -> float:
        """Returns the CPU time that all processes of the namespace have used so far, s."""
        ticks = 0
        for stat in Path("/proc").glob("[0-9]*/stat"):
            try:
                ticks += sum(map(int, stat.read_text().rpartition(")")[2].split()[11:13]))
            except OSError:
                continue  # The process has ended in the meantime.
        return ticks / os.sysconf("SC_CLK_TCK")


def raylets() -> Set[int]:
    """Returns the ids of the processes of Ray's nodes."""
    found = set()
    for comm in Path("/proc").glob("[0-9]*/comm"):
        try:
            if comm.read_text().strip() == "raylet":
                found.add(int(comm.parent.name))
        except OSError:
            continue
    return found


def up(interface: str) -> None:
    """Switches a network interface on, as `ip link set NAME up` does."""
    siocgifflags, siocsifflags, iff_up = 0x8913, 0x8914, 0x1
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
        request = struct.pack("16sh14x", interface.encode(), 0)
        flags = struct.unpack("16sh14x", fcntl.ioctl(s, siocgifflags, request))[1]
        fcntl.ioctl(s, siocsifflags, struct.pack("16sh14x", interface.encode(), flags | iff_up))


def wait_for(what, seconds: float = 60.0) -> None:
    """Waits until a function returns something true."""
    end = time.monotonic() + seconds
    while not what():
        if time.monotonic() > end:
            raise TimeoutError(f"{what} did not become true within {seconds} s")
        time.sleep(0.01)
