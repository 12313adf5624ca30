"""Histories, sweeps, tables, grids, and packages that may be absent."""

import builtins
import doctest

import numpy as np
import pytest

import perifrac as pf
from perifrac._fields import Ground, boxes_of, middle_layer


@pytest.fixture(scope="module")
def fracture():
    """A crack that is pumped, up to a length."""
    simulation = pf.Simulation(pf.case("kgd-viscosity/smoke"), threads=2, out=False)
    longer = lambda s: s.stop("long enough") if s.history["crack_length"][-1] > 0.35 else None  # noqa: E731
    return simulation.run(on_step=longer)


def test_a_crack_is_watched_and_stopped(fracture):
    assert fracture.stopped == "long enough"
    length = fracture.history["crack_length"]
    assert length[-1] > 0.35 >= length[-2]
    assert fracture.fields["damage"].max() > 0.9 and fracture.fields.shown() == "damage"


def test_columns_are_found_without_their_unit(fracture):
    history = fracture.history
    assert history.heading("pressure.main") == "crack_pressure_main_Pa"
    assert history.heading("time") == "time_s" and "pressure_main" in history and "nothing" not in history
    with pytest.raises(KeyError, match="crack_length_m"):
        history["nothing"]
    with pytest.raises(ValueError, match="read-only"):
        history["time"][0] = 1


def test_a_history_is_a_table_and_a_curve(fracture):
    pandas = pytest.importorskip("pandas")
    table = fracture.history.to_pandas()
    assert isinstance(table, pandas.DataFrame) and list(table.columns) == fracture.history.columns
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    axes = fracture.history.plot("time", "pressure.main")
    x, y = axes.lines[0].get_data()
    assert np.array_equal(x, table["time_s"]) and np.array_equal(y, table["crack_pressure_main_Pa"])
    assert axes.get_xlabel() == "time [s]" and axes.get_ylabel() == "crack pressure main [Pa]"


def test_a_sweep_is_a_table(square):
    scene = pf.Scene(square)
    values = {"fluid.viscosity": ["1 mPa s", "10 mPa s"], "time.end": [0.5, 1.0]}
    mean = lambda run: {"mean": float(run.fields["pressure"].mean())}  # noqa: E731
    table = pf.sweep(scene, values, jobs=2, measure=mean)
    assert [(row["fluid.viscosity"], row["time.end"]) for row in table] == [
        (viscosity, end) for viscosity in values["fluid.viscosity"] for end in values["time.end"]
    ]
    assert table.column("status") == ["done"] * 4
    for row in table:
        changes = {key: row[key] for key in values}
        run = pf.Simulation(scene.changed(changes), out=False).run()
        assert row["mean"] == run.fields["pressure"].mean() and row["steps"] == run.steps
    assert table[0]["mean"] > table[1]["mean"] and table[2]["mean"] > table[0]["mean"]
    assert "<table>" in table._repr_html_()
    pandas = pytest.importorskip("pandas")
    assert isinstance(table.to_pandas(), pandas.DataFrame)


def test_a_run_of_a_sweep_that_fails_is_a_row(square):
    table = pf.sweep(square, {"fluid.viscosity": [1e-3, -1.0]})
    assert table.column("status") == ["done", "SceneError"] and "viscosity" in table[1]["error"]
    with pytest.raises(pf.SceneError):
        pf.sweep(square, {"fluid.viscosity": [-1.0]}, on_error="raise")


def test_cells_that_touch_share_corners():
    x, y = np.meshgrid(np.arange(3) + 0.5, np.arange(2) + 0.5)
    plane = Ground(2, np.column_stack([x.ravel(), y.ravel()]), np.ones((6, 2)))
    corners, boxes = boxes_of(plane)
    assert corners.shape == (12, 3) and boxes.shape == (6, 4)
    centres = corners[boxes].mean(axis=1)
    assert np.allclose(centres[:, :2], plane.positions) and not corners[:, 2].any()
    points = np.array([(i, j, k) for k in range(4) for j in range(2) for i in range(2)], dtype=float)
    space = Ground(3, points, np.ones((16, 3)))
    corners, boxes = boxes_of(space)
    assert corners.shape == (45, 3) and np.allclose(corners[boxes].mean(axis=1), points)
    assert list(middle_layer(space)) == [4, 5, 6, 7]


def test_a_grid_of_pyvista_has_the_fields(fracture):
    pyvista = pytest.importorskip("pyvista")
    grid = fracture.to_pyvista()
    assert isinstance(grid, pyvista.UnstructuredGrid)
    assert grid.n_cells == len(fracture.positions)
    assert np.array_equal(grid.cell_data["damage"], fracture.fields["damage"])


def test_absent_packages_are_told_by_name(fracture, monkeypatch):
    real = builtins.__import__

    def absent(name, *rest, **more):
        if name.split(".")[0] in ("pandas", "pyvista", "matplotlib"):
            raise ImportError(name)
        return real(name, *rest, **more)

    import importlib

    monkeypatch.setattr(importlib, "import_module", lambda name: absent(name))
    for call, package in [
        (fracture.history.to_pandas, "pandas"),
        (fracture.to_pyvista, "pyvista"),
        (lambda: fracture.history.plot("time", "crack_length"), "matplotlib"),
        (pf.Table().to_pandas, "pandas"),
    ]:
        with pytest.raises(pf.MissingPackage, match=f"pip install {package}"):
            call()


def test_the_example_of_the_package_is_right():
    assert doctest.testmod(pf).failed == 0


def test_errors_have_the_exit_codes_of_the_program():
    codes = {"UsageError": 2, "SceneError": 3, "PlanError": 3, "RefusedError": 3, "RunError": 1, "NotConverged": 4}
    codes.update({"OutputError": 1, "CheckpointError": 1, "SolverUnavailable": 2, "Interrupted": 130})
    for name, code in codes.items():
        kind = getattr(pf, name)
        assert kind.exit_code == code and issubclass(kind, pf.PerifracError)
