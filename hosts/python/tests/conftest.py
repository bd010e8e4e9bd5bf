"""Fixtures and constants that the tests share."""

import os
from pathlib import Path

import pytest

import tatu_sim

PIONEER = "first/pioneer_avoids_walls.toml"

#: A ball that falls, and a script that prints and counts.
FALLING = """
format = 1
[[object]]
kind = "shape"
alias = "ball"
primitive = "sphere"
size_m = [0.1, 0.1, 0.1]
position_m = [0, 0, 1]
dynamic = true
respondable = true
"""


@pytest.fixture
def falling():
    return FALLING


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    """Run each test in an empty working folder, so that it finds no scene there and leaves no files behind."""
    monkeypatch.chdir(tmp_path)
    # Processes that tests start use the package that is tested here, installed or not.
    package = str(Path(tatu_sim.__file__).resolve().parents[1])
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, [package, os.environ.get("PYTHONPATH")])))
