"""Shared by all tests."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
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
    """Tests leave nothing in the working folder, and find no scene there."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, [str(ROOT / "python"), os.environ.get("PYTHONPATH")])))
