"""Stopping, going on, and what happens meanwhile."""

import _thread
import signal
import threading
import time

import numpy as np
import pytest

import perifrac as pf

#: Steps of a fixed length, so that there is time to stop.
MANY = {"time.step": "1 ms", "geometry.points": [60, 60]}


def test_a_stop_ends_a_run_like_its_end(tmp_path, square):
    simulation = pf.Simulation(square, out=tmp_path / "run")
    run = simulation.run(on_step=lambda step: step.stop("long enough") if step.steps == 5 else None)
    assert run.stopped == "long enough" and run.steps == 5 and run.time < 1.0
    assert run.summary["t_end"] == run.time == run.history["time"][-1]
    assert run.report().is_file() and list((tmp_path / "run").glob("pressure-*.png"))


@pytest.mark.parametrize("again", ["same", "other", "program"])
def test_a_run_that_goes_on_has_the_same_bits(tmp_path, terzaghi, cli, again):
    whole = pf.Simulation(terzaghi, out=tmp_path / "whole").run()
    first = pf.Simulation(terzaghi, out=tmp_path / "halves")
    first.run(on_step=lambda step: step.stop() if step.steps == 7 else None)
    if again == "same":
        run = first.run()
    elif again == "other":
        run = pf.Simulation.resume(tmp_path / "halves").run()
    else:
        cli("resume", "halves", folder=tmp_path)
    if again != "program":
        assert run.stopped is None
        for name, value in whole.fields.items():
            assert np.array_equal(run.fields[name], value), name
        for name, column in whole.history.items():
            assert np.array_equal(run.history[name], column), name
    for path in (tmp_path / "whole").glob("*"):
        if path.suffix in (".csv", ".vtu", ".png"):
            assert path.read_bytes() == (tmp_path / "halves" / path.name).read_bytes(), path.name


def test_a_checkpoint_of_another_scene_is_refused(tmp_path, square):
    pf.Simulation(square, out=tmp_path / "run").run()
    other = pf.Scene(square).changed({"time.end": 3})
    with pytest.raises(pf.CheckpointError, match="another scene"):
        pf.Simulation.resume(tmp_path / "run", other)
    with pytest.raises(pf.CheckpointError):
        pf.Simulation.resume(tmp_path)


def test_a_folder_of_somebody_else_is_left_alone(tmp_path, square):
    (tmp_path / "letter.txt").write_text("dear all")
    with pytest.raises(pf.OutputError, match="holds no results"):
        pf.Simulation(square, out=tmp_path).run()


def test_without_files_a_stopped_run_says_that_it_cannot_go_on(square):
    simulation = pf.Simulation(square, out=False)
    simulation.run(on_step=lambda step: step.stop())
    with pytest.raises(pf.StateError, match="no checkpoint"):
        simulation.run()


def test_other_threads_go_on_while_a_step_is_computed(square):
    count, done = 0, threading.Event()

    def work():
        nonlocal count
        while not done.is_set():
            count += 1
            time.sleep(0.001)

    scene = pf.Scene(square).changed({**MANY, "geometry.points": [250, 250]})
    other = threading.Thread(target=work)
    other.start()
    simulation = pf.Simulation(scene, out=False, threads=1)
    begun = time.perf_counter()
    simulation.step()
    wall, seen = time.perf_counter() - begun, count
    done.set()
    other.join()
    simulation.close()
    # A thread that waits for the step would have counted next to nothing.
    assert seen > 0.2 * wall / 0.0015, (seen, wall)


