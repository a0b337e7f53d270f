"""One line of the table of reliability."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Row"]


@dataclass(frozen=True)
class Row:
    """A measured figure beside what was promised.

    Parameters
    ----------
    what : str
        What was done, how often.
    figure : str
        What was measured, with its unit.
    promise : str
        The bound that was to be held, empty where the figure is only told.
    kept : bool
        Whether it was held.
    """

    what: str
    figure: str
    promise: str = ""
    kept: bool = True

    def cells(self) -> tuple[str, ...]:
        """Return the cells of the table."""
        return self.what, self.figure, self.promise, "yes" if self.kept else "**no**"
