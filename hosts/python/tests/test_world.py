"""Tests of a world: its contents, its run, its states, and its errors."""

import gc
import json
import logging
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from conftest import PIONEER

import tatu_sim


def test_the_same_bits_as_the_program():
    program = [sys.executable, "-m", "tatu_sim", "run", PIONEER, "--steps", "100", "--json"]
    out = subprocess.run(program, capture_output=True, text=True, check=True)
    with tatu_sim.World(PIONEER) as world:
        assert world.step(100) == 100
        assert f"{world.hash:016x}" == json.loads(out.stdout)["hash"]
        assert world.time == pytest.approx(100 * world.dt) and world.steps == 100


def test_objects_joints_and_sensors_are_listed():
    with tatu_sim.World(PIONEER) as world:
        kinds = world.objects
        assert kinds["/Pioneer_p3dx"] == "shape"
        assert [kinds[path] for path in world.joints] == ["joint"] * len(world.joints) and len(world.joints) >= 2
        assert len(world.sensors) == 16 and all(kinds[path] == "sensor" for path in world.sensors)


def test_properties_are_numpy_arrays_and_copies(falling):
    with tatu_sim.World(text=falling) as world:
        pose = world.get("/ball", "object.world_pose")
        assert isinstance(pose, np.ndarray) and pose.shape == (7,) and pose[2] == 1.0
        pose[2] = 5.0
        assert world["/ball"].position[2] == 1.0
        world["/ball"].pose = [0, 0, 2, 0, 0, 0, 1]
        assert world["/ball"].position[2] == 2.0
        world.step(10)
        fallen = 0.5 * 9.81 * world.time**2
        assert 2.0 - world["/ball"].position[2] == pytest.approx(fallen, rel=0.05)
        assert world["/ball"].twist[2] == pytest.approx(-9.81 * world.time, rel=0.01)


def test_readings_have_their_fields():
    with tatu_sim.World(PIONEER) as world:
        world.step(2)
        reading = world.reading(world.sensors[0])
        assert reading.sequence == 2 and reading.kind == "proximity"
        assert reading["proximity.distance"].dtype == np.float64
        assert reading.distance == reading["proximity.distance"]
        with pytest.raises(AttributeError, match="proximity.distance"):
            reading.range


def test_a_view_shows_the_last_step_and_outlives_the_world(falling):
    world = tatu_sim.World(text=falling)
    view = world.view("/ball", "object.world_pose")
    assert view[2] == 1.0
    world.step(5)
    last = world["/ball"].position[2]
    assert view[2] == last < 1.0
    world.reset()
    assert view[2] == 1.0
    world.step(5)
    world.close()
    del world
    gc.collect()
    assert view[2] == last
    view[:] = 0.0


def test_commands_have_signatures_and_documentation():
    with tatu_sim.World(PIONEER) as world:
        handle = world.sim.getObject("/Pioneer_p3dx")
        assert isinstance(handle, int)
        assert world.sim.getObjectPosition(handle) == pytest.approx(world["/Pioneer_p3dx"].position)
        assert "position" in world.sim.getObjectPosition.__doc__
        assert "getObjectPosition" in dir(world.sim) and "sim" in dir(world)
        with pytest.raises(AttributeError, match="did you mean `sim.getObjectPosition`"):
            world.sim.getObjectPositio
        with pytest.raises(tatu_sim.Error) as wrong:
            world.sim.getObject("/Nobody")
        assert wrong.value.code.startswith("F2") and "Nobody" in wrong.value.text


