"""Parts of models through the guard: edits with their labels, faults with their plugin."""

from __future__ import annotations

import gc
import importlib
import weakref
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.geometry import Shapes, frozen
from bozzetto.plugin import Group, Parameter, Part, PartsModeler, PartsState
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.plugin.host.registry import Registry
from bozzetto.scene import Scene
from bozzetto.testing import Shell

CODE = """
from bozzetto.plugin import hookimpl
given = []

@hookimpl
def bozzetto_modelers():
    return given
"""

MANIFEST = """
id = "pieces.plugin"
title = "Pieces"
version = "1.0"
api = ">=2,<3"

[[modeler]]
id = "pieces.modeler"
title = "Pieces"
icon = "icon.svg"
hint = "Draw."
"""


@dataclass(frozen=True)
class Piece(Part):
    size: Annotated[float, Parameter("Size", 0.0, 9.0)] = 1.0


@dataclass(frozen=True)
class Frame(Piece, Group):
    """A group; it has a size of its own and a rim besides."""

    rim: Annotated[float, Parameter("Rim", 0.0, 1.0)] = 0.5


@dataclass(frozen=True)
class PiecesState(PartsState):
    nodes: tuple[Piece | Frame, ...] = ()
    detail: Annotated[int, Parameter("Detail", 1, 5)] = 2


class Pieces(PartsModeler[PiecesState, None]):
    id, state_type = "pieces.modeler", PiecesState
    part_types = (Piece, Frame)

    def create(self, context):
        nodes = (Piece("a", "A"), Frame("b", "B"), Piece("c", "C", within="b"), Piece("d", "D"))
        return PiecesState(nodes, "a")

    def solve(self, state, job):
        return None

    def scene(self, state, result):
        return Scene()

    def shapes(self, state, result):
        return Shapes()


@pytest.fixture
def pieces(make_package):
    package = make_package(CODE, MANIFEST)
    modeler = Pieces()
    importlib.import_module(package).given.append(modeler)
    modeler.package = package
    return modeler


@pytest.fixture
def shell(pieces, tmp_path):
    made = Shell(Registry(extra=[pieces.package]), tmp_path)
    made.open("pieces.modeler")
    return made


def test_every_edit_gives_another_model_and_says_what_was_done(shell):
    edits, model = shell.workbench.parts, shell.model
    done = {
        "rename": edits.rename(model, "a", "Head"),
        "show": edits.show(model, "a", False),
        "delete": edits.delete(model, "b"),
        "duplicate": edits.duplicate(model, "b"),
        "move": edits.move(model, "a", "b", 0),
        "group": edits.group(model, ["a", "d"]),
        "ungroup": edits.ungroup(model, "b"),
        "several": edits.delete(model, "a", "d"),
        "set": edits.set(model, "a", {"size": 3.0}),
    }
    assert {name: edit.label for name, edit in done.items()} == {
        "rename": "Rename to “Head”",
        "show": "Hide “A”",
        "delete": "Delete “B”",
        "duplicate": "Duplicate “B”",
        "move": "Reorder “A”",
        "group": "Group 2 parts",
        "ungroup": "Ungroup “B”",
        "several": "Delete 2 parts",
        "set": "Change “A”",
    }
    assert model.state == Pieces().create(None)
    assert len({edit.model.state for edit in done.values()}) == len(done)
    assert [p.id for p in edits.of(done["delete"].model).parts] == ["a", "d"]
    group = edits.of(done["group"].model)
    assert group.part(group.selected) == Frame("n1", "Group 1")
    assert edits.select(model, "c").state == replace(model.state, selected="c")


def test_a_locked_model_refuses_all_but_the_choice(shell):
    edits, model = shell.workbench.parts, replace(shell.model, locked=True)
    for act in (
        lambda: edits.rename(model, "a", "Head"),
        lambda: edits.show(model, "a", False),
        lambda: edits.delete(model, "b"),
        lambda: edits.duplicate(model, "b"),
        lambda: edits.move(model, "a", "b", 0),
        lambda: edits.group(model, ["a"]),
        lambda: edits.set(model, "a", {"size": 3.0}),
    ):
        with pytest.raises(UserError, match="locked"):
            act()
    assert edits.of(edits.select(model, "d")).selected == "d"


@pytest.mark.parametrize(
    ("chosen", "values", "sizes"),
    [
        ("a", {"size": 2.0}, {"a": 2.0}),
        ("", {"size": 2.0}, {"a": 2.0, "b": 2.0, "c": 2.0, "d": 2.0}),
        ("a", {"C.size": 2.0, "D.size": 3}, {"c": 2.0, "d": 3.0}),
        ("a", {"detail": 4, "b.size": 5.0}, {"b": 5.0}),
        ("a", {"rim": 1.0}, {}),
    ],
)
def test_parameters_reach_the_part_that_is_meant(shell, chosen, values, sizes):
    model = shell.workbench.parts.select(shell.model, chosen)
    state = shell.workbench.set_parameters(model, values).state
    assert {p.id: p.size for p in state.nodes if p.size != 1.0} == sizes
    assert state.detail == values.get("detail", 2)
    assert state.nodes[1].rim == values.get("rim", 0.5)
    assert state.selected == chosen


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"girth": 1.0}, "detail, rim, size"),
        ({"X.size": 1.0}, "there are: A, B, C, D"),
        ({"A.rim": 1.0}, "“A” has: size"),
        ({"size": 10.0}, "from 0 to 9"),
    ],
)
def test_parameters_that_nobody_has_are_told_apart(shell, values, words):
    with pytest.raises(UserError, match=words):
        shell.workbench.set_parameters(shell.model, values)


