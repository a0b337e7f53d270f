"""Every word a person reads passes through here, so that it can be translated."""

from __future__ import annotations

from PySide6.QtCore import QCoreApplication

__all__ = ["tr"]


def tr(context: str, text: str, **values: object) -> str:
    """Return the words in the person's language, with their placeholders filled in.

    Parameters
    ----------
    context : str
        The panel or dialog that speaks; translators see it beside the text.
    text : str
        English words with named places: ``"Saved {name}."``. Must be a literal, so that
        ``pyside6-lupdate -tr-function-alias translate+=tr`` finds it.
    **values : object
        What goes into the places. A value is inserted as it is, braces and all.
    """
    said = QCoreApplication.translate(context, text)
    return said.format(**values) if values else said
