"""Which of the contract's methods a plugin writes itself."""

from __future__ import annotations


def overrides(thing: object, name: str) -> bool:
    """Whether a modeler or a tool, or its class, writes a member of the contract itself.

    Parameters
    ----------
    thing : object or type
        What is derived from a class of the contract.
    name : str
        Name of the member.
    """
    kind = thing if isinstance(thing, type) else type(thing)
    if kind is not thing and name in getattr(thing, "__dict__", ()):
        return True
    owner = next((part for part in kind.__mro__ if name in vars(part)), None)
    return owner is not None and owner.__module__.partition(".")[0] != "bozzetto"
