from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from bozzetto.errors import Cancelled, Unfinished, UserError
from bozzetto.geometry import Mesh, Shapes, Solid, Surface, cylinder
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Job
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.plugin.host.similar_names import meant_by
from bozzetto.scene import Layer, Scene
from bozzetto.testing import ModelerContract, Pen, same
from bozzetto.testing.checks import CHECKS
from bozzetto.testing.deep_equal import difference
from bozzetto.testing.spelling import MODELER_NAMES, TOOL_NAMES
from bozzetto.testing.subject import Broken, Subject
from bozzetto.view import Camera
from tests.core.plugin.conftest import FAULTY_MANIFEST


class TestMesh(ModelerContract):
    modeler = "bozzetto.mesh"


# -- the suite finds what is wrong -----------------------------------------------------------


def failing(subject):
    """Names of the checks that a modeler fails."""
    names = set()
    for check in CHECKS:
        # A process of its own knows nothing of the misdeeds.
        if check.name in ("elsewhere", "fresh_process"):
            continue
        try:
            check.run(subject)
        except (Broken, PluginFault):
            names.add(check.name)
    return names


def test_a_good_modeler_passes(subject):
    assert failing(subject) == set()


def counting():
    """A misdeed whose answers differ from call to call."""
    numbers = iter(range(1, 10_000))
    return lambda state, result: Shapes(
        surfaces=(Surface(Mesh(next(numbers) * np.eye(3), [[0, 1, 2]])),)
    )


def swallow(state, job):
    try:
        job.checkpoint(0.5, "half")
    except Cancelled:
        pass
    return 1.0


def spoil(state, job):
    object.__setattr__(state, "size", 5.0)
    return 1.0


def only_circles(state, gesture, context):
    if len(gesture.strokes[0]) < 3:
        raise IndexError
    return Scene()


def never_enough(state, gesture, context):
    if len(gesture.strokes[0]) < 3:
        raise Unfinished("go on")
    return replace(state, strokes=Strokes(gesture.strokes))


def narrow(state, job):
    if state.size in (0.0, 10.0):
        raise ZeroDivisionError
    return 1.0


def open_solid(state, result):
    if not len(state.strokes):
        return Shapes()
    return Shapes(solids=(Solid(Mesh(np.eye(3), [[0, 1, 2]])),))


def inside_out(state, result):
    if not len(state.strokes):
        return Shapes()
    return Shapes(breps=(cylinder((0, 0, 0), (0, 0, 9), 2.0).turned_over(),))


def open_at_the_end(state, result):
    """A tetrahedron, of which a face is missing where the size is the largest."""
    if not len(state.strokes):
        return Shapes()
    corners = np.vstack((np.zeros(3), np.eye(3)))
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    return Shapes(solids=(Solid(Mesh(corners, faces[: 3 if state.size == 10.0 else 4])),))


def remembering():
    """A misdeed whose preview shows how many strokes of a first point it has seen."""
    seen = {}

    def preview(state, gesture, context):
        key = float(gesture.strokes[0].x[0])
        seen[key] = max(seen.get(key, 0), len(gesture.strokes[0]))
        return Scene((Layer(f"{seen[key]} samples"),))

    return preview