def test_errors_have_code_text_help_and_place(tmp_path):
    scene = tmp_path / "wrong.toml"
    scene.write_text("format = 1\n[[object]]\nkind = 'shape'\nprimitiv = 'box'\n")
    with pytest.raises(tatu_sim.Error) as wrong:
        tatu_sim.World(scene)
    e = wrong.value
    assert e.code == "E101" and e.line == 4 and e.file == str(scene) and "primitive" in e.help
    assert str(e).startswith("[E101]")
    with pytest.raises(TypeError, match="scene"):
        tatu_sim.World()
    with pytest.raises(tatu_sim.Error, match="E105"):
        tatu_sim.World("no such scene.toml")
    for misspelt in ("learn/avoid_wals.toml", "scenes/learn/avoid_wals.toml"):
        with pytest.raises(tatu_sim.Error, match="did you mean `learn/avoid_walls.toml`"):
            tatu_sim.World(misspelt)
    for misspelt in ("pioner_braitenberg", "pioneer_braitenberg.tml"):
        with pytest.raises(tatu_sim.Error, match="did you mean `pioneer_braitenberg`"):
            tatu_sim.World(misspelt)


def test_all_scenes_of_the_package_can_be_opened():
    names = tatu_sim.scenes()
    assert "learn/avoid_walls.toml" in names and len(names) > 30
    for name in names:
        tatu_sim.World(name, allow=["exec", "net=*:*"]).close()
    tatu_sim.World("scenes/learn/avoid_walls.toml").close()


def test_states_are_restored_and_forked():
    with tatu_sim.World(PIONEER, seed=3) as world:
        world.step(20)
        state = world.snapshot()
        other = world.fork()
        world.step(20)
        after = world.hash
        other.step(20)
        assert other.hash == after
        world.restore(state)
        assert world.steps == 20
        world.step(20)
        assert world.hash == after
        other.close()
        with tatu_sim.World(PIONEER, seed=3) as again:
            again.restore(state)
            again.step(20)
            assert again.hash == after
        with pytest.raises(tatu_sim.Error):
            world.restore(b"nothing")
        assert world.step(1) == 1


def test_a_reset_begins_anew_with_other_seeds_and_changes(falling):
    with tatu_sim.World(text=falling) as world:
        world.step(10)
        first = world.hash
        world.reset()
        assert world.steps == 0
        world.step(10)
        assert world.hash == first
        world.reset(set={"/ball.position_m": [0, 0, 3.0]})
        assert world["/ball"].position[2] == 3.0
        with pytest.raises(tatu_sim.Error):
            world.reset(set={"/bal.position_m": [0, 0, 3.0]})
        assert world["/ball"].position[2] == 3.0 and world.step(1) == 1


