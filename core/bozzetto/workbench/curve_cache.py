"""The curves of solved models, kept for tools that snap to them or start from them.

A tool may be asked sixty times a second, and solves of other models must not hold it up. So
curves are learnt where a model is solved anyway, and only looked up where a gesture is made.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

from bozzetto.errors import UserError
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.plugin.overrides import overrides
from bozzetto.workbench.placed import shapes_in_world

if TYPE_CHECKING:
    from bozzetto.document.model import Model
    from bozzetto.geometry.shapes import Curve, Shapes
    from bozzetto.plugin.host.registry import Registry

KEPT = 1000
"""States whose curves are kept; they can always be learnt again."""


class _Known(NamedTuple):
    """A state, what it offered in its own frame, and the same in the world.

    Parameters
    ----------
    state : object
        Kept, so that no other one is taken for it.
    own : Shapes
    placed : dict of str to (Model, tuple of Curve)
        By id, for copies share a state: each model as it was last asked for.
    """

    state: Any
    own: Shapes
    placed: dict[str, tuple[Model, tuple[Curve, ...]]]


class KnownCurves:
    """Curves that models offered when they were solved; usable from any thread.

    Parameters
    ----------
    registry : Registry
        Where modelers come from, and the guard.
    """

    def __init__(self, registry: Registry) -> None:
        self._registry = registry
        self._kept: OrderedDict[tuple[int, str], _Known] = OrderedDict()
        self._failed: set[str] = set()
        self._lock = threading.Lock()

    def are_offered(self, model: Model) -> bool:
        """Whether the modeler of a model may offer curves at all; asks no plugin."""
        return overrides(self._registry.modeler(model.modeler), "curves")

    def learn(self, model: Model, result: Any) -> None:
        """Remember the curves of a result.

        Raises
        ------
        PluginFault
            If the modeler fails over it; then nothing is remembered.
        """
        try:
            told = self._registry.guarded(model.modeler).curves(model.state, result)
        except UserError:
            told = ()
        from bozzetto.geometry.shapes import Shapes

        own = Shapes(curves=told)
        with self._lock:
            self._kept[_key(model)] = _Known(model.state, own, {})
            self._kept.move_to_end(_key(model))
            while len(self._kept) > KEPT:
                self._kept.popitem(last=False)

    def try_to_learn(self, model: Model, result: Any) -> None:
        """Learn the curves as `learn` does; a modeler that fails over it is not asked again.

        Its shape is none the worse for it.
        """
        if model.modeler not in self._failed:
            try:
                self.learn(model, result)
            except PluginFault:
                self._failed.add(model.modeler)

    def forget(self) -> None:
        """Forget all curves, and with them the models that they were learnt of."""
        with self._lock:
            self._kept.clear()

    def of(self, models: Iterable[Model]) -> tuple[Curve, ...]:
        """Return the curves of the visible models among some, in the world; asks no plugin."""
        found: list[Curve] = []
        for model in models:
            with self._lock:
                known = self._kept.get(_key(model))
                if known is None or known.state is not model.state or not model.visible:
                    continue
                if not known.own.curves:
                    continue
                before, curves = known.placed.get(model.id, (None, ()))
                if before is not model:  # renamed, moved or coloured since
                    curves = shapes_in_world(known.own, model).curves
                    known.placed[model.id] = (model, curves)
            found.extend(curves)
        return tuple(found)


def _key(model: Model) -> tuple[int, str]:
    """Return what curves are kept under: a follower's are its own, whoever shares its state."""
    return id(model.state), model.id if model.sources else ""
