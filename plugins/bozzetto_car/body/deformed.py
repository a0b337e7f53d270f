"""The body right after its nodes have moved, before any edit."""

from __future__ import annotations

from bozzetto.plugin import remembered
from bozzetto_car.body.body import REMEMBERED, Body
from bozzetto_car.body.chain_smoothing import lock_ratios, smooth_chains
from bozzetto_car.body.default_shape import pull_out_panels
from bozzetto_car.body.edges_on_mesh import network_on_mesh
from bozzetto_car.body.fair_lines import fair_network, with_creases_of_one_side
from bozzetto_car.body.turned_lines import with_fewer_saddles
from bozzetto_car.solver.pipeline import Solved
from bozzetto_car.state import CarState
from bozzetto_car.template.line_joints import with_joints
from bozzetto_car.template.network import Network


@remembered(
    limit=REMEMBERED,
    key=lambda base, state: (
        (base, state.default_shape, state.annealed, state.smooth, state.joints)
    ),
)
def right_after(base: Solved, state: CarState) -> Body:
    """Return the body right after deformation; the same one for the same car."""
    return deformed(base, state)


def deformed(base: Solved, state: CarState) -> Body:
    """Return the network right after deformation, as a body without edits."""
    template = with_joints(base.template, state.joints)
    is_fair = base.mesh is None and base.joint is not None and state.annealed
    if base.mesh is not None:
        network = network_on_mesh(template, base.positions, base.mesh.mesh)
    elif is_fair:
        network = fair_network(template, base.positions)
    else:
        network = Network.of(template, base.positions)
    if state.joints:
        network = smooth_chains(network)
    if state.default_shape and base.joint is not None:
        network = pull_out_panels(network)
        if not is_fair:
            network = with_creases_of_one_side(network)
    if state.smooth:
        network = lock_ratios(network)
    return Body(with_fewer_saddles(network) if is_fair else network, base)
