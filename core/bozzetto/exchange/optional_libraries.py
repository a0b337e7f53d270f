"""Libraries that only some people need, each an extra of the package."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from bozzetto.errors import UserError


def library(name: str, extra: str) -> Any:
    """Import a library that comes with an extra.

    Parameters
    ----------
    name : str
        Name of the module.
    extra : str
        Extra of the package, as in ``bozzetto[extra]``.

    Raises
    ------
    UserError
        If it is not installed; the message says what to do.
    """
    try:
        return import_module(name)
    except ImportError:
        package = name.partition(".")[0]
        raise UserError(
            f"This format needs the library {package}, which is not installed. "
            f"Install it into Bozzetto's Python with: pip install 'bozzetto[{extra}]'"
        ) from None
