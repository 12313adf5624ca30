"""Scenes: where they come from, how they are changed, and how their faults are told."""

import numpy as np
import pytest

import perifrac as pf
from perifrac import _toml


def test_a_fault_is_underlined_where_it_stands(square):
    with pytest.raises(pf.SceneError) as caught:
        pf.check(pf.Scene(square.replace('"1e-12 m^2"', '"3 MPa"')))
    text = str(caught.value)
    assert 'expected a permeability (m^2), found a pressure: "3 MPa"' in text
    assert "^^^^^^^" in text and "scene:5:" in text
    assert caught.value.exit_code == 3
    assert caught.value.diagnostics[0][0].startswith("expected a permeability")
    assert isinstance(caught.value, ValueError)


def test_all_faults_come_at_once_with_a_guess(square):
    scene = pf.Scene(square).update({"time.ned": "2 s", "fluid.viscosity": -1})
    with pytest.raises(pf.SceneError) as caught:
        pf.plan(scene)
    assert "did you mean `end`?" in str(caught.value)
    assert len(caught.value.diagnostics) == 2


def test_an_error_of_the_points_is_underlined_in_the_scene(square):
    hole = 'region = { type = "disc", centre = [9, 9], radius = 0.1 }'
    scene = pf.Scene(square + f"[materials.hole]\npermeability = 1e-12\nstorage = 1e-9\n{hole}\n")
    with pytest.raises(pf.PlanError) as caught:
        pf.check(scene)
    assert "^^^" in str(caught.value) and "hole" in str(caught.value)


def test_what_cannot_be_combined_is_refused():
    scene = pf.case("terzaghi").changed({"solver.name": "faer-llt"})
    with pytest.raises(pf.RefusedError, match="refuses a quasi-definite system") as caught:
        pf.check(scene)
    assert caught.value.exit_code == 3
    clash = pf.case("five-spot").update({"scheme.name": "explicit", "time.mode": "steady"})
    with pytest.raises(pf.SceneError, match="steady"):
        pf.check(clash)


def test_the_message_is_that_of_the_program(square, cli, tmp_path):
    (tmp_path / "scene.toml").write_text(square.replace("time.end", "time.ned"))
    told = cli("check", "scene.toml", folder=tmp_path, code=3)
    with pytest.raises(pf.SceneError) as caught:
        pf.check(pf.Scene(square.replace("time.end", "time.ned")))
    assert str(caught.value) == told.replace("scene.toml", "scene").rstrip()


def test_a_dict_is_as_good_as_a_text(square):
    scene = {
        "title": "A square that drains to the left",
        "geometry": {"type": "lattice", "size": ["1 m", "1 m"], "points": (20, np.int64(20))},
        "fluid": {"viscosity": "1 mPa s"},
        "materials": {"sand": {"permeability": np.float64(1e-12), "storage": "1e-9 1/Pa"}},
        "flow": {"initial_pressure": "1 bar", "boundary": {"left": {"pressure": 0}}},
        "time": {"end": 1},
    }
    ours, theirs = (pf.Simulation(own, out=False).run() for own in (scene, square))
    assert np.array_equal(ours.fields["pressure"], theirs.fields["pressure"])


def test_a_fault_in_a_dict_has_its_line():
    scene = {"title": "t", "geometry": {"type": "lattice", "size": [1, 1], "points": [9, 9]}, "time": {"end": "2 m"}}
    with pytest.raises(pf.SceneError, match="found a length"):
        pf.check(scene)


def test_keys_are_read_and_changed_by_their_path():
    scene = pf.case("natural-fractures/smoke")
    assert scene["geometry.spacing"] == "2 cm"
    scene["fluid.viscosity"] = "5 mPa s"
    assert scene["fluid.viscosity"] == "5 mPa s" and "fluid.nothing" not in scene
    other = scene.changed({"fluid.viscosity": 1e-3})
    assert scene["fluid.viscosity"] == "5 mPa s" and other["fluid.viscosity"] == 1e-3
    with pytest.raises(KeyError, match="fluid.nothing"):
        scene["fluid.nothing"]
    assert scene.name == "natural-fractures-smoke"


def test_unknown_cases_and_variants_are_told_by_name():
    with pytest.raises(pf.UsageError, match="did you mean terzaghi"):
        pf.case("terzagi")
    with pytest.raises(pf.UsageError, match='has no variant "huge": it has smoke'):
        pf.case("notched-tension/huge")
    assert pf.UsageError.exit_code == 2


def test_every_case_is_there_and_can_be_read():
    cases = pf.cases()
    assert len(cases) > 25 and all(case.summary and case.readme for case in cases)
    for case in cases:
        for name in [case.name, *(f"{case.name}/{variant}" for variant in case.variants)]:
            scene = pf.case(name)
            if not scene.stages():
                assert scene["title"]


def test_a_file_has_its_base_and_its_folder(square, tmp_path, monkeypatch):
    (tmp_path / "scene.toml").write_text(square)
    (tmp_path / "longer.toml").write_text('base = "scene.toml"\ntime.end = "2 s"\n')
    scene = pf.Scene(tmp_path / "longer.toml")
    assert scene["time.end"] == "2 s" and scene.name == f"{tmp_path.name}-longer"
    assert pf.Scene(tmp_path / "scene.toml").name == tmp_path.name
    monkeypatch.chdir(tmp_path)
    assert pf.plan("scene.toml").data["points"] == 400
    with pytest.raises(pf.SceneError, match="nowhere.toml"):
        pf.Scene("nowhere.toml")


def test_a_plan_is_that_of_the_program(cli):
    plan = pf.plan("five-spot")
    assert plan.data["points"] == 40000 and "five-spot" in plan
    told = cli("plan", "five-spot")
    # Only memory that is free on the machine may be told in addition.
    assert all(line in told for line in plan.splitlines())


def test_stages_are_scenes_of_their_own():
    stages = pf.case("staged-injection").stages()
    assert len(stages) == 4 and stages[1]["start.clock"] == "keep"
    with pytest.raises(pf.UsageError, match="stages"):
        pf.Simulation("staged-injection")


def test_values_become_toml():
    assert _toml.literal('a "b"\n') == '"a \\"b\\"\\n"'
    assert _toml.literal([True, 1, 1e-300, "1 m"]) == '[true, 1, 1e-300, "1 m"]'
    assert _toml.literal({"a b": np.array([1.5, 2.0])}) == '{"a b" = [1.5, 2.0]}'
    with pytest.raises(pf.UsageError, match="time.end: a scene cannot hold None"):
        pf.Scene("terzaghi = 1")["time.end"] = None


def test_lists_of_sections_become_toml():
    text = _toml.document({"a": 1, "b": {"c": {"d": 2}}, "e": [{"f": 3}, {"f": {"g": 4}}]})
    assert text == "a = 1\n\n[b.c]\nd = 2\n\n[[e]]\nf = 3\n\n[[e]]\nf = {g = 4}\n"
