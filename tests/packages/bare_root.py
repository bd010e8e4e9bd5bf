"""Creates a root file system with only glibc and libgcc: no shell, no compiler, no package manager.

Its files are copied from this machine's Debian packages, so it needs no network.
"""

import fcntl
import os
import shutil
import socket
import struct
import subprocess
from pathlib import Path

PACKAGES = ["libc6", "libgcc-s1"]
# Folders on which tmpfs or proc is mounted, and devices that programs expect.
MOUNTS = ["dev", "opt", "proc", "tmp"]
DEVICES = ["null", "zero", "random", "urandom"]
# Linux constants: the ioctl that sets the flags of a network interface, and the flag that enables it.
SIOCSIFFLAGS, IFF_UP = 0x8914, 1
# Tools that must not exist in a root file system in which a package is tested.
TOOLS = ["cc", "gcc", "c++", "clang", "rustc", "cargo", "node", "npm", "python3"]


def make(root):
    """Creates the root file system in an empty folder."""
    for folder in ["usr/bin", "usr/lib", "usr/lib64", "etc", *MOUNTS]:
        (root / folder).mkdir(parents=True)
    for folder in ["bin", "lib", "lib64"]:
        (root / folder).symlink_to(f"usr/{folder}")
    try:
        told = subprocess.run(["dpkg", "-L", *PACKAGES], capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        raise SystemExit(f"`dpkg -L {' '.join(PACKAGES)}` has failed: {error}\n  help: on a system without dpkg, name "
                         "the folder of a root file system by --root") from None
    for line in sorted(set(told.split("\n"))):
        source = Path(line)
        # Conversion tables between encodings are omitted, because only iconv reads them.
        if ".so" in source.name and "gconv" not in line and source.is_file():
            place = root / line.lstrip("/")
            place.parent.mkdir(parents=True, exist_ok=True)
            if not place.exists():
                shutil.copy2(source, place)


def mount(root):
    """Mounts file systems that programs need in a root file system; they vanish with the namespace of this process."""
    for folder in MOUNTS:
        if not (root / folder).is_dir():
            raise SystemExit(f"{root}: expected a root file system with the folder {folder}")
        kind = "proc" if folder == "proc" else "tmpfs"
        subprocess.run(["mount", "-t", kind, kind, str(root / folder)], check=True)
    for device in DEVICES:
        (root / "dev" / device).touch()
        subprocess.run(["mount", "--bind", f"/dev/{device}", str(root / "dev" / device)], check=True)
    os.chmod(root / "tmp", 0o1777)


def switch_loopback_on():
    """Enables the loopback interface, which is down in a new network namespace."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        fcntl.ioctl(any_socket, SIOCSIFFLAGS, struct.pack("16sh22x", b"lo", IFF_UP))


def tools_in(root):
    """Returns the tools that exist in the root file system although a package must not depend on them."""
    folders = ["bin", "usr/bin", "usr/local/bin"]
    return [t for t in TOOLS if any(os.path.lexists(root / folder / t) for folder in folders)]
