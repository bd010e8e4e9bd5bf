"""Limits of this process that keep a faulty script from harming others.

They are no protection against a script that wants to do harm, which can do anything that the user's account can.
"""

import os
import platform
import struct
import sys

try:
    import ctypes
    import resource
except ImportError:  # an interpreter without these modules
    ctypes = resource = None

# Numbers of system calls: fork, vfork, clone, clone3, kill, tkill, tgkill, and signals with a value.
NUMBERS = {
    "x86_64": (0xC000003E, 317, dict(fork=57, vfork=58, clone=56, clone3=435, kill=62, tkill=200, tgkill=234,
                                     rt_sigqueueinfo=129, rt_tgsigqueueinfo=297, pidfd_send_signal=424)),
    "aarch64": (0xC00000B7, 277, dict(clone=220, clone3=435, kill=129, tkill=130, tgkill=131, rt_sigqueueinfo=138,
                                      rt_tgsigqueueinfo=240, pidfd_send_signal=424)),
}
PR_SET_PDEATHSIG, PR_SET_NO_NEW_PRIVS = 1, 38
SIGKILL = 9
SET_MODE_FILTER, SPEC_ALLOW = 1, 4
CLONE_THREAD = 0x10000
ALLOW, FAIL = 0x7FFF0000, 0x00050000
EPERM, ENOSYS = 1, 38
# Instructions of the filter: load a word of the call, compare it, test bits, return.
LOAD, EQUAL, SET, RETURN = 0x20, 0x15, 0x45, 0x06
NUMBER, ARCHITECTURE, ARGUMENT, HIGH_ARGUMENT = 0, 4, 16, 20


def begin(parent, memory):
    """Ends this process with its parent, and limits its memory. Returns the limits that do not bind, as sentences."""
    problems = []
    if ctypes is None:
        return ["this interpreter lacks the modules `ctypes` and `resource`, so the script has no limits"]
    if sys.platform.startswith("linux"):
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, SIGKILL)
        if os.getppid() != parent:
            os._exit(0)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if memory:
        try:
            resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
        except (ValueError, OSError) as error:
            problems.append("the memory of the script is not limited: %s" % error)
        if not sys.platform.startswith("linux"):
            problems.append("on this system, the limit of memory may not bind")
    return problems


def apply(may_start_programs):
    """Forbids other processes, unless scripts may start programs, and signals to processes that are not the script's
    own. Returns the limits that do not bind, as sentences."""
    problem = "" if ctypes is None else filter_calls(may_start_programs)
    return [problem] if problem else []


def filter_calls(may_start_programs):
    if not sys.platform.startswith("linux"):
        return "on this system, a script can start any number of processes"
    known = NUMBERS.get(platform.machine())
    if known is None or sys.maxsize < 1 << 32:
        return "on this processor, a script can start any number of processes"
    architecture, seccomp, numbers = known
    program = filter_program(architecture, numbers, may_start_programs)
    libc = ctypes.CDLL(None, use_errno=True)
    code = b"".join(struct.pack("HBBI", *one) for one in program)
    buffer = ctypes.create_string_buffer(code, len(code))

    class Program(ctypes.Structure):
        _fields_ = [("length", ctypes.c_ushort), ("filter", ctypes.c_void_p)]

    argument = Program(len(program), ctypes.cast(buffer, ctypes.c_void_p))
    if libc.prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0:
        return "the system refuses to limit the processes of a script"
    for flags in (SPEC_ALLOW, 0):
        if libc.syscall(seccomp, SET_MODE_FILTER, flags, ctypes.byref(argument)) == 0:
            return ""
    return "the system refuses to limit the processes of a script: %s" % os.strerror(ctypes.get_errno())


def filter_program(architecture, numbers, may_start_programs):
    """Returns a program for seccomp, as tuples of code, two jumps, and a constant."""
    own, parent = os.getpid(), os.getppid()
    out = [(LOAD, 0, 0, ARCHITECTURE), (EQUAL, 1, 0, architecture), (RETURN, 0, 0, ALLOW), (LOAD, 0, 0, NUMBER)]
    if not may_start_programs:
        for name in ("fork", "vfork"):
            if name in numbers:
                out += [(EQUAL, 0, 1, numbers[name]), (RETURN, 0, 0, FAIL | EPERM)]
        # Without `clone3`, the C library starts threads with `clone`, whose flags a filter can read.
        out += [(EQUAL, 0, 1, numbers["clone3"]), (RETURN, 0, 0, FAIL | ENOSYS)]
        out += [(EQUAL, 0, 4, numbers["clone"]), (LOAD, 0, 0, ARGUMENT), (SET, 1, 0, CLONE_THREAD),
                (RETURN, 0, 0, FAIL | EPERM), (RETURN, 0, 0, ALLOW)]
    for name in ("kill", "tkill", "tgkill", "rt_sigqueueinfo", "rt_tgsigqueueinfo"):
        if may_start_programs:
            # The processes that the script has started may get signals, but not the simulator, and not all processes.
            tests = [(EQUAL, 3, 0, parent), (EQUAL, 2, 0, 0xFFFFFFFF), (EQUAL, 1, 0, (1 << 32) - parent),
                     (RETURN, 0, 0, ALLOW), (RETURN, 0, 0, FAIL | EPERM)]
        elif name == "tkill":
            tests = [(RETURN, 0, 0, FAIL | EPERM)]
        else:
            tests = [(EQUAL, 1, 0, own), (RETURN, 0, 0, FAIL | EPERM), (RETURN, 0, 0, ALLOW)]
        out += [(EQUAL, 0, len(tests) + 1, numbers[name]), (LOAD, 0, 0, ARGUMENT)] + tests
    if not may_start_programs:
        out += [(EQUAL, 0, 1, numbers["pidfd_send_signal"]), (RETURN, 0, 0, FAIL | EPERM)]
    return out + [(RETURN, 0, 0, ALLOW)]
