"""Scenes that several tests run."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

SQUARE = """
title = "A square that drains to the left"
geometry = { type = "lattice", size = ["1 m", "1 m"], points = [20, 20] }
fluid.viscosity = "1 mPa s"
materials.sand = { permeability = "1e-12 m^2", storage = "1e-9 1/Pa" }
flow = { initial_pressure = "1 bar", boundary.left.pressure = 0 }
time.end = "1 s"
"""


@pytest.fixture
def square():
    """A scene of a few dozen steps that takes milliseconds."""
    return SQUARE


@pytest.fixture
def terzaghi():
    """Terzaghi's column in steps of 3 s."""
    import perifrac as pf

    return pf.case("terzaghi").update({"time.step": 3, "geometry.spacing": 0.25})


def program():
    """The program of the same build, if there is one."""
    root = Path(__file__).resolve().parents[2]
    target = Path(os.environ.get("CARGO_TARGET_DIR", root / "target"))
    place = target / "release" / "perifrac"
    return str(place) if place.is_file() else shutil.which("perifrac")


@pytest.fixture
def cli():
    """Runs the program and gives what it prints."""
    found = program()
    if found is None:
        pytest.skip("the program perifrac is not built")

    def call(*words, folder=None, code=0):
        done = subprocess.run([found, *words], cwd=folder, capture_output=True, text=True)
        assert done.returncode == code, done.stderr
        return done.stdout if code == 0 else done.stderr

    return call
