"""A long immutable sequence that is cheap to change: snapshots share what stayed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Final, Self, TypeVar, overload

Item = TypeVar("Item")


class Chunked(Sequence[Item]):
    """An immutable sequence kept as a tuple of tuples of at most `CHUNK` items.

    A new snapshot with one item changed shares all but one chunk with the old one: the
    step costs a kilobyte, not one pointer for every item there is.

    Parameters
    ----------
    items : iterable
    """

    CHUNK: Final = 64

    __slots__ = ("_length", "chunks")

    chunks: tuple[tuple[Item, ...], ...]
    _length: int

    def __init__(self, items: Iterable[Item] = ()) -> None:
        given = tuple(items)
        size = self.CHUNK
        chunks = tuple(given[i : i + size] for i in range(0, len(given), size))
        object.__setattr__(self, "chunks", chunks)
        object.__setattr__(self, "_length", len(given))

    @classmethod
    def _of(cls, chunks: tuple[tuple[Item, ...], ...]) -> Self:
        made = cls.__new__(cls)
        object.__setattr__(made, "chunks", chunks)
        object.__setattr__(made, "_length", sum(map(len, chunks)))
        return made

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{type(self).__name__} are read-only: {name}")

    def __len__(self) -> int:
        return self._length

    def __iter__(self) -> Iterator[Item]:
        for chunk in self.chunks:
            yield from chunk

    @overload
    def __getitem__(self, index: int) -> Item: ...
    @overload
    def __getitem__(self, index: slice) -> Self: ...
    def __getitem__(self, index: int | slice) -> Item | Self:
        if isinstance(index, slice):
            return type(self)(tuple(self)[index])
        place, within = self._locate(index)
        return self.chunks[place][within]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, type(self)):
            return NotImplemented
        if self.chunks is other.chunks:
            return True
        return len(self) == len(other) and all(
            a is b or a == b for a, b in zip(self, other, strict=True)
        )

    def __hash__(self) -> int:
        return hash(tuple(self))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({len(self)})"

    def _locate(self, index: int) -> tuple[int, int]:
        """Return the chunk and the place within it; raise IndexError for none."""
        within = range(self._length)[index]
        for place, chunk in enumerate(self.chunks):
            if within < len(chunk):
                return place, within
            within -= len(chunk)
        raise IndexError(index)

    def _with_chunk(self, place: int, *chunks: tuple[Item, ...]) -> Self:
        return self._of((*self.chunks[:place], *chunks, *self.chunks[place + 1 :]))

    def extended(self, items: Iterable[Item]) -> Self:
        """Return a new sequence with further items at the end."""
        chunks = self.chunks
        for item in items:
            if chunks and len(chunks[-1]) < self.CHUNK:
                chunks = (*chunks[:-1], (*chunks[-1], item))
            else:
                chunks = (*chunks, (item,))
        return self._of(chunks)

    def inserted(self, index: int, item: Item) -> Self:
        """Return a new sequence with an item put in before a position."""
        if index == self._length:
            return self.extended((item,))
        place, within = self._locate(index)
        chunk = self.chunks[place]
        grown = (*chunk[:within], item, *chunk[within:])
        if len(grown) <= self.CHUNK:
            return self._with_chunk(place, grown)
        half = len(grown) // 2
        return self._with_chunk(place, grown[:half], grown[half:])

    def without(self, index: int) -> Self:
        """Return a new sequence without the item at a position."""
        place, within = self._locate(index)
        chunk = self.chunks[place]
        rest = chunk[:within] + chunk[within + 1 :]
        return self._with_chunk(place, rest) if rest else self._with_chunk(place)

    def replaced(self, index: int, item: Item) -> Self:
        """Return a new sequence with the item at a position exchanged."""
        place, within = self._locate(index)
        chunk = self.chunks[place]
        return self._with_chunk(place, (*chunk[:within], item, *chunk[within + 1 :]))