def test_any_thread_may_use_a_world_and_worlds_run_at_once():
    world, other = tatu_sim.World(PIONEER), tatu_sim.World(PIONEER)
    threads = [threading.Thread(target=world.step, args=(10,)) for _ in range(4)]
    threads += [threading.Thread(target=other.step, args=(40,))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert world.steps == other.steps == 40 and world.hash == other.hash
    # The worlds are dropped by a thread that did not create them.
    worlds = [world, other]
    del world, other
    thread = threading.Thread(target=worlds.clear)
    thread.start()
    thread.join()


def test_python_runs_while_a_world_steps():
    with tatu_sim.World(PIONEER) as world:
        counted, stop = [0], threading.Event()

        def count():
            while not stop.is_set():
                counted[0] += 1

        thread = threading.Thread(target=count)
        thread.start()
        before = counted[0]
        world.step(300)
        during = counted[0] - before
        stop.set()
        thread.join()
        assert during > 1000


def test_ctrl_c_interrupts_long_steps():
    code = (
        "import tatu_sim, signal, threading, os, time\n"
        f"world = tatu_sim.World({PIONEER!r})\n"
        "threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()\n"
        "begin = time.monotonic()\n"
        "try:\n"
        "    world.step(10**9)\n"
        "except KeyboardInterrupt:\n"
        "    print('interrupted', time.monotonic() - begin < 20, world.step(1))\n"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert out.stdout == "interrupted True 1\n", out.stderr


def test_output_before_ctrl_c_is_not_lost(tmp_path):
    script = tmp_path / "count.lua"
    script.write_text("n = 0\nfunction sysCall_sensing() n = n + 1; print('step ' .. n) end\n")
    code = (
        "import tatu_sim, signal, threading, os\n"
        f"world = tatu_sim.World({PIONEER!r}, scripts={{'/Pioneer_p3dx': {str(script)!r}}})\n"
        "threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()\n"
        "try:\n"
        "    world.step(10**9)\n"
        "except KeyboardInterrupt:\n"
        "    print('interrupted', round(world.time / world.dt))\n"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    *printed, last = out.stdout.splitlines()
    steps = int(last.removeprefix("interrupted "))
    assert steps > 10 and printed == [f"step {n}" for n in range(1, steps + 1)], out.stderr


def test_daemon_threads_may_step_as_the_interpreter_exits():
    code = (
        "import tatu_sim, threading, time\n"
        f"world = tatu_sim.World({PIONEER!r})\n"
        "def step(n):\n"
        "    while True:\n"
        "        world.step(n)\n"
        "for n in (1, 5, 10**6):\n"
        "    threading.Thread(target=step, args=(n,), daemon=True).start()\n"
        "time.sleep(0.2)\n"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert (out.returncode, out.stderr) == (0, "")


def test_a_misspelt_property_gets_a_suggestion(falling):
    with tatu_sim.World(text=falling) as world:
        for key, meant in [("object.world_poze", "object.world_pose"), ("world_pose", "object.world_pose")]:
            with pytest.raises(tatu_sim.Error, match=f"did you mean `{meant}`"):
                world.get("/ball", key)
            with pytest.raises(tatu_sim.Error, match=f"did you mean `{meant}`"):
                world.set("/ball", key, [0.0] * 7)
        with pytest.raises(tatu_sim.Error) as refused:
            world.get("/ball", "no.such.thing.anywhere")
        assert "did you mean" not in str(refused.value)
        with pytest.raises(tatu_sim.Error, match="`/ball` is not a sensor"):
            world.reading("/ball")


def test_signal_handlers_of_the_process_are_not_changed():
    before = {s: signal.getsignal(s) for s in signal.valid_signals()}
    caught = _caught()
    with tatu_sim.World(PIONEER) as world:
        world.step(1)
        assert _caught() == caught
    assert {s: signal.getsignal(s) for s in signal.valid_signals()} == before
    with pytest.raises(ValueError, match="closed"):
        world.step(1)


def _caught():
    with open("/proc/self/status") as status:
        return next(line for line in status if line.startswith("SigCgt"))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork on this system")
def test_a_copy_of_the_process_refuses_the_world():
    with tatu_sim.World(PIONEER) as world:
        read, write = os.pipe()
        child = os.fork()
        if child == 0:
            try:
                world.step(1)
                said = b"it stepped"
            except tatu_sim.Error as e:
                said = e.code.encode()
            with tatu_sim.World(PIONEER) as own:
                said += b" %d" % own.step(2)
            os.write(write, said)
            os._exit(0)
        os.close(write)
        assert os.read(read, 100) == b"E406 2"
        os.waitpid(child, 0)
        assert world.step(1) == 1


def test_scripts_print_to_stdout_and_fail_into_the_log(tmp_path, capsys, caplog):
    scene = tmp_path / "talks.toml"
    (tmp_path / "talk.lua").write_text("function sysCall_sensing() print('hello') error('on purpose') end")
    scene.write_text("format = 1\n[[object]]\nkind = 'dummy'\nalias = 'talker'\nscript = 'talk.lua'\n")
    with caplog.at_level(logging.ERROR, logger="tatu_sim"), tatu_sim.World(scene) as world:
        world.step(2)
        assert "hello" in capsys.readouterr().out
        assert "on purpose" in caplog.text
        fault = world.faults[0]
        assert fault.code == "F205" and "on purpose" in fault.text and "talk.lua" in str(fault)
    with tatu_sim.World(scene, strict=True) as world:
        with pytest.raises(tatu_sim.Error, match="on purpose"):
            world.step(2)


def test_pictures_are_arrays():
    with tatu_sim.World(PIONEER) as world:
        picture = world.render(size=(64, 48))
        assert picture.shape == (48, 64, 3) and picture.dtype == np.uint8 and picture.std() > 5
        near = world.render(look_from=[1, 1, 1], look_at=[0, 0, 0], size=(64, 48), fov=1.0)
        assert (near != picture).any()
        for wrong in ({"size": (0, 48)}, {"camera": "/nothing"}, {"fov": 4.0}):
            with pytest.raises(tatu_sim.Error):
                world.render(**wrong)


@pytest.mark.parametrize("seed", [-1, 2**64, 0.5])
def test_invalid_numbers_are_refused_by_name(falling, seed):
    expected = r"`(seed|n)` is .*; expected"
    with pytest.raises((ValueError, TypeError), match=expected):
        tatu_sim.World(text=falling, seed=seed)
    with tatu_sim.World(text=falling) as world:
        with pytest.raises((ValueError, TypeError), match=expected):
            world.reset(seed=seed)
        with pytest.raises((ValueError, TypeError), match=expected):
            world.step(seed)
        with pytest.raises(ValueError, match="`seconds` is nan; expected"):
            world.run(float("nan"))
        assert world.step(np.int64(2)) == 2


def test_a_film_is_a_page_of_its_own():
    with tatu_sim.World(PIONEER, film=True) as world:
        world.step(10)
        film = world.show()
        assert "<html" in film.page.lower() and 'src="http' not in film.page
        assert film._repr_html_().startswith("<iframe")
        with pytest.raises(ValueError, match="ends with .html"):
            film.save("film.mp4")
        assert world.step(1) == 1
    with tatu_sim.World(PIONEER) as world, pytest.raises(ValueError, match="film=True"):
        world.show()


def test_a_crash_report_must_be_asked_for():
    code = "import tatu_sim, os, signal; tatu_sim.crash_reports(); os.kill(os.getpid(), signal.SIGSEGV)"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert out.returncode == -signal.SIGSEGV and "F211" in out.stderr


def test_the_command_line_is_in_the_package():
    run = lambda *args: subprocess.run([sys.executable, "-m", "tatu_sim", *args], capture_output=True, text=True)
    assert run("--version").stdout.startswith("tatu ")
    assert "pioneer_p3dx" in run("list", "models").stdout
    assert run("run", "no_such_scene.toml").returncode == 2
    assert run("plugin", "list").returncode == 0
    doctor = run("doctor")
    assert doctor.returncode == 0 and "as expected" in doctor.stdout, doctor.stderr


def test_import_loads_no_heavy_modules():
    code = (
        "import sys, time, numpy\nbegin = time.perf_counter()\nimport tatu_sim\n"
        "print(time.perf_counter() - begin, [m for m in ('gymnasium', 'ray', 'pyarrow', 'asyncio') if m in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    # bench/python.py measures the import time; importing these modules would make it long.
    assert out.endswith("[]\n"), out


def test_processes_by_spawn_make_their_own_worlds():
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        hashes = pool.map(_hash_after, [5, 5, 6])
    assert hashes[0] == hashes[1] != hashes[2]


def _hash_after(steps):
    with tatu_sim.World(PIONEER) as world:
        world.step(steps)
        return world.hash


def test_process_state_set_by_the_owner_is_preserved(tmp_path, monkeypatch, caplog):
    with tatu_sim.World(PIONEER) as world, tatu_sim.World(PIONEER) as other:
        world.step(1)
        monkeypatch.chdir(tmp_path)
        handler = lambda *_: None
        before = signal.signal(signal.SIGUSR1, handler)
        # Run more steps than lie between two full checks of what plugins have changed in the process.
        world.step(200)
        assert os.getcwd() == str(tmp_path) and signal.getsignal(signal.SIGUSR1) is handler
        signal.signal(signal.SIGUSR1, before)
        other.step(201)
        assert world.hash == other.hash and not world.faults and not other.faults
