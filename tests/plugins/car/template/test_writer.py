"""A car that is saved as a template, and the cars that begin with it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bozzetto.cli.main import main
from bozzetto.errors import UserError
from bozzetto.plugin import Command, Context
from bozzetto_car.body.build import body_of
from bozzetto_car.commands import all_commands
from bozzetto_car.marks_file import car_from_facts, car_of_template
from bozzetto_car.modeler import Car
from bozzetto_car.solver.pipeline import solve_car
from bozzetto_car.solver.proportions import kin_directions, outer_dimensions
from bozzetto_car.state import CarState, MovedNode, Treatment
from bozzetto_car.template.loader import TEMPLATES, bundled, faults_in, read_template
from bozzetto_car.template.model import Template
from bozzetto_car.template.shape_constraints import Soundness
from bozzetto_car.template.writer import ROOM
from tests.plugins.car.drawn_cars import drawn, marks_in
from tests.plugins.car.marked_car import marked
from tests.plugins.car.marked_points import marked as marked_points
from tests.plugins.car.sketched import FRONT_QUARTER, apart, rms
from tests.plugins.car.unseen import KINDS, pictured, unseen

SAME = 1e-9
"""Distance of two bodies that are one, mm."""

COUPE = KINDS["coupé"]


def save(state: CarState, name: str = "My car") -> bytes:
    (found,) = (one for one in all_commands() if one.id == "save-template")
    assert isinstance(found, Command)
    assert found.writes == ".json"
    written = found.run(state, Context(file=name))
    assert isinstance(written, bytes)
    return written


def begun_with(written: bytes) -> CarState:
    return car_of_template(json.loads(written))


def edited() -> CarState:
    """A car with edits of all kinds but strokes, some of them made under other dimensions."""
    state = marked(2)
    moved = MovedNode(node="R2.R", by=(20.0, 5.0, 9.0))
    state = replace(state, edits=(moved, Treatment(kind="reduce")), length=4812.0, height=1390.0)
    again = MovedNode(dimensions=state.dimensions, node="S3.L", by=(0.0, -12.0, 4.0))
    return replace(state, edits=(*state.edits, again))


CARS = {
    "sedan": lambda: car_from_facts(marks_in("sedan"), {}),
    "hatchback": lambda: car_from_facts(marks_in("hatchback"), {}),
    "minivan": lambda: car_from_facts(marks_in("minivan"), {}),
    "edited": edited,
    "long": lambda: CarState(template="minivan", length=5400.0),
}


@pytest.mark.parametrize("name", CARS)
def test_a_car_that_is_saved_and_begun_with_is_the_same_body(name: str) -> None:
    state = CARS[name]()
    body, written = body_of(state), save(state)
    begun = begun_with(written)
    again = body_of(begun)
    assert np.abs(again.nets - body.nets).max() <= SAME
    assert np.abs(again.network.positions - body.network.positions).max() <= SAME
    assert again.template.title == "My car"


def test_saving_twice_changes_nothing() -> None:
    first = save(edited())
    begun = begun_with(first)
    pushed = replace(begun, edits=(MovedNode(node="C4", by=(0.0, 0.0, 0.0)),))
    told, twice = json.loads(first), json.loads(save(pushed))
    assert told.pop("about") != twice.pop("about")
    assert told == twice


@pytest.mark.parametrize("name", ["", "  ", "911", "Ünïcode & Co", "x" * 300, "Old   van\n2"])
def test_every_name_of_a_file_makes_a_title_and_an_id(name: str) -> None:
    template = read_template(save(CarState(length=4700.0), name))
    assert template.title.strip()
    assert len(template.title) <= 200


def test_a_saved_template_keeps_its_rules_with_room_and_only_these_are_eased(
    tmp_path: Path,
) -> None:
    # Of the 20 mm by which a wheel may be higher; the rule is about diameters.
    state = replace(CarState(), edits=(MovedNode(node="WF.R", by=(0.0, 0.0, 12.0)),))
    written = save(state)
    old, new = (json.loads(one)["soundness"] for one in (state.template_source, written))
    changed = {name for name in old if old[name] != new[name]}
    assert changed == {"The front wheel is no more than 4 cm higher than the rear one"}
    own = read_template(written)
    least = Soundness.of(own).least(own.variables)
    assert min(least.values()) >= ROOM
    (tmp_path / "car.json").write_bytes(written)
    assert faults_in(tmp_path / "car.json") == []


def test_a_rule_that_was_switched_off_is_no_rule_of_the_template() -> None:
    name = "The A-pillar leans inward"
    written = save(replace(CarState(length=4700.0), without=(name,)))
    assert name not in json.loads(written)["soundness"]


def test_a_car_that_folds_is_refused_and_says_where() -> None:
    folded = replace(CarState(), edits=(MovedNode(node="S3.R", by=(1800.0, 0.0, 0.0)),))
    with pytest.raises(UserError, match=r"cannot become a template: .* Undo the last edit"):
        save(folded)


def test_a_fold_that_no_edit_made_is_not_blamed_on_the_last_edit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    folded = replace(CarState(), edits=(MovedNode(node="S3.R", by=(1800.0, 0.0, 0.0)),))
    body = body_of(folded)
    monkeypatch.setattr("bozzetto_car.commands.body_in_work", lambda state: body)
    with pytest.raises(UserError, match=r"cannot become a template: .* Drag the marks there apart"):
        save(CarState(length=4700.0))


def test_nothing_is_saved_before_the_camera_is_known() -> None:
    state = marked(0)
    (sketch,) = state.sketches
    with pytest.raises(UserError, match="Mark its points first"):
        save(state.with_node(replace(sketch, marks=sketch.marks[:3])))


def own_template(seed: int) -> Template:
    """The template of a coupé, saved from a solve of one sketch of it."""
    return read_template(save(pictured("coupé", "perspective", seed)[2].state))


def test_what_varies_of_a_saved_template_are_proportions_and_ways_to_others() -> None:
    own = own_template(41)
    ways = kin_directions(own)
    assert ways.shape[1] == len(TEMPLATES)  # the sedan that it came from is now another car
    before = outer_dimensions(own, own.positions)
    for way in ways.T:
        assert np.abs(way).max() > 10.0
        after = outer_dimensions(own, own.whole(own.variables + 0.2 * way))
        assert np.abs(after / before - 1.0).max() < 0.02


@pytest.mark.parametrize("seed", [52, 53])
def test_a_sister_car_is_nearer_with_the_saved_template(seed: int) -> None:
    """Who saves a coupé and sketches another one gets it better than with the sedan."""
    sister = unseen(COUPE, seed)
    source = save(pictured("coupé", "perspective", 51)[2].state).decode()
    case = marked_points(bundled("sedan"), sister, (FRONT_QUARTER,), seed, 2.0)
    errors = [
        rms(apart(solve_car(state).positions, sister))
        for state in (case.state, replace(case.state, template="own", own=source))
    ]
    assert errors[1] < errors[0]


# -- choosing it -----------------------------------------------------------------------------------


def test_another_template_can_be_chosen_and_ones_own_again() -> None:
    own = begun_with(save(CarState(length=5100.0)))
    other = replace(own, template="hatchback")
    assert body_of(other).template is bundled("hatchback")
    assert body_of(replace(other, template="own")).template.title == "My car"


def test_who_has_no_template_of_their_own_is_told_where_one_comes_from() -> None:
    with pytest.raises(UserError, match="import the file"):
        body_of(CarState(template="own"))


def test_a_document_of_an_older_version_keeps_its_own_template() -> None:
    stored: dict[str, Any] = {"template": "sedan", "own": "{}", "trace": 0.5}
    assert Car().upgrade(stored, 1) == {**stored, "template": "own"}
    assert Car().upgrade({**stored, "own": ""}, 1)["template"] == "sedan"


def test_the_command_line_saves_checks_and_begins_with_a_template(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    marks, saved = tmp_path / "marks.json", tmp_path / "coupe.json"
    told = drawn(bundled("sedan"), 91).marks_file()
    marks.write_text(json.dumps(told), "utf-8")
    assert main(["build", "car", str(marks), "-o", str(saved), "--command", "save-template"]) == 0
    assert main(["plugins", "check", str(saved)]) == 0
    # The same by way of a document, and the file begins a car of its own.
    document, again = tmp_path / "car.bozz", tmp_path / "again" / "coupe.json"
    assert main(["build", "car", str(marks), "-o", str(document)]) == 0
    assert main(["export", str(document), "-o", str(again), "--command", "save-template"]) == 0
    assert again.read_bytes() == saved.read_bytes()
    begun = tmp_path / "begun.bozz"
    assert main(["build", "car", str(saved), "-o", str(begun), "--set", "length=4400"]) == 0
    inline = {**told, "template": json.loads(saved.read_text("utf-8"))}
    marks.write_text(json.dumps(inline), "utf-8")
    assert main(["build", "car", str(marks), "-o", str(tmp_path / "car.step")]) == 0
    capsys.readouterr()
    wrong = ["build", "car", str(marks), "-o", str(tmp_path / "a.step"), "--command"]
    assert main([*wrong, "save-template"]) == 2
    assert "writes a .json file" in capsys.readouterr().err
    assert main([*wrong, "anneal"]) == 2
    assert "writes no file" in capsys.readouterr().err
    assert not (tmp_path / "a.step").exists()