WRONG = {
    "shapes that change": ("shapes", counting, {"storage", "cancelling", "determinism", "empty"}),
    "cancelling swallowed": ("solve", lambda: swallow, {"cancelling"}),
    "a state that is written to": (
        "solve",
        lambda: spoil,
        {"empty", "drawing", "history", "storage"},
    ),
    "a preview that fails": ("preview", lambda: only_circles, {"odd_previews"}),
    "a gesture that fails": ("apply", lambda: lambda s, g, c: 1 / 0, {"odd_gestures", "drawing"}),
    "unfinished for ever": ("apply", lambda: never_enough, {"odd_gestures"}),
    "an open solid": ("shapes", lambda: open_solid, {"drawing"}),
    "a closed brep that is inside out": ("shapes", lambda: inside_out, {"drawing"}),
    "an end of a range": ("solve", lambda: narrow, {"parameters"}),
    "a solid that opens at an end of a range": ("shapes", lambda: open_at_the_end, {"ranges"}),
    "an answer that was remembered": ("preview", remembering, {"forgetting"}),
    "nothing handed over": ("shapes", lambda: lambda s, r: Shapes(), {"drawing"}),
    "a scene that fails without a result": (
        "scene",
        lambda: lambda s, r: Scene((Layer(str(r + 1.0)),)),
        {"empty", "drawing"},
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_the_suite_finds(subject, faulty, name):
    what, misdeed, expected = WRONG[name]
    faulty.misdeeds[what] = misdeed()
    assert expected <= failing(subject)


@pytest.mark.parametrize("refusal", [UserError("Too short."), Unfinished("Go on.")])
def test_a_preview_may_refuse(subject, faulty, refusal):
    def preview(state, gesture, context):
        raise refusal

    faulty.misdeeds["preview"] = preview
    assert failing(subject) == set()


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("reports", "report"), ("nextstep", "next_step"), ("next_stpe", "next_step"),
        ("viewAdvice", "view_advice"), ("read_drawings", "read_drawing"), ("comands", "commands"),
        ("curvs", "curves"), ("whith_parts", "with_parts"), ("caution", "cautions"),
        ("hnit", "hint"), ("Gesture", "gesture"), ("taps", "tap"), ("tpa", "tap"),
        ("begn", "begin"),
    ],
)  # fmt: skip
def test_a_misspelt_ability_is_named(name, meant):
    assert meant_by(name, MODELER_NAMES | TOOL_NAMES) == meant


@pytest.mark.parametrize(
    "name", ["owner", "misdeeds", "recipe", "surface", "color", "measure", "map", "top", "drop"]
)
def test_other_names_are_left_alone(name):
    assert meant_by(name, MODELER_NAMES | TOOL_NAMES) == ""


def test_misspelt_abilities_are_found(subject, faulty, monkeypatch):
    monkeypatch.setattr(type(faulty), "view_advise", lambda self: None, raising=False)
    (spelling,) = (check for check in CHECKS if check.name == "spelling")
    with pytest.raises(Broken, match="'view_advise' looks like 'view_advice'"):
        spelling.run(subject)


def test_samples_are_tried(make_package, faulty):
    sampled = FAULTY_MANIFEST.replace('"panel", ', "") + 'samples = ["there_is_none.json"]\n'
    package = make_package(
        "from bozzetto.plugin import hookimpl\nimport sys\n@hookimpl\n"
        f"def bozzetto_modelers(): return sys.modules[{faulty.package!r}].given",
        sampled,
    )
    assert "samples" in failing(Subject("faulty.modeler", (package,)))


# -- the pen ----------------------------------------------------------------------------------


def test_pen_draws_in_time():
    stroke = Pen(speed=500.0, rate=100.0).along([(0, 0), (300, 0), (300, 400)])
    assert stroke.points[0].tolist() == [0, 0]
    assert stroke.points[-1].tolist() == [300, 400]
    assert stroke.t[-1] == pytest.approx(700 / 500)
    gaps = np.diff(stroke.t)
    assert gaps == pytest.approx(np.full(len(gaps), gaps[0]), rel=1e-3)
    assert gaps[0] <= 1 / 100 + 1e-6
    assert stroke.has_pressure
    assert stroke.has_time


def test_pen_circle_is_round_and_closed():
    stroke = Pen().circle(500, 400, 120)
    radius = np.hypot(*(stroke.points - (500, 400)).T)
    assert radius == pytest.approx(np.full(len(radius), 120.0), rel=1e-3)
    assert stroke.points[0] == pytest.approx(stroke.points[-1], abs=1e-3)


