"""Runs: the same results as those of the program, and of exact solutions."""

import json
import math

import numpy as np
import pytest

import perifrac as pf


def test_a_run_has_the_bits_of_the_program(terzaghi, cli, tmp_path):
    run = pf.Simulation(terzaghi, threads=2, out=tmp_path / "ours").run()
    words = ["--set", "time.step=3", "--set", "geometry.spacing=0.25", "--threads", "1", "--json"]
    summary = json.loads(cli("run", "terzaghi", *words, "--out", "theirs", folder=tmp_path))
    assert run.errors == summary["errors"] and run.summary["balance"] == summary["balance"]
    ours, theirs = (tmp_path / name / "history.csv" for name in ("ours", "theirs"))
    assert ours.read_bytes() == theirs.read_bytes()
    fields = sorted((tmp_path / "ours").glob("fields-*.vtu"))
    assert len(fields) == 4
    for path in fields:
        assert path.read_bytes() == (tmp_path / "theirs" / path.name).read_bytes()


def test_terzaghi_is_met(terzaghi):
    run = pf.Simulation(terzaghi, out=False).run()
    assert run.errors["pressure"]["l2"] < 5e-3 and run.errors["displacement"]["l2"] < 5e-3
    # The same error from the fields, against the series.
    x, time = run.positions[:, 0], run.time
    odd = math.pi * (2 * np.arange(200)[:, None] + 1) / 2
    modulus, alpha, storage = 1e8, 0.5, 1.65e-10
    start = 1e4 * alpha / (modulus * storage + alpha**2)
    consolidation = 1e-9 / (storage + alpha**2 / modulus)
    decay = np.exp(-(odd**2) * consolidation * time / 15**2)
    exact = start * (2 / odd * np.sin(odd * x[None, :] / 15) * decay).sum(axis=0)
    assert np.abs(run.fields["pressure"] - exact).max() < 0.01 * start


def test_a_five_spot_is_met_in_one_solve():
    scene = pf.case("five-spot").update({"time.mode": "steady", "geometry.points": [50, 50]})
    run = pf.Simulation(scene, out=False).run()
    assert run.errors["pressure"]["l2"] < 1e-3
    steps = list(pf.Simulation(scene, out=False))
    assert len(steps) == 1 and steps[0].history.rows == 1


def test_steps_are_those_of_the_whole_run(square):
    whole = pf.Simulation(square, out=False).run()
    simulation = pf.Simulation(square, out=False)
    times, largest = [], []
    for step in simulation:
        times.append(step.time)
        largest.append(step.fields["pressure"].max())
        assert step.history.rows == step.steps + 1 and step.history["time"][-1] == step.time
    assert np.array_equal(times, whole.history["time"][1:])
    assert np.allclose(largest, whole.history["pressure_max"][1:], rtol=0, atol=0)
    assert np.array_equal(simulation.result.fields["pressure"], whole.fields["pressure"])
    assert simulation.step() is None and simulation.run() is simulation.result


def test_own_points_are_as_good_as_those_of_the_scene(square):
    whole = pf.Simulation(square, out=False).run()
    centres = (np.arange(20) + 0.5) / 20
    position = np.array([(x, y) for y in centres for x in centres])
    scene = pf.Scene(square)
    scene["geometry"] = {"bounds": {"min": [0, 0], "max": [1, 1]}}
    scene.cloud = pf.Cloud(position, 1 / 400)
    run = pf.Simulation(scene, out=False).run()
    assert np.array_equal(run.positions, position)
    assert np.allclose(run.fields["pressure"], whole.fields["pressure"], rtol=1e-6, atol=1e-2)


