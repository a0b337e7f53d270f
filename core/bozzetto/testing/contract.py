"""The contract suite: derive a test class from it and name the modeler."""

from __future__ import annotations

from typing import ClassVar

import pytest
from _pytest.mark.structures import ParameterSet

from bozzetto.testing.checks import CHECKS, Check
from bozzetto.testing.headless_shell import Shell
from bozzetto.testing.subject import Subject, plain_sketch
from bozzetto.testing.synthetic_pen import Pen


def _marked(check: Check) -> ParameterSet:
    marks = [pytest.mark.slow] if check.is_slow else []
    return pytest.param(check, id=check.name, marks=marks)


class ModelerContract:
    """Everything that the program asks of a modeler, as tests.

    Attributes
    ----------
    modeler : str
        Id of the modeler under test.
    packages : tuple of str
        Import names of packages that are importable but not installed with an entry
        point, such as one under development.

    Examples
    --------
    >>> class TestRibbon(ModelerContract):
    ...     modeler = "author.ribbon"
    """

    modeler: ClassVar[str]
    packages: ClassVar[tuple[str, ...]] = ()

    def sketch(self, shell: Shell, pen: Pen) -> None:
        """Draw something that has a solution; override it where a circle is not enough.

        Draw with the given `pen`, so that pens of different seeds give different states.
        """
        plain_sketch(shell, pen)

    @property
    def subject(self) -> Subject:
        """Modeler on which the checks run."""
        return Subject(self.modeler, self.packages, self.sketch)

    @pytest.mark.parametrize("check", [_marked(check) for check in CHECKS])
    def test_contract(self, check: Check) -> None:
        """Check one article of the contract; its docstring in `checks` says what it asks."""
        check.run(self.subject)