def test_tremor_has_the_size_asked_for_and_the_seed_decides():
    straight = [(0, 0), (20_000, 0)]
    shaking = Pen(tremor=3.0, seed=5)
    offset = shaking.along(straight).y
    assert np.std(offset) == pytest.approx(3.0, rel=0.15)
    assert np.std(np.diff(offset)) < 0.5 * np.std(offset)
    assert shaking.along(straight) == shaking.along(straight)
    assert shaking.along(straight) != shaking.but(seed=6).along(straight)


def test_pressure_is_spread_along_the_stroke():
    stroke = Pen(pressure=(0.0, 1.0, 0.5)).along([(0, 0), (600, 0)])
    assert stroke.pressure[[0, -1]].tolist() == [0.0, 0.5]
    assert stroke.pressure.max() == pytest.approx(1.0, abs=0.02)
    assert len(Pen().dot()) == 1


def test_pen_carries_camera_and_tool():
    camera = Camera("orthographic")
    stroke = Pen().but(camera=camera, tool="eraser").polygon((0, 0), (9, 0), (9, 9))
    assert stroke.camera is camera
    assert stroke.tool == "eraser"
    assert stroke.points[0].tolist() == stroke.points[-1].tolist()


# -- the shell --------------------------------------------------------------------------------


def test_shell_goes_through_a_whole_life(workshop):
    workshop.draw(Pen().circle())
    workshop.set(size=4.0)
    assert workshop.shapes().surfaces[0].mesh.vertices.max() == 4.0
    assert workshop.undo()
    assert workshop.state.size == 1.0
    assert workshop.redo()
    assert not workshop.redo()
    before = workshop.state
    assert list(workshop.reopen()) == []
    assert workshop.state is not before
    assert same(workshop.state, before)
    assert not workshop.undo()
    assert workshop.solve(Job(quality="preview")) == 4.0


# -- sameness ----------------------------------------------------------------------------------


def test_same_looks_into_everything():
    def shapes(x):
        return Shapes(surfaces=(Surface(Mesh([[x, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2]])),))

    assert same(shapes(1.0), shapes(1.0))
    assert not same(shapes(1.0), shapes(1.0000001192092896))
    assert same(Scene((Layer("a"),)), Scene((Layer("a"),)))
    assert not same(Scene((Layer("a"),)), Scene((Layer("b"),)))
    assert not same(1, 1.0)
    assert not same((1,), [1])
    assert not same(np.zeros(2), np.zeros(2, np.float32))
    assert not same(np.zeros(2), np.zeros((2, 1)))
    one, other = Stroke([1], [2], Camera()), Stroke([1], [3], Camera())
    assert same(Strokes([one]), Strokes([Stroke([1], [2], Camera())]))
    assert not same(Strokes([one]), Strokes([other]))
    assert not same({"a": one}, {"a": other})


def test_difference_names_the_place():
    @dataclass(frozen=True)
    class Part:
        size: float = 1.0
        table: tuple = (1, 2)

    assert difference((Part(),), (Part(),), "state") == ""
    told = difference((Part(np.float64(1.0)),), (Part(),), "state")
    assert told == "state[0].size: float64 became float"
    assert difference(Part(), Part(table=(1, 3)), "state") == "state.table[1] differs"
    assert difference(Part(), Part(table=(1,)), "state") == "state.table differs"


# -- states and choices that only this suite can try ---------------------------------------------