@pytest.fixture
def interrupts():
    """Ctrl-C as in a terminal: in the background of a shell it is ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_ctrl_c_keeps_the_state_and_the_run_goes_on(tmp_path, square, interrupts):
    scene = pf.Scene(square).changed(MANY)
    simulation = pf.Simulation(scene, out=tmp_path / "run")
    simulation.step()
    timer = threading.Timer(0.3, _thread.interrupt_main)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        simulation.run()
    stopped = simulation.result
    assert stopped.stopped == "Ctrl-C" and 0 < stopped.time < 1.0
    assert stopped.fields["pressure"].shape == (3600,)
    # What the run computed while Ctrl-C was on its way is in memory as in the file.
    kept = np.loadtxt(tmp_path / "run" / "history.csv", delimiter=",", skiprows=1, usecols=0)
    begun = stopped.history.rows
    assert begun == len(kept) and stopped.history["time"][-1] == stopped.time
    run = simulation.run(on_step=lambda step: step.stop() if step.history.rows == begun + 3 else None)
    assert run.history.rows == begun + 3 and (np.diff(run.history["time"]) > 0).all()


def test_an_error_in_on_step_leaves_the_run_where_it_is(square):
    simulation = pf.Simulation(square, out=False)

    def fail(step):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        simulation.run(on_step=fail)
    assert simulation.run().time == 1.0


def test_one_thread_at_a_time_steps_a_run(square):
    simulation = pf.Simulation(pf.Scene(square).changed(MANY), out=False)
    simulation.step()
    worker = threading.Thread(target=lambda: pytest.raises(pf.Interrupted, simulation.run))
    worker.start()
    time.sleep(0.1)
    with pytest.raises(pf.StateError, match="one thread at a time"):
        simulation.step()
    simulation.interrupt()
    worker.join()


def test_a_run_that_is_left_frees_its_folder(tmp_path, square):
    for _ in range(3):
        with pf.Simulation(square, out=tmp_path / "run") as simulation:
            simulation.step()


def test_fields_are_read_only_and_no_copies(square):
    simulation = pf.Simulation(square, out=False)
    first = simulation.step()
    pressure = first.fields["pressure"]
    assert first.fields["pressure"] is pressure and not pressure.flags.writeable
    assert not pressure.flags.owndata and pressure.base is not None
    assert np.shares_memory(pressure, np.asarray(first.fields["pressure"]))
    with pytest.raises(ValueError, match="read-only"):
        pressure[0] = 1.0
    velocity = first.fields["velocity"]
    assert velocity.shape == (400, 2) and not velocity.flags.writeable and not velocity.base.flags.writeable
    before = pressure.copy()
    last = simulation.run()
    del simulation
    assert np.array_equal(pressure, before) and not np.array_equal(last.fields["pressure"], before)
    assert last.fields.units["pressure"] == "Pa"


def test_fields_are_asked_for_in_time(square):
    simulation = pf.Simulation(square, out=False)
    first = simulation.step()
    simulation.step()
    with pytest.raises(pf.StateError, match="gone on"):
        first.fields
    with pytest.raises(KeyError, match="it has pressure"):
        simulation.fields["damage"]


def test_progress_is_one_line(square, capsys):
    pf.Simulation(square, out=False).run(progress=True)
    told = capsys.readouterr().err
    assert told.count("\n") == 1 and "100%" in told


def test_warnings_are_those_of_python():
    scene = pf.case("terzaghi").update({"geometry.spacing": 0.5, "scheme.name": "staggered", "time.step": 3})
    scene["scheme.coupling_tolerance"] = 1e-3
    scene["audit.mass"] = 1
    with pytest.warns(pf.PerifracWarning, match="mass is balanced"):
        run = pf.Simulation(scene, out=False).run()
    assert any("mass is balanced" in warning for warning in run.warnings)


def test_stages_that_follow_each_other_are_those_of_the_program(tmp_path, square, cli):
    text = square + '[[stages]]\nname = "drain"\n[[stages]]\nname = "fill"\n'
    text += '[stages.flow.boundary.right]\npressure = "2 bar"\n[stages.time]\nend = "2 s"\n'
    (tmp_path / "scene.toml").write_text(text)
    cli("run", "scene.toml", "--out", "theirs", folder=tmp_path)
    before = None
    for stage in pf.Scene(text).stages():
        if before is not None:
            stage["start.from"] = str(before)
        run = pf.Simulation(stage, out=tmp_path / stage.name).run()
        before = run.folder
    assert run.time == 2.0
    theirs = tmp_path / "theirs" / "02-fill" / "history.csv"
    assert (before / "history.csv").read_bytes() == theirs.read_bytes()
