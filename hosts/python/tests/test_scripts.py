"""Tests of scripts in Python within worlds: permission, interpreter, packages."""

import os
import subprocess
import sys

import numpy as np
import pytest

import tatu_sim

pytestmark = pytest.mark.skipif(os.name != "posix", reason="scripts in Python run on Unix")

SCENE = '''
format = 1
[[object]]
kind = "dummy"
alias = "a"
script = { text = """#python
import subprocess
import sys
import numpy
def sysCall_init():
    sim = require("sim")
    sim.setStringSignal("runs", sys.executable)
    sim.setFloatSignal("sum", numpy.arange(4.0).sum())
""" }
'''


@pytest.fixture(autouse=True)
def _no_choice(monkeypatch):
    monkeypatch.delenv("TATU_PYTHON", raising=False)


def real(path):
    return os.path.realpath(path.decode() if isinstance(path, bytes) else path)


def test_scripts_run_in_the_interpreter_of_the_package_and_find_its_packages():
    with tatu_sim.World(text=SCENE, allow=["python"], strict=True) as world:
        world.step()
        assert real(world.sim.getStringSignal("runs")) == real(sys.executable)
        assert world.sim.getFloatSignal("sum") == 6.0


def test_scripts_do_not_run_without_permission(caplog):
    with tatu_sim.World(text=SCENE) as world:
        world.step()
        assert world.sim.getStringSignal("runs") is None
    assert "`--allow python`" in caplog.text


def test_an_interpreter_that_does_not_exist_is_named_in_the_error():
    for languages, text in [
        ({"python": {"interpreter": "/no/such/python"}}, SCENE),
        (None, SCENE + '\n[language.python]\ninterpreter = "/no/such/python"\n'),
    ]:
        with tatu_sim.World(text=text, allow=["python"], languages=languages) as world:
            world.step()
            assert "/no/such/python" in str(world.faults[0].text)


def test_an_unknown_setting_of_a_language_is_refused():
    with pytest.raises(tatu_sim.Error, match="interpretr") as refused:
        tatu_sim.World(text=SCENE, languages={"python": {"interpretr": "python3"}})
    assert "`interpreter`" in refused.value.help


class Recorder:
    """A controller that records its callbacks, and drives a ball by signals."""

    made = []

    def __init__(self):
        self.calls, self.count = [], 0
        Recorder.made.append(self)

    def sysCall_init(self, script):
        self.here = script.sim.getObject("..")
        self.calls.append("init")

    def sysCall_actuation(self, script):
        self.count += 1
        self.calls.append(("actuation", round(script.sim.getSimulationTime(), 6)))
        script.sim.setObjectPosition(self.here, np.array([self.count, 0.0, 0.0]))

    def sysCall_sensing(self, script):
        self.calls.append(("sensing", script.sim.getObjectPosition(self.here)[0]))

    def sysCall_cleanup(self, script):
        self.calls.append("cleanup")

    def sysCall_savestate(self, script):
        return {"count": self.count, "here": self.here}

    def sysCall_loadstate(self, script, state):
        self.count, self.here = state["count"], state["here"]


EMPTY = """
format = 1
[[object]]
kind = "dummy"
alias = "a"
[[object]]
kind = "dummy"
alias = "b"
"""


def test_a_class_is_a_script_whose_methods_are_called_at_their_place_in_the_step():
    Recorder.made.clear()
    with tatu_sim.World(text=EMPTY, scripts={"/a": Recorder, "/b": Recorder}, strict=True) as world:
        world.step(2)
        assert len(Recorder.made) == 2
        assert world["/a"].position[0] == world["/b"].position[0] == 2.0
        first = Recorder.made[0]
        second = ("actuation", round(world.dt, 6))
        assert first.calls == ["init", ("actuation", 0.0), ("sensing", 1.0), second, ("sensing", 2.0)]
    assert first.calls[-1] == "cleanup"


def test_a_function_is_called_in_each_step_and_its_errors_have_their_line():
    seen = []

    def drive(script):
        seen.append(script.sim.getObjectAlias(script.sim.getObject("..")))
        if len(seen) == 3:
            raise ValueError("enough")

    with tatu_sim.World(text=EMPTY, scripts={"/a": drive}) as world:
        world.step(5)
        fault = world.faults[0]
        assert seen == ["a"] * 3 and "ValueError: enough" in fault.text
        assert fault.file == __file__ and fault.line == drive.__code__.co_firstlineno + 3
        assert "in drive" in fault.traceback


def test_errors_of_commands_are_exceptions_in_a_script():
    found = []

    def drive(script):
        for call in (lambda: script.sim.getObject("/nowhere"), lambda: script.sim.noSuchCommand()):
            with pytest.raises(tatu_sim.Error) as error:
                call()
            found.append(error.value.text)

    with tatu_sim.World(text=EMPTY, scripts={"/a": drive}, strict=True) as world:
        world.step()
    assert "/nowhere" in found[0] and "sim.noSuchCommand" in found[1]


def test_a_script_cannot_use_its_own_world_or_its_commands_later():
    kept = []

    def drive(script):
        kept.append(script)
        for use in (world.step, world.close, lambda: world.time):
            with pytest.raises(RuntimeError, match="its own world"):
                use()

    with tatu_sim.World(text=EMPTY, scripts={"/a": drive}, strict=True) as world:
        world.step()
        with pytest.raises(RuntimeError, match="only while the simulator calls"):
            kept[0].sim.getObject("/a")


def test_state_that_an_object_saves_is_part_of_snapshots_and_forks():
    with tatu_sim.World(text=EMPTY, scripts={"/a": Recorder}, strict=True) as world:
        world.step(3)
        state = world.snapshot()
        world.step(4)
        with world.fork() as other:
            other.step()
            assert other["/a"].position[0] == 8.0
        world.restore(state)
        world.step()
        assert world["/a"].position[0] == 4.0
        world.reset()
        world.step()
        assert world["/a"].position[0] == 1.0


def test_scripts_that_are_objects_and_scripts_in_files_run_side_by_side(tmp_path):
    (tmp_path / "b.lua").write_text("function sysCall_sensing() sim.setInt32Signal('n', sim.getInt32Signal('n') + 1) end")

    def begin(script):
        script.sim.setInt32Signal("n", 10 * (script.sim.getInt32Signal("n") or 0))

    with tatu_sim.World(text=EMPTY, scripts={"/a": begin, "/b": tmp_path / "b.lua"}, strict=True) as world:
        world.step(3)
        assert world.sim.getInt32Signal("n") == 111


def test_what_cannot_be_a_script_is_refused():
    class Waits:
        def sysCall_thread(self, script):
            pass

    with tatu_sim.World(text=EMPTY, scripts={"/a": Waits}) as world:
        assert "sysCall_thread" in world.faults[0].text
    with pytest.raises(TypeError, match="only `World`"):
        tatu_sim.Batch(text=EMPTY, n=2, scripts={"/a": Recorder})


def test_a_world_with_objects_as_scripts_ends_with_the_interpreter():
    program = (
        "import tatu_sim\n"
        "class C:\n"
        "    def sysCall_cleanup(self, script): print('clean', flush=True)\n"
        f"world = tatu_sim.World(text={EMPTY!r}, scripts={{'/a': C}})\n"
        "world.step()\n"
    )
    for end in ("", "del world\n", "world.close()\n"):
        done = subprocess.run([sys.executable, "-c", program + end], capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr
        assert ("clean" in done.stdout) == bool(end)
