"""Request for work that may be slow: its quality, its progress, and whether anybody still waits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

from bozzetto.errors import Cancelled

if TYPE_CHECKING:
    from bozzetto.geometry.shapes import Shapes


def _nobody(fraction: float, step: str) -> None:
    """Ignore progress that no one watches."""


def _never() -> bool:
    return False


@dataclass(frozen=True)
class Job:
    """Request for work that may be slow, and whether anybody still waits for it.

    It comes with a solve, a report, a drawing that is read and advice on a view.

    Parameters
    ----------
    quality : {"preview", "final"}
        Of a solve. "preview" must be fast (tens of milliseconds) and may be coarse.
    progress : callable
        Called with the fraction done (0 … 1) and the step's name.
    cancelled : callable
        True once the answer is no longer wanted.
    sources : mapping of str to Shapes
        What the models hand over that `Modeler.sources` names, by their ids; mm, in the frame of
        the model that is solved. For a preview they may be previews as well. Empty where nothing
        is solved.
    drawn_on : bool
        Whether gestures are to land on this preview, as those of an ink file do: it may be coarse,
        but nothing may be left out of it only because a hand moves.
    """

    quality: Literal["preview", "final"] = "final"
    progress: Callable[[float, str], None] = _nobody
    cancelled: Callable[[], bool] = _never
    sources: Mapping[str, Shapes] = field(default_factory=dict)
    drawn_on: bool = False

    def checkpoint(self, fraction: float, step: str) -> None:
        """Report progress; call it between steps, and in loops.

        Raises
        ------
        Cancelled
            If the answer is no longer wanted. Let it pass.
        """
        if self.cancelled():
            raise Cancelled(step)
        self.progress(fraction, step)
