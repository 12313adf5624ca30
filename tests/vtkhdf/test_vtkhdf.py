"""Files of VTKHDF hold what the files of single outputs do, also where a run goes on.

    PERIFRAC=target/release/perifrac python -m pytest tests/vtkhdf    # a program with the feature vtkhdf
"""

import os
import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest
import pyvista
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline

PROGRAM = Path(os.environ["PERIFRAC"]).resolve()
# Fields of one, two or three and six components, in a plane and in space.
SCENES = {
    "plane": ["terzaghi", "--set", "geometry.spacing=0.25", "--set", "time.step=6"],
    "space": ["column-3d", "--set", "time.step=4"],
    "steady": ["barrier"],
    "cut": ["sneddon", "--set", "geometry.spacing=0.02"],
}


def run(folder, *words):
    return subprocess.run([PROGRAM, *words], cwd=folder, capture_output=True, text=True)


def succeed(folder, *words):
    done = run(folder, *words)
    assert done.returncode == 0, done.stderr
    return done.stdout


def start(folder, name, file_format, out, *more):
    words = SCENES[name] + ["--set", f"output.format={file_format}", "--set", "output.plots=false", "--out", out]
    return succeed(folder, "run", *words, *more)


def outputs(path):
    """Times, and the grid at each of them."""
    reader = pyvista.get_reader(str(path)).reader
    reader.UpdateInformation()
    key = vtkStreamingDemandDrivenPipeline.TIME_STEPS()
    information = reader.GetOutputInformation(0)
    for step in range(reader.GetNumberOfSteps()):
        reader.SetStep(step)
        reader.Update()
        yield information.Get(key, step), pyvista.wrap(reader.GetOutput()).copy()


@pytest.mark.parametrize("name", SCENES)
def test_one_file_holds_what_the_files_of_all_outputs_do(tmp_path, name):
    start(tmp_path, name, "vtkhdf", "one")
    start(tmp_path, name, "vtu", "many")
    names = {path.name for path in (tmp_path / "one").iterdir()}
    assert "fields.vtkhdf" in names and not any(name.endswith((".vtu", ".pvd")) and "crack" not in name for name in names)
    files = sorted((tmp_path / "many").glob("fields-*.vtu"))
    collection = pyvista.get_reader(str(tmp_path / "many" / "fields.pvd"))
    found = list(outputs(tmp_path / "one" / "fields.vtkhdf"))
    assert [time for time, _ in found] == list(collection.time_values)
    assert len(found) == len(files) >= (1 if name in ("steady", "cut") else 2)
    for (_, grid), path in zip(found, files):
        single = pyvista.read(path)
        assert np.array_equal(grid.points, single.points)
        assert np.array_equal(grid.cells, single.cells)
        assert np.array_equal(grid.celltypes, single.celltypes)
        assert set(grid.point_data.keys()) == set(single.point_data.keys())
        for field in single.point_data.keys():
            assert np.array_equal(grid.point_data[field], single.point_data[field]), field
    if len(found) > 1:
        assert not np.array_equal(found[0][1]["pressure"], found[-1][1]["pressure"])


def contents(path):
    """Everything that a file tells: rows up to its number of outputs."""
    with h5py.File(path) as file:
        told = {}
        file.visititems(lambda name, item: told.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None)
        steps = file["VTKHDF/Steps"].attrs["NSteps"]
        points = int(told["VTKHDF/NumberOfPoints"][0])
        for name in told:
            if name.startswith("VTKHDF/Steps/"):
                told[name] = told[name][:steps]
            elif name.startswith("VTKHDF/PointData/"):
                told[name] = told[name][: steps * points]
        return told, int(steps)


def test_a_run_that_goes_on_leaves_no_seam(tmp_path):
    start(tmp_path, "plane", "vtkhdf", "one", "--checkpoint-at-outputs")
    path = tmp_path / "one" / "fields.vtkhdf"
    before, steps = contents(path)
    first = sorted((tmp_path / "one").glob("checkpoint-*.pfc"), key=lambda own: int(own.stem.split("-")[1]))[0]
    succeed(tmp_path, "resume", "one", "--from", str(first))
    after, again = contents(path)
    assert steps == again >= 3
    assert before.keys() == after.keys()
    for name in before:
        assert np.array_equal(before[name], after[name]), name


@pytest.mark.parametrize("harm", ["cut off", "gone", "another"])
def test_a_damaged_file_is_refused_by_name_when_a_run_goes_on(tmp_path, harm):
    start(tmp_path, "plane", "vtkhdf", "one", "--checkpoint-at-outputs")
    path = tmp_path / "one" / "fields.vtkhdf"
    first = sorted((tmp_path / "one").glob("checkpoint-*.pfc"), key=lambda own: int(own.stem.split("-")[1]))[0]
    match harm:
        case "cut off":
            path.write_bytes(path.read_bytes()[:3000])
        case "gone":
            path.unlink()
        case "another":
            with h5py.File(path, "r+") as file:
                file["VTKHDF/Steps"].attrs["NSteps"] = np.int64(0)
    done = run(tmp_path, "resume", "one", "--from", str(first))
    assert done.returncode == 1, done.stderr
    assert done.stderr.startswith("error: one/fields.vtkhdf"), done.stderr


def test_the_next_run_replaces_the_file_and_a_file_of_the_user_stays(tmp_path):
    start(tmp_path, "plane", "vtkhdf", "one")
    start(tmp_path, "plane", "vtkhdf", "one")
    names = sorted(path.name for path in (tmp_path / "one").iterdir())
    assert "fields.vtkhdf" in names and not any("kept" in name for name in names)
    path = tmp_path / "one" / "fields.vtkhdf"
    path.write_bytes(b"noted")
    start(tmp_path, "plane", "vtkhdf", "one")
    assert (tmp_path / "one" / "fields.vtkhdf.kept").read_bytes() == b"noted"
    assert len(list(outputs(path))) >= 3
    # Without its own file nothing of it is left behind.
    start(tmp_path, "plane", "vtu", "one")
    assert not path.exists()


def test_what_the_format_cannot_hold_is_refused(tmp_path):
    twice = run(tmp_path, "check", "barrier", "--set", "output.format=vtkhdf", "--set", "output.vtu=false")
    assert twice.returncode == 3 and "`vtu = false` leaves them out" in twice.stderr
    unknown = run(tmp_path, "check", "barrier", "--set", "output.format=hdf5")
    assert unknown.returncode == 3 and "--set #1" in unknown.stderr
