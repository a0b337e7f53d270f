"""Memory that objects take, measured by a walk through their references."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from gc import get_referents, is_tracked
from sys import getsizeof
from types import BuiltinFunctionType, CodeType, FrameType, FunctionType, ModuleType
from typing import Final

import numpy as np

MOST_OBJECTS: Final = 150
"""Objects that are looked at: about 0.1 ms, for a drag may bring fifty answers a frame. What lies
behind them is estimated."""

LARGE: Final = 4096
"""Bytes from which on an object is listed by itself: it may be part of other answers, too."""

NOT_CONTENT: Final = (
    type, ModuleType, FunctionType, BuiltinFunctionType, CodeType, FrameType,
)  # fmt: skip
"""Kinds of objects that belong to the program and not to an answer."""

ATOMS: Final = frozenset({int, float, complex, bool, type(None)})
"""Kinds that refer to nothing and are mostly shared: only the rows that hold them are counted."""

ROWS: Final = frozenset({tuple, dict})
"""Kinds that the garbage collector leaves out where they hold no more than atoms and texts."""


@dataclass(frozen=True, eq=False)
class Size:
    """Memory that an object takes.

    Attributes
    ----------
    large : tuple of (object, int)
        Every large object that is reached, once, with the bytes that it takes itself.
    small : int
        Bytes that all other objects take together.
    """

    large: tuple[tuple[object, int], ...]
    small: int

    @property
    def total(self) -> int:
        """Total size, bytes."""
        return self.small + sum(count for _, count in self.large)


def size_of(*things: object) -> Size:
    """Measure objects with everything that they refer to.

    Notes
    -----
    The nearest objects are looked at first. A view of an array counts as the array that owns
    the data. What a native library holds for an object is counted if the object's class says it
    in ``__sizeof__``.
    """
    ahead = deque(things)
    seen: dict[int, object] = {}
    large: list[tuple[object, int]] = []
    small = 0
    while ahead and len(seen) < MOST_OBJECTS:
        thing = ahead.popleft()
        if id(thing) in seen:
            continue
        seen[id(thing)] = thing
        if isinstance(thing, np.ndarray):
            if isinstance(thing.base, np.ndarray):
                ahead.appendleft(thing.base)
                continue
            own = thing.nbytes
        elif isinstance(thing, NOT_CONTENT):
            continue
        else:
            own = getsizeof(thing)
        if own >= LARGE:
            large.append((thing, own))
        else:
            small += own
        if is_tracked(thing) or type(thing) in ROWS:
            for one in get_referents(thing):
                if type(one) not in ATOMS and id(one) not in seen:
                    ahead.append(one)
    if ahead and seen:
        small += small * len(ahead) // len(seen)
    return Size(tuple(large), small)
