"""A property that is kept, and for which no thread waits."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from pathlib import Path
from threading import Event, Thread

import pytest

import bozzetto
from bozzetto.cached_properties import cached_property

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Slow:
    may_end: Event
    begun: Event

    @cached_property
    def value(self) -> object:
        """A value."""
        self.begun.set()
        assert self.may_end.wait(20.0)
        return object()


def test_a_slow_property_of_one_object_keeps_no_reader_of_another_waiting():
    slow, quick = Slow(Event(), Event()), Slow(Event(), Event())
    quick.may_end.set()
    worker = Thread(target=lambda: slow.value)
    worker.start()
    assert slow.begun.wait(20.0)
    read = Thread(target=lambda: quick.value)
    read.start()
    read.join(10.0)
    waits = read.is_alive()
    slow.may_end.set()
    worker.join(20.0)
    assert not waits


def test_the_value_is_kept_and_the_same_for_all():
    one = Slow(Event(), Event())
    found = []
    readers = [Thread(target=lambda: found.append(one.value)) for _ in range(4)]
    for reader in readers:
        reader.start()
    one.may_end.set()
    for reader in readers:
        reader.join(20.0)
    assert len(set(map(id, found))) == 1
    assert one.value is found[0]
    assert one.__dict__["value"] is found[0]


def test_of_the_class_it_is_the_property_with_its_words():
    assert Slow.value.__doc__ == "A value."
    with pytest.raises(AttributeError):
        _ = Slow(Event(), Event()).other


def test_nobody_takes_the_one_with_a_lock():
    folders = [Path(bozzetto.__file__).parent, ROOT / "app", ROOT / "plugins"]
    found = [
        path.name
        for folder in folders
        for path in sorted(folder.rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and node.module == "functools"
        if "cached_property" in {name.name for name in node.names}
    ]
    assert set(found) <= {"cached_properties.py"}
