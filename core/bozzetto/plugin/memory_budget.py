"""Budget of bytes for everything that is remembered in a process."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Iterable
from itertools import islice
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from bozzetto.plugin.memory_size import Size

MOST_BYTES: Final = 256 << 20
"""Bytes that all remembered answers of a process may take together: the program itself takes
about 400 MB, and on a machine of 4 GB it shall leave room for a browser. Dragging
the sliders of the bundled samples fills some 100 MB."""


OLDEST: Final = 64
"""Least recent entries of which the one goes first that makes most room."""


class Entry:
    """Something that is remembered.

    Parameters
    ----------
    size : Size
        What it takes.
    """

    __slots__ = ("dropped", "size")

    def __init__(self, size: Size) -> None:
        self.size = size
        self.dropped = False

    def forget(self) -> None:
        """Let go of it: there is no room for it. Called without the budget's lock."""
        raise NotImplementedError


class MemoryBudget:
    """Keeps entries while they fit, and lets go of those that were used least recently.

    Of the least recent ones, `OLDEST` of them, the one goes first that makes most room: where a
    drawing needs more than there is, its parts are asked for in turn, and by age alone each would
    be forgotten just before it is asked for again, down to figures of a few bytes that took long.
    A large object that several entries reach is counted once. All methods may be called from any
    thread.

    Parameters
    ----------
    most : int
        What all entries may take together, bytes.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._held = 0
        self._entries: OrderedDict[Entry, None] = OrderedDict()
        self._holders: dict[int, int] = {}
        self._lock = threading.Lock()

    @property
    def most(self) -> int:
        """Limit for all entries together, bytes."""
        return self._most

    @property
    def held(self) -> int:
        """Current size of all entries together, bytes."""
        return self._held

    def limit_to(self, most: int) -> None:
        """Set another bound, and forget what goes beyond it."""
        with self._lock:
            self._most = most
            gone = self._shrink()
        _forget_each(gone)

    def keep(self, entry: Entry) -> None:
        """Count an entry in as the newest one.

        What has to go to make room for it is forgotten; so is the entry itself if it alone is
        larger than the budget.
        """
        with self._lock:
            if entry.dropped:
                return
            if entry.size.total > self._most:
                entry.dropped = True
                gone = [entry]
            else:
                self._count_in(entry)
                gone = self._shrink()
        _forget_each(gone)

    def use(self, entry: Entry) -> None:
        """Make an entry the newest one, if it is still kept."""
        with self._lock:
            if entry in self._entries:
                self._entries.move_to_end(entry)

    def drop(self, entries: Iterable[Entry]) -> None:
        """Count entries out; whoever asks for this has forgotten them already."""
        with self._lock:
            for entry in entries:
                entry.dropped = True
                if entry in self._entries:
                    self._count_out(entry)

    def forget_all(self) -> None:
        """Forget every entry."""
        with self._lock:
            gone = list(self._entries)
            for entry in gone:
                self._count_out(entry)
        _forget_each(gone)

    def resize(self, entry: Entry, size: Size) -> None:
        """Count an entry again whose value has changed."""
        with self._lock:
            if entry not in self._entries:
                return
            if size.total > self._most:
                self._count_out(entry)
                gone = [entry]
            else:
                self._held += self._more(size) - self._less(entry.size)
                entry.size = size
                gone = self._shrink()
        _forget_each(gone)

    def _shrink(self) -> list[Entry]:
        gone = []
        while self._held > self._most and self._entries:
            largest = max(islice(self._entries, OLDEST), key=self._alone)
            self._count_out(largest)
            gone.append(largest)
        return gone

    def _alone(self, entry: Entry) -> int:
        """Return the bytes that nothing holds but an entry."""
        large = sum(count for thing, count in entry.size.large if self._holders[id(thing)] == 1)
        return entry.size.small + large

    def _count_in(self, entry: Entry) -> None:
        self._entries[entry] = None
        self._held += self._more(entry.size)

    def _count_out(self, entry: Entry) -> None:
        del self._entries[entry]
        entry.dropped = True
        self._held -= self._less(entry.size)

    def _more(self, size: Size) -> int:
        """Count a size in and return the bytes that nothing held before.

        A size keeps its objects alive, and so their ids.
        """
        more = size.small
        for thing, count in size.large:
            holders = self._holders.get(id(thing), 0)
            self._holders[id(thing)] = holders + 1
            more += 0 if holders else count
        return more

    def _less(self, size: Size) -> int:
        """Count a size out and return the bytes that nothing holds any more."""
        less = size.small
        for thing, count in size.large:
            holders = self._holders.pop(id(thing)) - 1
            if holders:
                self._holders[id(thing)] = holders
            else:
                less += count
        return less


def _forget_each(gone: Iterable[Entry]) -> None:
    """Forget entries, outside the budget's lock: their owners take locks of their own."""
    for entry in gone:
        entry.forget()
