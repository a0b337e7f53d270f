"""States exchanged together with the links that they make, and what is to be said of links."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bozzetto.document.model import Model, OpaqueState

if TYPE_CHECKING:
    from bozzetto.plugin.cautions import Caution
    from bozzetto.plugin.host.registry import Registry


def with_state(registry: Registry, model: Model, state: Any) -> Model:
    """Return a model with another state, and with the sources that its modeler says it has.

    Raises
    ------
    PluginFault
        If the modeler fails over it.
    """
    return model.with_state(state, registry.guarded(model.modeler).sources(state))


def with_sources(registry: Registry, model: Model, sources: tuple[str, ...]) -> Model:
    """Return a model with other sources, as many and in the same order.

    One whose plugin is not here stays as it is: it follows what it followed.
    """
    if isinstance(model.state, OpaqueState):
        return model
    return with_state(
        registry, model, registry.guarded(model.modeler).with_sources(model.state, sources)
    )


def frozen_cautions(model: Model) -> tuple[Caution, ...]:
    """Return what a person must know of a model whose sources are frozen."""
    if not model.frozen:
        return ()
    from bozzetto.plugin.cautions import Caution

    names = " and ".join(f"“{source.name}”" for source in model.frozen)
    were = "it was" if len(model.frozen) == 1 else "they were"
    return (Caution(f"“{model.name}” keeps {names} as {were} when it stopped following."),)
