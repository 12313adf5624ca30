"""Sources and forces in Python."""

import math

import numpy as np
import pytest

import perifrac as pf

BOX = """
title = "Rain on a closed box"
geometry = { type = "lattice", size = ["2 m", "1 m"], points = [40, 20] }
fluid.viscosity = "1 mPa s"
materials.soil = { permeability = "1e-12 m^2", storage = "1e-7 1/Pa" }
[flow]
initial_pressure = "1 bar"
[time]
end = "100 s"
step = "500 ms"
"""


def test_a_uniform_leak_raises_the_pressure_as_the_storage_says():
    leak = pf.source(lambda time, points: 1e-6 * points.volume, constant=True)
    run = pf.Simulation(BOX, out=False, loads=[leak]).run()
    assert run.fields["pressure"] == pytest.approx(1e5 + 1e-6 / 1e-7 * 100, abs=1e-3)
    assert run.summary["balance"]["mass"] < 1e-10


def test_rain_that_swings_leaves_what_fell():
    amount, period = 2e-3, 50.0

    def rain(time, points):
        wet = np.where(points.position[:, 1] > 0.9, points.volume, 0.0)
        return amount / period * (1 - math.cos(2 * math.pi * time / period)) * wet / wet.sum()

    run = pf.Simulation(BOX, out=False, loads=[pf.source(rain)]).run()
    rise = run.fields["pressure"].mean() - 1e5
    assert rise == pytest.approx(2 * amount / (2 * 1e-7), rel=1e-9)
    assert run.summary["counters"]["evaluations"]["rain"] > 200


def test_a_force_is_as_good_as_the_body_force_of_the_scene():
    scene = pf.Scene(
        {
            "title": "A clamped block under a force",
            "geometry": {"type": "lattice", "size": [1, 1], "points": [12, 12]},
            "materials": {"rock": {"youngs_modulus": "1 GPa", "poissons_ratio": 0.2}},
            "mechanics": {"boundary": {"bottom": {"clamped": True}}},
            "time": {"mode": "steady"},
        }
    )
    own = scene.changed({"mechanics.body_force": [1e4, -2e4]})
    theirs = pf.Simulation(own, out=False).run()
    load = pf.force(lambda time, points: points.volume[:, None] * [1e4, -2e4])
    ours = pf.Simulation(scene, out=False, loads=[load]).run()
    exact = theirs.fields["displacement"]
    assert np.abs(exact).max() > 1e-6
    assert ours.fields["displacement"] == pytest.approx(exact, rel=1e-9, abs=1e-15)


def test_a_load_is_asked_once_for_a_time():
    asked = []

    def leak(time, points):
        asked.append(time)
        return 1e-6 * points.volume

    pf.Simulation(BOX, out=False, loads=[pf.source(leak, breakpoints=[33.3])]).run()
    assert 33.3 in asked and len(asked) < 1.3 * len(set(asked))


def test_an_exception_of_a_load_ends_the_run():
    def broken(time, points):
        if time > 10:
            raise ZeroDivisionError("no rain")
        return 0.0

    simulation = pf.Simulation(BOX, out=False, loads=[pf.source(broken)])
    with pytest.raises(ZeroDivisionError, match="no rain"):
        simulation.run()
    assert 0 < simulation.result.time <= 10


def test_values_that_do_not_fit_are_told():
    for value, told in [(np.zeros(3), r"array of shape \(3,\).*\(800,\)"), (math.nan, "not finite at point 0")]:
        load = pf.source(lambda time, points: value, name="rain")
        with pytest.raises(pf.LoadError, match=told):
            pf.Simulation(BOX, out=False, loads=[load]).run()


def test_a_run_with_loads_goes_on_only_with_them(tmp_path):
    load = pf.source(lambda time, points: 1e-6 * points.volume, name="leak")
    whole = pf.Simulation(BOX, out=False, loads=[load]).run()
    pf.Simulation(BOX, out=tmp_path / "run", loads=[load]).run(on_step=lambda s: s.stop() if s.time > 50 else None)
    with pytest.raises(pf.CheckpointError, match='"leak"'):
        pf.Simulation.resume(tmp_path / "run").run()
    run = pf.Simulation.resume(tmp_path / "run", loads=[load]).run()
    assert np.array_equal(run.fields["pressure"], whole.fields["pressure"])
