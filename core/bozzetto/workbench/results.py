"""Results of models, remembered by what they were made from."""

from __future__ import annotations

import itertools
import threading
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

import msgspec

from bozzetto.document.model import LONGEST_CHAIN, Model
from bozzetto.errors import UserError
from bozzetto.plugin.guard.guard import PluginFault

if TYPE_CHECKING:
    from bozzetto.geometry.placement import Placement
    from bozzetto.geometry.shapes import Shapes
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.workbench import Workbench

KEPT_RESULTS: Final = 64
"""Limit of solved results that are kept; they can always be made again."""

Quality = Literal["preview", "final"]

Used: TypeAlias = "tuple[tuple[str, Placement, int], ...]"
"""What a result was made from: ids of sources, where they lay, numbers of their results."""

Key: TypeAlias = "tuple[int, str, Used]"


class _Known(msgspec.Struct, frozen=True):
    """A result, or the problem that stands in its place; `number` is given once in a process."""

    state: Any
    number: int
    result: Any = None
    problem: UserError | PluginFault | None = None
    shapes: list[Shapes] = msgspec.field(default_factory=list)
    """Shapes that the modeler hands over of it, once that was asked for."""


class KnownResults:
    """Solves models with what they are made from, and remembers the results.

    A result is known by the identity of its state, and by those of the results that were used:
    if a source has the very same result, its followers have.

    Parameters
    ----------
    bench : Workbench
        Where modelers come from.
    """

    def __init__(self, bench: Workbench) -> None:
        self._bench = bench
        self._kept: OrderedDict[Key, _Known] = OrderedDict()
        self._given: OrderedDict[str, tuple[Used, Mapping[str, Shapes]]] = OrderedDict()
        self._numbers = itertools.count(1)
        self._lock = threading.Lock()

    def known(self, model: Model, quality: str) -> Any | None:
        """Return the remembered result of a recipe, or None; asks no plugin."""
        used = self._known_sources(model, quality)
        found = None if used is None else self._find((id(model.state), quality, used), model)
        return None if found is None else found.result

    def solve(self, model: Model, job: Job) -> Any:
        """Return the result of a recipe; see `Workbench.solve`."""
        return self._solved(model, job).result

    def forget(self) -> None:
        """Drop all results."""
        with self._lock:
            self._kept.clear()
            self._given.clear()

    # -- sources --

    def given_sources(self, model: Model) -> Mapping[str, Shapes]:
        """Return what a model was made from when it was solved last; asks no plugin."""
        with self._lock:
            _, given = self._given.get(model.id, ((), {}))
        return {name: given[name] for name in model.sources if name in given}

    def _known_sources(self, model: Model, quality: str) -> Used | None:
        """Return what a result would be made from, if all of that is known."""
        used = []
        for source in (*model.linked, *model.frozen):
            found = self._best(source, quality)
            if found is None:
                return None
            used.append((source.id, source.placement, found.number))
        return tuple(used)

    def _best(self, source: Model, quality: str) -> _Known | None:
        """Return the result that a follower would be given: a final one, or a known preview."""
        for wanted in ("final",) if quality == "final" else ("final", "preview"):
            used = self._known_sources(source, wanted)
            if used is not None:
                found = self._find((id(source.state), wanted, used), source)
                if found is not None and (found.problem is None or wanted == quality):
                    return found
        return None

    def _sources(self, model: Model, job: Job, depth: int) -> tuple[Used, Mapping[str, Shapes]]:
        """Solve what a model is made from, and return it in the model's own frame.

        Raises
        ------
        UserError
            If one of them is missing or has no shape.
        """
        if depth > LONGEST_CHAIN:
            raise UserError(f"“{model.name}” follows more than {LONGEST_CHAIN} objects in a row.")
        inside = {source.id: source for source in (*model.linked, *model.frozen)}
        if len(inside) < len(model.sources):
            raise UserError(
                f"“{model.name}” was made from an object that is not here, or that follows "
                f"“{model.name}” itself. Delete it, or undo what took the other one away."
            )
        known = []
        for source in inside.values():
            found = self._best(source, job.quality)
            if found is None:
                try:
                    found = self._solved(source, replace(job, sources={}), depth + 1)
                except (UserError, PluginFault) as problem:
                    raise _refusal(model, source, problem) from problem
            if found.problem is not None:
                raise _refusal(model, source, found.problem) from found.problem
            known.append((source, found))
        used = tuple((source.id, source.placement, found.number) for source, found in known)
        with self._lock:
            before, given = self._given.get(model.id, ((), {}))
        if before != used:  # else the very same shapes again: who remembers by them finds them
            shapes = {
                source.id: self._shapes(source, found).placed(source.placement)
                for source, found in known
            }
            given = {name: shapes[name] for name in model.sources}
        with self._lock:
            self._given[model.id] = (used, given)
            self._given.move_to_end(model.id)
            while len(self._given) > KEPT_RESULTS:
                self._given.popitem(last=False)
        return used, given

    def _shapes(self, source: Model, found: _Known) -> Shapes:
        if not found.shapes:
            modeler = self._bench.guarded(source)
            found.shapes.append(modeler.shapes(source.state, found.result))
        return found.shapes[0]

    # -- results --

    def _solved(self, model: Model, job: Job, depth: int = 0) -> _Known:
        """Return the entry of a result; a problem is remembered for followers, and raised."""
        used: Used = ()
        if model.sources:
            used, shapes = self._sources(model, job, depth)
            job = replace(job, sources=shapes)
        key = (id(model.state), job.quality, used)
        found = self._find(key, model)
        if found is None or found.problem is not None:
            number = next(self._numbers)
            try:
                result = self._bench.guarded(model).solve(model.state, job)
            except (UserError, PluginFault) as problem:
                self._keep(key, _Known(model.state, number, problem=problem))
                raise
            found = self._keep(key, _Known(model.state, number, result))
            is_learnt = False
        else:
            is_learnt = not model.sources  # else they may be those of another result
        if job.quality == "final" and not is_learnt:
            # A preview has some milliseconds, and its curves would be exchanged in a moment.
            self._bench.curves.try_to_learn(model, found.result)
        return found

    def _find(self, key: Key, model: Model) -> _Known | None:
        with self._lock:
            found = self._kept.get(key)
            if found is None or found.state is not model.state:
                return None
            self._kept.move_to_end(key)
            return found

    def _keep(self, key: Key, found: _Known) -> _Known:
        with self._lock:
            self._kept[key] = found
            while len(self._kept) > KEPT_RESULTS:
                self._kept.popitem(last=False)
        return found


def _refusal(model: Model, source: Model, problem: UserError | PluginFault) -> UserError:
    """Return why a follower has no shape."""
    if isinstance(problem, UserError):
        return UserError(f"“{model.name}” follows “{source.name}”. {problem.message}")
    return UserError(
        f"“{model.name}” follows “{source.name}”, and there the plugin {problem.plugin} failed. "
        f"Change “{source.name}”, or undo the last step."
    )
