"""Marks from a file: all of it comes in, and nothing that makes no sense."""

from __future__ import annotations

import copy
import json
import random
from typing import Any

import numpy as np
import pytest

from bozzetto.errors import Cancelled, UserError
from bozzetto.plugin import Job
from bozzetto.scene import Picture
from bozzetto_car.body.build import body_of
from bozzetto_car.marks_file import car_from_facts
from bozzetto_car.state import CarState
from bozzetto_car.template.loader import bundled
from tests.plugins.car.drawn_cars import GALLERY, GALLERY_CARS, drawn


def told(name: str) -> dict[str, Any]:
    read: dict[str, Any] = json.loads((GALLERY / f"{name}.json").read_text("utf-8"))
    return read


@pytest.mark.parametrize("name", GALLERY_CARS)
def test_all_that_a_file_tells_is_in_the_car(name: str) -> None:
    file = told(name)
    pixels = Picture.of(np.full((10, 16, 4), 255, np.uint8), "page")
    state = car_from_facts(file, {file["image"]["file"]: pixels})
    assert state.template == file["template"]
    assert len(state.sketches) == len(file["views"])
    for sketch, view in zip(state.sketches, file["views"], strict=True):
        assert {m.node: [m.u, m.v] for m in sketch.marks} == view["marks"]
        image = view.get("image", file["image"])
        assert sketch.size == (image["width"], image["height"])
        assert (sketch.picture is pixels) == (image["file"] == file["image"]["file"])
    strokes = [(edge, points) for v in file["views"] for edge, points in v["strokes"].items()]
    assert len(state.edits) == len(strokes)
    for edit, (_, points) in zip(state.edits, strokes, strict=True):
        assert np.abs(edit.strokes[0].points - np.array(points)).max() < 1e-3
    assert len(state.styling) == len(file["styling"])
    assert state.wheelbase == file["dimensions"].get("WB", 0.0)
    assert body_of(state).dimensions.wheelbase == pytest.approx(state.wheelbase, abs=1e-6)


def damaged(path: str, value: object) -> dict[str, Any]:
    """The sedan's file with another value in one place; a key that ends with ! goes."""
    file = told("sedan")
    place: Any = file
    *way, last = path.split("/")
    for key in way:
        place = place[int(key)] if isinstance(place, list) else place[key]
    if last.endswith("!"):
        del place[last[:-1]]
    else:
        place[last] = value
    return file


NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("views", {}, "views"),
        ("views", [], "views"),
        ("views", [{}] * 9, "views"),
        ("views", [7], r"views\[0\]"),
        ("views/0/marks", [1], r"views\[0\].marks"),
        ("views/0/marks!", None, r"views\[0\].marks"),
        ("views/0/marks/C1", [1.0], r"marks.C1"),
        ("views/0/marks/C1", [1.0, 2.0, 3.0], r"marks.C1"),
        ("views/0/marks/C1", [1.0, NAN], r"marks.C1"),
        ("views/0/marks/C1", [INF, 0.0], r"marks.C1"),
        ("views/0/marks/C1", [True, 0.0], r"marks.C1"),
        ("views/0/marks/C1", "12", r"marks.C1"),
        ("views/0/marks/", [1, 2], "name of a node"),
        ("views/0/marks", {f"N{k}": [1, 1] for k in range(500)}, "more than"),
        ("views/0/kind", "fisheye", r"views\[0\].kind"),
        ("views/0/cropped", 1, "cropped"),
        ("views/0/name", "", "name"),
        ("views/0/mark", {}, "“mark”"),
        ("views/0/strokes", [], "strokes"),
        ("views/0/strokes/C1-C2", [[1, 2]], "C1-C2"),
        ("views/0/strokes/C1-C2", [[1, 2]] * 30_000, "C1-C2"),
        ("views/0/image", {"width": 0, "height": 10}, "image.width"),
        ("views/0/image", 3, "image"),
        ("template", "coupé", "template"),
        ("template", 3, "template"),
        ("template", {}, "format"),
        ("dimensions", [], "dimensions"),
        ("dimensions/LEN", 3, "LEN"),
        ("dimensions/LN", -3, "dimensions.LN"),
        ("dimensions/LN", "4 m", "dimensions.LN"),
        ("styling", {}, "styling"),
        ("styling/0/view", 5, r"styling\[0\].view"),
        ("styling/0/view", True, r"styling\[0\].view"),
        ("styling/0/points!", None, r"styling\[0\].points"),
        ("styling/0/name", 5, r"styling\[0\].name"),
    ],
)
def test_what_makes_no_sense_is_refused_by_its_key(path: str, value: object, said: str) -> None:
    with pytest.raises(UserError, match=said):
        body_of(car_from_facts(damaged(path, value), {}))


