"""Next step: what a person can do now, said once for every place that shows it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class NextStep:
    """Next step that a person can take with a model.

    The status line, the words over the sheet, the plugin's panel and the tool rail show this one
    answer, so they cannot disagree.

    Parameters
    ----------
    sentence : str
        The next gesture and where to look, in plain words.
    place : (x, y, z), optional
        Where on the sheet, mm, in the model's own frame; it is marked there.
    tool : str
        Id of the tool that it takes, where that is another one than the one in the hand; the
        tool rail points at it. "" where the tool stays.
    panel : bool
        Whether it is done in the plugin's own panel, which is then shown.
    on_picture : bool
        Whether the place lies on a picture that the view has to look through; it is marked only
        while the view is pinned there (`ViewAdvice.pinned`), for elsewhere it means nothing.
    """

    sentence: str
    place: tuple[float, float, float] | None = None
    tool: str = ""
    panel: bool = False
    on_picture: bool = False
