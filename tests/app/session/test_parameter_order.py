"""Forms show what people reach for first, and everything else in its own order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import pytest

from bozzetto.parameters import Parameter, set_parameters
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.parts import PartsModeler
from bozzetto_app.session.object_edits import fields_of


@pytest.mark.parametrize("modeler_id", ["silhouette", "symmetry", "car"])
def test_first_parameters_come_first_and_nothing_is_lost(modeler_id) -> None:
    registry = Registry()
    modeler = registry.modeler(registry.resolve(modeler_id))
    assert isinstance(modeler, PartsModeler)
    first = modeler.first_parameters
    assert first
    for kind in (modeler.state_type, *modeler.part_types):
        usual = [field.name for field, _ in fields_of(kind())]
        names = [field.name for field, _ in fields_of(kind(), first)]
        ahead = [name for name in first if name in usual]
        assert names == ahead + [name for name in usual if name not in ahead]
        assert [value for _, value in fields_of(kind(), first)] == [
            getattr(kind(), name) for name in names
        ]


@dataclass(frozen=True)
class Chosen:
    answer: Annotated[int, Parameter("Answer", 1, 8, in_forms=False)] = 1
    wall: Annotated[float, Parameter("Wall", 0.0, 9.0)] = 0.0


def test_what_a_panel_says_better_is_not_in_forms_but_can_be_set():
    assert [field.name for field, _ in fields_of(Chosen())] == ["wall"]
    assert set_parameters(Chosen(), {"answer": 3}).answer == 3