def test_a_template_of_ones_own_stands_in_the_file() -> None:
    from importlib.resources import files

    own = json.loads(files("bozzetto_car").joinpath("templates/hatchback.json").read_text("utf-8"))
    own["title"] = "Van"
    file = told("hatchback") | {"template": own}
    state = car_from_facts(file, {})
    assert body_of(state).template.title == "Van"
    plain = body_of(car_from_facts(told("hatchback"), {}))
    assert (body_of(state).network.positions == plain.network.positions).all()


def test_marks_of_nodes_that_the_template_has_not_are_kept_and_told() -> None:
    file = told("sedan")
    file["views"][0]["marks"]["S6.R"] = [700.0, 400.0]
    state = car_from_facts(file, {})
    assert state.sketches[0].mark_of("S6.R") is not None
    plain = car_from_facts(told("sedan"), {})
    assert (body_of(state).network.positions == body_of(plain).network.positions).all()


@pytest.mark.parametrize("seed", range(30))
def test_damaged_files_give_a_car_or_a_message(seed: int) -> None:
    """Numbers, texts and lists exchanged, cut out and doubled at random."""
    rng = random.Random(seed)
    file: Any = drawn(bundled("sedan"), seed % 4).marks_file()
    for _ in range(rng.randint(1, 4)):
        place, steps = file, 0
        while isinstance(place, dict | list) and len(place) and steps < rng.randint(1, 5):
            keys = list(place) if isinstance(place, dict) else list(range(len(place)))
            key = rng.choice(keys)
            if not isinstance(place[key], dict | list) or rng.random() < 0.3:
                break
            place, steps = place[key], steps + 1
        if isinstance(place, dict | list) and len(place):
            keys = list(place) if isinstance(place, dict) else list(range(len(place)))
            wrong = [None, -1e300, 1e9, NAN, "x" * 300, [], {}, 0, True, [[1, 2]] * 3]
            place[rng.choice(keys)] = copy.deepcopy(rng.choice(wrong))
    try:
        state = car_from_facts(file, {})
        body = body_of(state)
    except UserError:
        return
    assert isinstance(state, CarState)
    assert np.isfinite(body.nets).all()


def test_marks_in_units_a_thousand_times_finer_make_the_same_car() -> None:
    file = drawn(bundled("sedan"), 91).marks_file()
    for view in file["views"]:
        del view["strokes"]
    fine = copy.deepcopy(file)
    for key in ("width", "height"):
        fine["image"][key] *= 1000
    for view in fine["views"]:
        view["marks"] = {k: [1000 * u, 1000 * v] for k, (u, v) in view["marks"].items()}
    one, other = (body_of(car_from_facts(told_, {})).network for told_ in (file, fine))
    assert np.abs(one.positions - other.positions).max() < 0.01


def test_styling_curves_of_a_file_can_be_stopped_between() -> None:
    """Thirty of them take seconds on a busy machine: nobody waits for a file that is closed."""
    file = told("hatchback")
    file["styling"] = [file["styling"][0]] * 30
    asked: list[float] = []
    job = Job(cancelled=lambda: len(asked) >= 2, progress=lambda share, step: asked.append(share))
    with pytest.raises(Cancelled):
        car_from_facts(file, {}, job)
    assert len(asked) == 2