def test_only_the_choice_differs(shell):
    edits, model = shell.workbench.parts, shell.model
    other = edits.select(model, "d")
    assert edits.only_choice_differs(model, other)
    assert edits.only_choice_differs(model, edits.select(model, ""))
    assert edits.only_choice_differs(model, model)
    assert not edits.only_choice_differs(model, edits.rename(other, "d", "Q").model)
    assert not edits.only_choice_differs(model, edits.duplicate(model, "a").model)


TWINS = (Piece("a", "A"), Piece("a", "B"))
CIRCLE = (Frame("a", "A", within="b"), Frame("b", "B", within="a"))


@pytest.mark.parametrize(
    "wrong",
    [
        {"nodes": list(TWINS)},
        {"nodes": TWINS},
        {"nodes": CIRCLE},
        {"nodes": (Piece("a", "A", within="d"), Piece("d", "D"))},
        {"nodes": (Piece("a", "A", within="nowhere"),)},
        {"nodes": (Piece("", "A"),)},
        {"nodes": (Piece("a", "A", visible="yes"),)},
        {"nodes": (3,)},
        {"selected": "nobody"},
        {"selected": None},
    ],
)
def test_parts_that_cannot_be_listed_are_the_fault_of_their_plugin(shell, wrong):
    model = replace(shell.model, state=replace(shell.state, **wrong))
    with pytest.raises(PluginFault, match=r"pieces\.plugin"):
        shell.workbench.parts.of(model)


@pytest.mark.parametrize(
    "misdeed",
    [
        lambda state, nodes, selected: None,
        lambda state, nodes, selected: replace(state, nodes=TWINS),
        lambda state, nodes, selected: 1 / 0,
    ],
)
def test_parts_that_are_put_back_wrongly_are_the_fault_of_their_plugin(shell, pieces, misdeed):
    pieces.with_parts = misdeed
    with pytest.raises(PluginFault, match=r"pieces\.plugin"):
        shell.workbench.parts.rename(shell.model, "a", "Head")


@pytest.mark.parametrize(
    ("name", "edit"),
    [
        ("new_group", lambda edits, model: edits.group(model, ["a"])),
        ("released", lambda edits, model: edits.ungroup(model, "b")),
    ],
)
def test_groups_that_fail_are_the_fault_of_their_plugin(shell, pieces, name, edit):
    setattr(pieces, name, lambda *arguments: 1 / 0)
    with pytest.raises(PluginFault, match=r"pieces\.plugin"):
        edit(shell.workbench.parts, shell.model)


def test_what_a_modeler_refuses_is_told_in_its_words(shell, pieces):
    def refuse(state, parts, selected):
        raise UserError("A frame needs something in it.")

    pieces.with_parts = refuse
    with pytest.raises(UserError, match="needs something"):
        shell.workbench.parts.delete(shell.model, "c")
    pieces.new_group = lambda state: None
    with pytest.raises(UserError, match="cannot be grouped"):
        shell.workbench.parts.group(shell.model, ["a"])


def test_models_without_parts_have_none(workshop):
    assert workshop.workbench.parts.of(workshop.model) is None
    with pytest.raises(UserError, match="not made of parts"):
        workshop.workbench.parts.delete(workshop.model, "a")


def test_parts_are_read_once_and_forgotten_with_their_state(shell):
    edits = shell.workbench.parts
    others = [edits.select(shell.model, name) for name in ("b", "c", "d")]
    for model in others:
        assert edits.of(model) is edits.of(model) is edits.remembered(model)
    trees = [weakref.ref(edits.of(model)) for model in others]
    del others, model
    gc.collect()
    assert [tree() for tree in trees] == [None] * 3


@dataclass(frozen=True, eq=False)
class Cloud(Part):
    """As the guide asks for where there is an array."""

    points: NDArray[np.float64] = field(default_factory=lambda: frozen([], np.float64, 3))


@dataclass(frozen=True)
class Clouds(PartsState):
    """A state of such parts."""

    nodes: tuple[Cloud, ...] = ()


def test_a_part_that_holds_an_array_is_not_the_one_with_another_array():
    cloud = Cloud("a", "A", points=frozen([[0.0, 0.0, 0.0]], np.float64, 3))
    moved = replace(cloud, points=frozen([[0.0, 0.0, 1.0]], np.float64, 3))
    assert cloud != moved
    assert Clouds((cloud,)) != Clouds((moved,))
    assert Clouds((cloud,)) == Clouds((cloud,))
    assert len({cloud: 1, moved: 2}) == 2
