"""`cached_property` that makes no thread wait for another.

Until Python 3.12 `functools.cached_property` has one lock for all objects of a class: while a
worker computes a slow property of one object, the window waits to read that of another. From 3.12
on it has none, and two threads that ask at once may get, and keep, two different values.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

__all__ = ["cached_property"]

if TYPE_CHECKING:
    from functools import cached_property as cached_property
else:

    class cached_property:
        """A property that is computed once and then kept in the object's ``__dict__``.

        Two threads that ask for it at once may both compute it; both get the first that was kept.
        """

        def __init__(self, func: Any) -> None:
            self.func = func
            self.__doc__ = func.__doc__

        def __set_name__(self, owner: type, name: str) -> None:
            self.attrname = name

        def __get__(self, instance: Any, owner: type | None = None) -> Any:
            if instance is None:
                return self
            return instance.__dict__.setdefault(self.attrname, self.func(instance))
