"""A Ray cluster for tests in namespaces of its own: it sees no other process and no network, and ends with its program.

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
#: Arguments of `ray_executor` for this cluster: without them Ray looks for the network that it does not have.
JOIN = {"_node_ip_address": "127.0.0.1", "logging_level": "ERROR"}

# A machine that died is noticed within seconds.
HEALTH = {
    "RAY_health_check_period_ms": "500",
    "RAY_health_check_failure_threshold": "3",
    "RAY_health_check_initial_delay_ms": "500",
    "RAY_health_check_timeout_ms": "500",
}


class NotAllowed(Exception):
    """There can be no such namespaces here."""


def run_in_namespaces(command: List[str], **kwargs: Any) -> "subprocess.CompletedProcess[str]":
    """Runs a command in new network and process namespaces; it may start a `Cluster`."""
    # The names of Ray's sockets must be short.
    folder = tempfile.mkdtemp(prefix="ray", dir="/tmp")
    environment = {**(kwargs.pop("env", None) or os.environ), "TATU_TEST_RAY": folder}
    try:
        return subprocess.run([*in_namespaces(), *command], env=environment, text=True, **kwargs)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def in_namespaces() -> List[str]:
    """The beginning of a command line that runs another in new network and process namespaces."""
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
    raise NotAllowed(f"no network and process namespaces: {reason}")


class Cluster:
    """Head and workers, which end with this process."""

    def __init__(self, workers: int = 2):
        if os.getpid() != 1:
            # `ray stop` would find processes of the whole machine; here, the end of the first process ends them.
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
        """CPU time of all processes of the namespace so far, s."""
        ticks = 0
        for stat in Path("/proc").glob("[0-9]*/stat"):
            try:
                ticks += sum(map(int, stat.read_text().rpartition(")")[2].split()[11:13]))
            except OSError:
                continue  # It has ended meanwhile.
        return ticks / os.sysconf("SC_CLK_TCK")


def raylets() -> Set[int]:
    """Processes of Ray's nodes."""
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
