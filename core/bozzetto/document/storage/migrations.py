"""Documents of earlier versions: one pure function from each version to the next.

A step gets the JSON trees of the core (``manifest.json`` and ``core/*.json``) by name and
returns them in the next version's shape. The states of modelers are not touched: these
have versions of their own (`StateTypes.upgrade`). For every version that was ever
released, ``tests/data/documents`` keeps one file that must open for ever.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final

Trees = dict[str, Any]
Step = Callable[[Trees], Trees]

WAITING: Final = "core/waiting.json"
"""Entry of version 2 that lists the waiting ink."""


FROZEN: Final = "core/frozen.json"
"""Entry of version 3 that lists the models that are frozen in others."""


def _no_ink_waited(trees: Trees) -> Trees:
    """Migrate version 1 to 2: waiting ink is part of the document; before, it was never kept."""
    return {**trees, WAITING: []}


def _no_links(trees: Trees) -> Trees:
    """Migrate version 2 to 3: models may be made from others; before, none was."""
    return {**trees, FROZEN: []}


STEPS: Final[tuple[Step, ...]] = (_no_ink_waited, _no_links)
"""The n-th step leads from version n to n + 1."""

VERSION: Final = len(STEPS) + 1
"""The version that this program writes."""


def migrate(trees: Trees, version: int, steps: Sequence[Step] = STEPS) -> Trees:
    """Bring the JSON trees of a version up to date.

    Parameters
    ----------
    trees : dict
        JSON values by the name of their entry.
    version : int
        What they are now; from 1.
    steps : sequence of callable
        The migration from each version to the next one, from version 1 on.
    """
    for step in steps[version - 1 :]:
        trees = step(trees)
    return trees
