"""Bodies in the dimensions that are wanted, or that an edit was made in."""

from __future__ import annotations

from dataclasses import replace

from bozzetto.errors import UserError
from bozzetto.plugin import remembered
from bozzetto_car.body.body import REMEMBERED, Body
from bozzetto_car.body.dimension_map import Reshaping
from bozzetto_car.body.stretch import reshaping_of, stretch
from bozzetto_car.dimensions import Dimensions
from bozzetto_car.state import BodyEdit
from bozzetto_car.template.network import Network


def in_world_of(body: Body, edit: BodyEdit) -> Network:
    """Return the network of an unstretched body in the dimensions that an edit was made in.

    Raises
    ------
    UserError
        If the network cannot have these dimensions any more.
    """
    map_ = map_to(body.network, edit.dimensions)
    return body.network if map_ is None else stretch(body.network, map_)


def map_to(network: Network, wanted: Dimensions) -> Reshaping | None:
    """Return the map that gives a network dimensions; None if it has them, or none is wanted.

    Raises
    ------
    UserError
        If it cannot have them.
    """
    return _reshaping(network, wanted) if wanted.given() else None


@remembered(limit=REMEMBERED)
def _reshaping(network: Network, wanted: Dimensions) -> Reshaping | None:
    return reshaping_of(network, wanted)


@remembered(limit=REMEMBERED)
def brought_to(body: Body, wanted: Dimensions) -> Body:
    """Return the body with the dimensions that are wanted."""
    try:
        map_ = map_to(body.network, wanted)
    except UserError as problem:
        return replace(body, dimensions_problem=problem.message)
    if map_ is None:
        return body
    return replace(body, network=stretch(body.network, map_), world=wanted)
