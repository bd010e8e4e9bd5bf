# Runs once in every new script in Python. Sets `rules`, which describe how the language must call scripts of this API.
import copy


def set_stepping(on):
    """While stepping, a thread is switched only where it asks to be. Returns the level before."""
    before = script.hold()
    script.hold(int(on) if type(on) is int else before + (1 if on else -1))
    return before


def set_automatic(on):
    set_stepping(not on)
    return 1


def acquire_lock():
    set_stepping(True)


def release_lock():
    set_stepping(False)


def read_block(*args):
    """Unlike in Lua, missing data is empty."""
    found = script.command("sim.readCustomDataBlock")(*args)
    return b"" if found is None else found


class ScriptFunctions:
    """The functions of another script, as attributes."""

    def __init__(self, handle):
        self._handle = handle

    def __getattr__(self, name):
        return lambda *args: script.command("sim.callScriptFunction")(name, self._handle, *args)


def vision(data):
    """Scripts of sensors are called after each measurement of the sensor, with the same arguments as in V-REP."""
    script.command("sim.handleSensorCallbacks")(data["sensor"])


script.define("sim.setStepping", set_stepping)
script.define("sim.setThreadAutomaticSwitch", set_automatic)
script.define("sim.setThreadSwitchTiming", lambda ms=2: 1)
script.define("sim.setAutoYieldDelay", lambda seconds=0.002: None)
script.define("sim.getAutoYieldDelay", lambda: 0.002)
script.define("sim.acquireLock", acquire_lock)
script.define("sim.releaseLock", release_lock)
script.define("sim.copyTable", copy.deepcopy)
script.define("sim.readCustomDataBlock", read_block)
script.define("sim.getScriptFunctions", ScriptFunctions)
if script.has("sysCall_vision", "sysCall_trigger"):
    script.define("sysCall_measured", vision)

# Scripts in Python exist since 4.3.
version = max([int(part) for part in (script.dialect or "4.9").split(".")], [4, 3])

rules = {
    # Names of the functions that scripts define, where %s is the callback; `also` lists other names.
    "functions": "sysCall_%s",
    "also": {
        "run": "sysCall_addOnScriptRun",
        "addonSuspend": "sysCall_addOnScriptSuspend",
        "addonResume": "sysCall_addOnScriptResume",
        "beforeStep": "sysCall_beforeMainScript",
    },
    # The host's names of callback arguments, mapped to those of this API.
    "arguments": {
        "dyn": {"step": "passCnt", "steps": "totalPasses", "after": "afterStep"},
        "joint": {
            "step": "passCnt", "steps": "totalPasses", "dt": ["dt", "dynStepSize"], "pos": ["pos", "currentPos"],
            "error": ["error", "errorValue"], "force": ["force", "maxForce"], "maxVel": ["maxVel", "velUpperLimit"],
        },
        "contact": {"shape1": "handle1", "shape2": "handle2"},
    },
    # This API's names of callback results, mapped to those of the host.
    "results": {
        "beforeStep": {"doNotRunMainScript": "skip"},
        "contact": {"ignoreContact": "ignore", "collisionResponse": "respond", "bullet": "material"},
    },
    "dialect": ".".join(map(str, version)),
    # The order in which the scripts of a world are called, and the version since which it applies.
    "orders": [("0", "parents_first"), ("3.6", "by_kind"), ("4.4", "deepest_first")],
    # The command by which a thread waits for the next step, the clock, and the command that waits for it.
    "switch": "sim.switchThread",
    "time": "sim.getSimulationTime",
    "wait": "sim.wait",
    # Before 4.5, numbers were passed as 32-bit floats, except to these commands.
    "single": version[:2] < [4, 5],
    "exact": [
        "sim.packDoubleTable", "sim.unpackDoubleTable", "sim.packTable", "sim.unpackTable", "sim.callScriptFunction",
        "sim.wait", "sim.setDoubleSignal", "sim.getDoubleSignal",
    ],
}
