"""Tests that training the example for half a minute improves its policy."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import tatu_sim

pytest.importorskip("gymnasium", reason="gymnasium is not installed: pip install 'tatu-sim[gym]'")


def test_thirty_seconds_improve():
    folder = str(Path(tatu_sim.__file__).resolve().parents[1])
    path = os.pathsep.join(filter(None, [folder, os.environ.get("PYTHONPATH")]))
    command = [sys.executable, "-m", "tatu_sim.examples.avoid_walls", "--seconds", "30"]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=600, env={**os.environ, "PYTHONPATH": path})
    assert ran.returncode == 0, ran.stderr
    before, after = (
        float(re.search(rf"^{name} +([0-9.]+)", ran.stdout, re.MULTILINE).group(1)) for name in ("untrained", "trained")
    )
    generations = len(re.findall(r"^ +[0-9]+ ", ran.stdout, re.MULTILINE))
    if generations < 8:
        pytest.skip(f"too slow to learn: {generations} generations in 30 s; use a release build and idle cores")
    assert after > 1.5 * before, ran.stdout