def test_own_permeabilities_give_the_flow_of_darcys_law(square):
    columns, rows = 40, 20
    x, y = np.meshgrid((np.arange(columns) + 0.5) / columns, (np.arange(rows) + 0.5) / rows * 0.5)
    position = np.column_stack([x.ravel(), y.ravel()])
    scene = pf.Scene(
        {
            "title": "Rock that lets more through from left to right",
            "geometry": {"bounds": {"min": [0, 0], "max": ["1 m", "0.5 m"]}},
            "fluid": {"viscosity": "1 mPa s"},
            "materials": {"rock": {"permeability": "1e-12 m^2", "storage": "1e-9 1/Pa"}},
            "flow": {"boundary": {"left": {"pressure": "1 bar"}, "right": {"pressure": 0}}},
            "time": {"mode": "steady"},
        }
    )
    scene.cloud = pf.Cloud(position, 0.5 / len(position), permeability=1e-12 * np.exp(position[:, 0]))
    run = pf.Simulation(scene, out=False).run()
    exact = 1e5 * 1e-12 / 1e-3 * 0.5 / (1 - math.exp(-1))
    assert run.summary["outflow"]["right"] == pytest.approx(exact, rel=1e-3)

    lattice = scene.copy()
    lattice.cloud = None
    lattice["geometry"] = {"type": "lattice", "size": [1, 0.5], "points": [columns, rows]}
    flat = lattice.changed({"materials.rock.permeability": scene.cloud.permeability})
    grid = lattice.changed({"materials.rock.permeability": scene.cloud.permeability.reshape(rows, columns).T})
    for own in (flat, grid):
        found = pf.Simulation(own, out=False).run()
        assert found.fields["permeability"] == pytest.approx(scene.cloud.permeability, rel=1e-15)
        assert found.summary["outflow"]["right"] == pytest.approx(exact, rel=1e-3)


def test_faulty_points_are_refused_before_a_run(square):
    scene = pf.Scene(square)
    scene["geometry"] = {"bounds": {"min": [0, 0], "max": [1, 1]}}
    scene.cloud = pf.Cloud([[0.25, 0.5], [0.75, 0.5]], [0.5, -0.5])
    with pytest.raises(pf.CloudError, match="volume of point 1 is -0.5"):
        pf.Simulation(scene)
    with pytest.raises(pf.CloudError, match=r"\(n, 2\) or \(n, 3\)"):
        pf.Cloud([1.0, 2.0], 1.0)


def test_space_is_as_good_as_the_plane():
    scene = pf.case("reservoir-3d").update({"geometry.points": [10, 10, 6]})
    run = pf.Simulation(scene, out=False).run()
    assert run.positions.shape == (600, 3) and run.fields["velocity"].shape == (600, 3)
    assert run.picture()[:8] == b"\x89PNG\r\n\x1a\n"


def test_a_report_is_one_page(square):
    run = pf.Simulation(square).run()
    page = run.report()
    assert page.name == "report.html" and "drains" in page.read_text()
    with pytest.raises(pf.StateError, match="wrote no files"):
        pf.Simulation(square, out=False).run().report()


def test_temporary_files_live_as_long_as_the_run(square):
    run = pf.Simulation(square).run()
    folder = run.folder
    assert (folder / "summary.json").is_file()
    del run
    assert not folder.exists()


def test_a_run_shows_itself_in_notebooks(square):
    text = pf.Simulation(square, out=False).run()._repr_html_()
    assert "data:image/png;base64," in text and "scheme" in text
    assert "1e-12" in pf.Scene(square)._repr_html_()


def test_a_solver_that_is_not_there_is_told(square):
    with pytest.raises(pf.PerifracError) as caught:
        pf.Simulation(pf.Scene(square).changed({"solver.name": "superlu"}), out=False).run()
    assert "superlu" in str(caught.value)


def test_a_run_that_does_not_converge_keeps_its_last_state():
    scene = pf.case("terzaghi").update({"geometry.spacing": 0.5, "scheme.name": "explicit", "time.step": "1 s"})
    simulation = pf.Simulation(scene, out=False)
    with pytest.raises(pf.NotConverged, match="audit.lag") as caught:
        simulation.run()
    kept = caught.value.run
    assert kept is simulation.result and kept.stopped == "NotConverged" and kept.summary is None
    assert kept.time == kept.history["time"][-1] == 14.0
    assert np.isfinite(kept.fields["pressure"]).all() and caught.value.exit_code == 4