STATEFUL = """
import numpy as np
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal
from numpy.typing import NDArray
from bozzetto.errors import UserError
from bozzetto.geometry import Curve, Shapes, frozen
from bozzetto.plugin import Modeler, Parameter, Tool, hookimpl
from bozzetto.scene import Scene

@dataclass(frozen=True{options})
class State:
    places: NDArray[np.float64] = field(default_factory=lambda: frozen([], np.float64, 3))
    share: float = 0.0
    {field}

class Tap(Tool):
    id, title, icon, hint, gesture = "tap", "Tap", "", "Tap.", "tap"
    def tap(self, state, gesture, context):
        place = gesture.camera.on_plane([(gesture.x, gesture.y)], (0, 0, 0), (0, 1, 0))
        if not np.isfinite(place).all() or abs(place).max() > 1e5:
            raise UserError("Tap on the plane.")
        places = frozen(np.concatenate((state.places, place)), np.float64, 3)
        return replace(state, places=places{change})

class Stateful(Modeler):
    id, state_type = __name__ + ".modeler", State
    def tools(self):
        return (Tap(),)
    def solve(self, state, job):
        job.checkpoint(0.0, "start")
        {solve}
        return state.places
    def scene(self, state, result):
        return Scene()
    def shapes(self, state, result):
        if len(result) < 2:
            return Shapes()
        knots = np.clip(np.arange(-1, len(result) + 1), 0, len(result) - 1)
        return Shapes(curves=(Curve(1, knots, result),))

@hookimpl
def bozzetto_modelers():
    return [Stateful()]
"""

ROUND = 'form: Annotated[Literal["round", "flat"], Parameter("Form")] = "round"'
REFUSING = 'if state.form == "{}": raise UserError("This drawing has no such form.")'
STATES = {
    "all is well": ({}, set()),
    "arrays and ==": ({"options": ""}, {"storage"}),
    "numpy's number": ({"change": ", share=np.float64(0.5)"}, {"storage"}),
    "a choice refused": ({"field": ROUND, "solve": REFUSING.format("flat")}, set()),
    "the default refused": ({"field": ROUND, "solve": REFUSING.format("round")}, {"parameters"}),
}


def stateful(make_package, **changes):
    """A subject whose modeler takes taps, with pieces of its code changed."""
    code = STATEFUL
    given = {"options": ", eq=False", "field": "pass", "change": "", "solve": "pass"} | changes
    for key, text in given.items():
        code = code.replace("{" + key + "}", text)
    package = make_package(code)
    return Subject(f"{package}.modeler", (package,))


@pytest.mark.parametrize("name", STATES)
def test_the_suite_looks_into_states(make_package, name):
    changes, expected = STATES[name]
    subject = stateful(make_package, **changes)
    found = set()
    for check in CHECKS:
        if check.name != "elsewhere":
            try:
                check.run(subject)
            except (Broken, UserError):
                found.add(check.name)
    assert expected <= found
    assert expected or not found


def test_taps_are_a_plain_sketch(make_package):
    subject = stateful(make_package)
    with subject.drawn() as one, subject.drawn(1) as other:
        assert len(one.state.places) == 3
        assert not same(one.state.places, other.state.places)


DRAWN = """
    from dataclasses import dataclass, replace

    from bozzetto.geometry import Shapes
    from bozzetto.ink import Strokes, is_closed_gesture
    from bozzetto.plugin import Modeler, Tool, UserError, hookimpl
    from bozzetto.scene import Scene

    @dataclass(frozen=True)
    class State:
        strokes: Strokes = Strokes()

    class Draw(Tool):
        id = title = "draw"
        hint = "Draw."

        def draw(self, state, ink, context):
            open_ones = [not is_closed_gesture(stroke.points) for stroke in ink.strokes]
            if not all(open_ones) or len(open_ones) < {least}:
                raise UserError("Draw an axis, and a profile beside it.")
            return replace(state, strokes=state.strokes.extended(ink.strokes))

    class Made(Modeler):
        id, state_type = __name__ + ".modeler", State

        def tools(self):
            return (Draw(),)

        def solve(self, state, job):
            return None

        def scene(self, state, result):
            return Scene()

        def shapes(self, state, result):
            return Shapes()

    @hookimpl
    def bozzetto_modelers():
        return [Made()]
"""


@pytest.mark.parametrize("least", [1, 2, 3])
def test_what_refuses_a_circle_is_tried_with_open_lines(make_package, least):
    package = make_package(DRAWN.replace("{least}", str(least)))
    subject = Subject(f"{package}.modeler", (package,))
    if least == 3:
        with pytest.raises(UserError, match="an axis"), subject.drawn():
            pass
    else:
        with subject.drawn() as shell:
            assert len(shell.state.strokes) == least
