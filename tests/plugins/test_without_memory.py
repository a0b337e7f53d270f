"""What the modelers remember changes no answer: with a budget of nothing they say the same."""

from __future__ import annotations

import pytest

from bozzetto.plugin.cache import ALL, MOST_BYTES, forget_all
from bozzetto.testing.questions import answers, questions
from bozzetto.testing.subject import Subject
from bozzetto.workbench.workbench import Workbench

MODELERS = ("bozzetto.silhouette", "bozzetto.symmetry", "bozzetto.car")


@pytest.fixture
def no_room():
    """Calls that leave no room for what is remembered, and give it back."""
    yield lambda: ALL.limit_to(0)
    ALL.limit_to(MOST_BYTES)


@pytest.mark.slow
@pytest.mark.parametrize("modeler", MODELERS)
def test_answers_without_memory_are_those_with_it(modeler, no_room):
    with Subject(modeler).drawn() as shell:
        forget_all()
        bench = Workbench(shell.registry)
        with_memory = answers(bench, questions(bench, shell.model))
        assert ALL.held > 0
        no_room()
        bench = Workbench(shell.registry)
        without = answers(bench, questions(bench, shell.model))
    assert ALL.held == 0
    assert without == with_memory
    assert len(without) > 3
